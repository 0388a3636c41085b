//! What a payload may send to its vehicle over MAVLink: what payloads of its kind are for, to its own vehicle, and nothing that
//! flies it, arms it, or changes what its autopilot is set to.
//!
//! Must never do: let a message through that is not named here. The lists say what is permitted, never what is forbidden.

use crate::gate::Gate;
use skein_domain::payload::{MavlinkMessage, PayloadKind};
use skein_domain::{Refusal, SystemId};
use std::ops::RangeInclusive;

/// Ids of the messages that carry a command.
const COMMAND_INT: u32 = 75;
const COMMAND_LONG: u32 = 76;

/// `MAV_CMD_SET_MESSAGE_INTERVAL` and `MAV_CMD_REQUEST_MESSAGE`: their first parameter is a message's id.
const SET_MESSAGE_INTERVAL: u16 = 511;
const REQUEST_MESSAGE: u16 = 512;
/// No message may be asked for more often than this, in microseconds: the vehicle's link carries its flight too.
const SHORTEST_INTERVAL_US: f32 = 10_000.0;

/// A message that gimbals are steered with: its id, and where its target system stands in the payload.
const GIMBAL_MESSAGES: [(u32, usize); 4] = [
    // GIMBAL_MANAGER_SET_ATTITUDE, _SET_PITCHYAW, _SET_MANUAL_CONTROL; GIMBAL_DEVICE_SET_ATTITUDE.
    (282, 32),
    (287, 20),
    (288, 20),
    (284, 30),
];
/// Region of interest at a place, by the next waypoint, none, of a vehicle; the manager's pitch and yaw, and who has control.
const GIMBAL_COMMANDS: [u16; 6] = [195, 196, 197, 198, 1000, 1001];
/// GIMBAL_MANAGER_INFORMATION and _STATUS, GIMBAL_DEVICE_INFORMATION and _ATTITUDE_STATUS.
const GIMBAL_REPORTS: [u32; 4] = [280, 281, 283, 285];

/// PARAM_EXT_REQUEST_READ, PARAM_EXT_REQUEST_LIST, PARAM_EXT_SET: a camera's own settings, and where the target system stands.
/// The target component follows it.
const CAMERA_SETTINGS: [(u32, usize); 3] = [(320, 2), (321, 0), (323, 0)];
/// Commands of the camera protocol. 521, 522, 525, 527: what was asked for by a command each before REQUEST_MESSAGE. 526: format the
/// storage; 529 to 534: reset the settings, mode, zoom, focus, use of the storage, source. 2000 to 2003: start and stop pictures, one
/// that was missed, the trigger. 2004, 2005, 2010: keep a point or a rectangle of the picture in view, stop that. 2500 to 2505:
/// record, stop, stream, stop, information and status of a stream.
const CAMERA_COMMANDS: [u16; 24] = [
    521, 522, 525, 526, 527, 529, 530, 531, 532, 533, 534, 2000, 2001, 2002, 2003, 2004, 2005, 2010, 2500, 2501, 2502,
    2503, 2504, 2505,
];
/// STORAGE_FORMAT and SET_STORAGE_USAGE: an autopilot has a storage too, with its logs and missions on it.
const STORAGE_COMMANDS: [u16; 2] = [526, 533];
/// Starts a recording; its second parameter says how often per second the camera is to report meanwhile.
const VIDEO_START_CAPTURE: u16 = 2500;
/// Information, settings, storage, capture status, image captured, stream information and status, field of view, tracking in the
/// picture and on the ground, thermal range.
const CAMERA_REPORTS: [u32; 11] = [259, 260, 261, 262, 263, 269, 270, 271, 275, 276, 277];

/// The component ids that are cameras'.
const CAMERA_COMPONENTS: RangeInclusive<u8> = 100..=105;

impl Gate {
    /// Whether a payload of this kind may send this message to its vehicle. It may send what payloads of its kind are for, and to
    /// its own vehicle's system only.
    ///
    /// A radio may send nothing: MAVLink has no message that sets a telemetry radio's channel or power at one vehicle (SiK radios
    /// are set through SERIAL_CONTROL, which reaches the autopilot's shell as well). A detector may send nothing either.
    ///
    /// # Errors
    /// [`Refusal::NotPermitted`] with the reason in words.
    pub fn payload_message(
        &self,
        kind: PayloadKind,
        vehicle_system_id: SystemId,
        message: &MavlinkMessage,
    ) -> Result<(), Refusal> {
        let fields = Fields(&message.payload);
        let id = message.message_id;
        match kind {
            PayloadKind::Gimbal => {
                if let Some(target_at) = target_at(&GIMBAL_MESSAGES, id) {
                    return to_own_system(vehicle_system_id, fields.byte(target_at));
                }
                if matches!(id, COMMAND_LONG | COMMAND_INT) {
                    return command("gimbal", vehicle_system_id, &fields, &GIMBAL_COMMANDS, &GIMBAL_REPORTS);
                }
                Err(Refusal::not_permitted(format!("a gimbal does not send message {id}")))
            }
            PayloadKind::Camera => {
                if let Some(target_at) = target_at(&CAMERA_SETTINGS, id) {
                    to_own_system(vehicle_system_id, fields.byte(target_at))?;
                    return to_a_camera(fields.byte(target_at + 1));
                }
                if id == COMMAND_LONG {
                    command("camera", vehicle_system_id, &fields, &CAMERA_COMMANDS, &CAMERA_REPORTS)?;
                    return bounds_of_camera_command(&fields);
                }
                Err(Refusal::not_permitted(format!("a camera does not send message {id}")))
            }
            PayloadKind::Radio => Err(Refusal::not_permitted(format!(
                "a radio does not send message {id}: no message of MAVLink sets a radio"
            ))),
            PayloadKind::Detector => Err(Refusal::not_permitted(format!("a detector does not send message {id}"))),
        }
    }
}

/// Where the target system stands in a message that is permitted.
fn target_at(permitted: &[(u32, usize)], message_id: u32) -> Option<usize> {
    permitted
        .iter()
        .find(|(id, _)| *id == message_id)
        .map(|(_, target_at)| *target_at)
}

/// COMMAND_LONG and COMMAND_INT have the fields that matter here at the same places.
fn command(
    sender: &str,
    vehicle_system_id: SystemId,
    fields: &Fields<'_>,
    permitted: &[u16],
    reports: &[u32],
) -> Result<(), Refusal> {
    let (number, target_system) = (fields.word(28), fields.byte(30));
    to_own_system(vehicle_system_id, target_system)?;
    match number {
        number if permitted.contains(&number) => Ok(()),
        REQUEST_MESSAGE => report(sender, fields.float(0), reports),
        SET_MESSAGE_INTERVAL => {
            report(sender, fields.float(0), reports)?;
            let interval_us = fields.float(4);
            // -1 turns it off, 0 asks for the default.
            let slow_enough = interval_us.is_finite() && interval_us >= SHORTEST_INTERVAL_US;
            if interval_us == -1.0 || interval_us == 0.0 || slow_enough {
                Ok(())
            } else {
                Err(Refusal::not_permitted(format!(
                    "a message every {interval_us} µs: not more often than every {SHORTEST_INTERVAL_US} µs"
                )))
            }
        }
        number => Err(Refusal::not_permitted(format!(
            "a {sender} does not send command {number}"
        ))),
    }
}

/// What commands to a camera that are permitted must keep to besides.
fn bounds_of_camera_command(fields: &Fields<'_>) -> Result<(), Refusal> {
    match fields.word(28) {
        number if STORAGE_COMMANDS.contains(&number) => to_a_camera(fields.byte(31)),
        VIDEO_START_CAPTURE if fields.float(4) > 1e6 / SHORTEST_INTERVAL_US => Err(Refusal::not_permitted(format!(
            "{} reports per second while it records: not more often than every {SHORTEST_INTERVAL_US} µs",
            fields.float(4)
        ))),
        _ => Ok(()),
    }
}

/// Whether a report may be asked for; its id comes as a number with a fraction.
fn report(sender: &str, asked: f32, reports: &[u32]) -> Result<(), Refusal> {
    if reports.iter().any(|id| *id as f32 == asked) {
        Ok(())
    } else {
        Err(Refusal::not_permitted(format!(
            "a {sender} does not ask for message {asked}"
        )))
    }
}

fn to_own_system(own: SystemId, target_system: u8) -> Result<(), Refusal> {
    if target_system == own.0 {
        Ok(())
    } else {
        Err(Refusal::not_permitted(format!(
            "the message is for system {target_system}, its vehicle is system {own}"
        )))
    }
}

/// Settings and storage are a camera's own, never the autopilot's or another part's.
fn to_a_camera(target_component: u8) -> Result<(), Refusal> {
    if CAMERA_COMPONENTS.contains(&target_component) {
        Ok(())
    } else {
        Err(Refusal::not_permitted(format!(
            "a camera's settings and storage are its own, not those of component {target_component}"
        )))
    }
}

/// A payload whose trailing zeros may have been cut off.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn byte(&self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.byte(at), self.byte(at + 1)])
    }

    fn float(&self, at: usize) -> f32 {
        f32::from_le_bytes([self.byte(at), self.byte(at + 1), self.byte(at + 2), self.byte(at + 3)])
    }
}

#[cfg(test)]
mod tests;
