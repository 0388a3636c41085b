//! The gimbal's messages and commands: those of its manager, which is the autopilot, and those of the device.

use super::super::Vehicle;
use super::super::channel::{AUTOPILOT_COMPONENT, Channel, Outbox};
use super::super::telemetry::wire_quaternion;
use crate::payloads::GIMBAL_COMPONENT;
use crate::payloads::manager::{Asked, Party};
use crate::wire::{CommandRequest, Sender};
use mavlink::dialects::common::*;
use mavlink::types::CharArray;
use nalgebra::UnitQuaternion;
use skein_domain::Geodetic;

const DO_SET_ROI_LOCATION: u16 = 195;
const DO_SET_ROI_NONE: u16 = 197;
const GIMBAL_PITCHYAW: u16 = 1000;
const GIMBAL_CONFIGURE: u16 = 1001;
/// Has neutral and retracted positions; roll, pitch and yaw locked to the horizon and to north, yaw following too; yaw given from
/// north.
const DEVICE_CAPABILITIES: u32 = 1 | 2 | 4 | 16 | 32 | 128 | 256 | 512 | 1024 | 4096;
/// The manager can keep it at a place on Earth besides.
const MANAGER_CAPABILITIES: u32 = DEVICE_CAPABILITIES | 131_072;
/// `GIMBAL_DEVICE_ERROR_FLAGS`: at the end stop of pitch, of yaw.
const AT_PITCH_LIMIT: u32 = 2;
const AT_YAW_LIMIT: u32 = 4;
/// So near to an end stop counts as at it, in radians.
const AT_LIMIT_RAD: f64 = 1e-3;

impl Vehicle {
    /// A message that steers the gimbal came to its manager. Nothing is answered: whoever is not in control is ignored.
    pub(in crate::vehicle) fn take_gimbal_message(&mut self, sender: Sender, message: &MavMessage) {
        let carrier = self.carrier();
        let Some(gimbal) = &mut self.payloads.gimbal else {
            return;
        };
        let settings = gimbal.head.settings;
        let own = self.identity.system_id;
        let for_me = |system: u8, component: u8, device: u8| {
            (system == 0 || system == own)
                && matches!(component, 0 | AUTOPILOT_COMPONENT)
                && matches!(device, 0 | GIMBAL_COMPONENT)
        };
        let asked = match message {
            MavMessage::GIMBAL_MANAGER_SET_ATTITUDE(m)
                if for_me(m.target_system, m.target_component, m.gimbal_device_id) =>
            {
                let velocity = [m.angular_velocity_x, m.angular_velocity_y, m.angular_velocity_z];
                Asked::from_attitude(m.q, velocity, m.flags.bits())
            }
            MavMessage::GIMBAL_MANAGER_SET_PITCHYAW(m)
                if for_me(m.target_system, m.target_component, m.gimbal_device_id) =>
            {
                Asked {
                    pitch_rad: f64::from(m.pitch),
                    yaw_rad: f64::from(m.yaw),
                    pitch_rad_s: f64::from(m.pitch_rate),
                    yaw_rad_s: f64::from(m.yaw_rate),
                    flags: m.flags.bits(),
                }
            }
            MavMessage::GIMBAL_MANAGER_SET_MANUAL_CONTROL(m)
                if for_me(m.target_system, m.target_component, m.gimbal_device_id) =>
            {
                // Shares of what the gimbal can do, -1 to 1.
                let share = |value: f32| f64::from(value.clamp(-1.0, 1.0));
                let pitch = share(m.pitch);
                Asked {
                    pitch_rad: if pitch < 0.0 {
                        -pitch * settings.pitch_min_rad
                    } else {
                        pitch * settings.pitch_max_rad
                    },
                    yaw_rad: share(m.yaw) * settings.yaw_max_rad,
                    pitch_rad_s: share(m.pitch_rate) * settings.rate_max_rad_s,
                    yaw_rad_s: share(m.yaw_rate) * settings.rate_max_rad_s,
                    flags: m.flags.bits(),
                }
            }
            _ => return,
        };
        gimbal.ask((sender.system_id, sender.component_id), &asked, &carrier);
    }

    /// Commands of the gimbal manager; `None` if it is not one of them, or there is no gimbal.
    pub(super) fn run_manager_command(&mut self, by: Party, c: &CommandRequest) -> Option<MavResult> {
        let (carrier, autopilot) = (self.carrier(), (self.identity.system_id, AUTOPILOT_COMPONENT));
        let gimbal = self.payloads.gimbal.as_mut()?;
        let [a, b, rate_a, rate_b] = c.param.map(f64::from);
        match c.command {
            GIMBAL_CONFIGURE => gimbal.configure(by, (c.param[0], c.param[1]), autopilot),
            GIMBAL_PITCHYAW => {
                let asked = Asked {
                    pitch_rad: a.to_radians(),
                    yaw_rad: b.to_radians(),
                    pitch_rad_s: rate_a.to_radians(),
                    yaw_rad_s: rate_b.to_radians(),
                    flags: c.x as u32,
                };
                if !gimbal.ask(by, &asked, &carrier) {
                    return Some(MavResult::MAV_RESULT_DENIED);
                }
            }
            DO_SET_ROI_LOCATION => {
                let place = Geodetic {
                    latitude_deg: c.x,
                    longitude_deg: c.y,
                    altitude_amsl_m: c.z,
                };
                if !place.is_valid() {
                    return Some(MavResult::MAV_RESULT_DENIED);
                }
                gimbal.region_of_interest(Some(place));
            }
            DO_SET_ROI_NONE => gimbal.region_of_interest(None),
            _ => return None,
        }
        Some(MavResult::MAV_RESULT_ACCEPTED)
    }

    pub(super) fn send_gimbal_message(
        &self,
        channel: &mut Channel,
        component: u8,
        message_id: u32,
        out: &mut Outbox,
    ) -> bool {
        if self.payloads.gimbal.is_none() {
            return false;
        }
        match message_id {
            280 => channel.send_as(component, out, &self.gimbal_manager_information()),
            281 => channel.send_as(component, out, &self.gimbal_manager_status()),
            283 => channel.send_as(component, out, &self.gimbal_device_information()),
            285 => channel.send_as(component, out, &self.gimbal_attitude()),
            _ => return false,
        }
        true
    }

    fn gimbal_manager_information(&self) -> GIMBAL_MANAGER_INFORMATION_DATA {
        let settings = self.gimbal_settings();
        GIMBAL_MANAGER_INFORMATION_DATA {
            time_boot_ms: self.up_ms(),
            cap_flags: GimbalManagerCapFlags::from_bits_retain(MANAGER_CAPABILITIES),
            pitch_min: settings.pitch_min_rad as f32,
            pitch_max: settings.pitch_max_rad as f32,
            yaw_min: -settings.yaw_max_rad as f32,
            yaw_max: settings.yaw_max_rad as f32,
            gimbal_device_id: GIMBAL_COMPONENT,
            ..GIMBAL_MANAGER_INFORMATION_DATA::default()
        }
    }

    fn gimbal_manager_status(&self) -> GIMBAL_MANAGER_STATUS_DATA {
        let (flags, (system, component)) = self
            .payloads
            .gimbal
            .as_ref()
            .map_or((0, (0, 0)), |gimbal| (gimbal.flags(), gimbal.owner));
        GIMBAL_MANAGER_STATUS_DATA {
            time_boot_ms: self.up_ms(),
            flags: GimbalManagerFlags::from_bits_retain(flags),
            gimbal_device_id: GIMBAL_COMPONENT,
            primary_control_sysid: system,
            primary_control_compid: component,
            ..GIMBAL_MANAGER_STATUS_DATA::default()
        }
    }

    fn gimbal_device_information(&self) -> GIMBAL_DEVICE_INFORMATION_DATA {
        let settings = self.gimbal_settings();
        GIMBAL_DEVICE_INFORMATION_DATA {
            uid: 0x534B_4749_0000_0000 | u64::from(self.identity.system_id),
            time_boot_ms: self.up_ms(),
            firmware_version: 1,
            hardware_version: 1,
            pitch_min: settings.pitch_min_rad as f32,
            pitch_max: settings.pitch_max_rad as f32,
            yaw_min: -settings.yaw_max_rad as f32,
            yaw_max: settings.yaw_max_rad as f32,
            cap_flags: GimbalDeviceCapFlagsU16::from_bits_retain(DEVICE_CAPABILITIES as u16),
            cap_flags2: GimbalDeviceCapFlags::from_bits_retain(DEVICE_CAPABILITIES),
            vendor_name: CharArray::from("Skein"),
            model_name: CharArray::from("Simulated gimbal"),
            ..GIMBAL_DEVICE_INFORMATION_DATA::default()
        }
    }

    fn gimbal_settings(&self) -> crate::payloads::GimbalSettings {
        self.payloads
            .gimbal
            .as_ref()
            .map_or_else(Default::default, |gimbal| gimbal.head.settings)
    }

    /// Angles about the horizon; yaw from the nose, or from north while it is held there.
    fn gimbal_attitude(&self) -> GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
        let mut message = GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
            time_boot_ms: self.up_ms(),
            ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
        };
        let Some(gimbal) = &self.payloads.gimbal else {
            return message;
        };
        let (carrier, head) = (self.carrier(), &gimbal.head);
        let (yaw_rad, yaw_rate_rad_s) = if gimbal.is_yaw_locked() {
            let rate_rad_s = head.yaw.rate_rad_s + carrier.yaw_rate_rad_s;
            (gimbal.yaw_north_rad(&carrier), rate_rad_s)
        } else {
            (head.yaw.angle_rad, head.yaw.rate_rad_s)
        };
        let turn = UnitQuaternion::from_euler_angles(0.0, head.pitch.angle_rad, yaw_rad);
        message.q = wire_quaternion(&turn);
        message.angular_velocity_y = head.pitch.rate_rad_s as f32;
        message.angular_velocity_z = yaw_rate_rad_s as f32;
        message.flags = GimbalDeviceFlags::from_bits_retain(gimbal.flags() as u16);
        let (pitch, yaw) = head.limits();
        let at_stop = |angle_rad: f64, min_rad: f64, max_rad: f64| {
            angle_rad < min_rad + AT_LIMIT_RAD || angle_rad > max_rad - AT_LIMIT_RAD
        };
        let mut failure = 0;
        if at_stop(head.pitch.angle_rad, pitch.min_rad, pitch.max_rad) {
            failure |= AT_PITCH_LIMIT;
        }
        if at_stop(head.yaw.angle_rad, yaw.min_rad, yaw.max_rad) {
            failure |= AT_YAW_LIMIT;
        }
        message.failure_flags = GimbalDeviceErrorFlags::from_bits_retain(failure);
        message.delta_yaw = carrier.yaw_rad as f32;
        message.delta_yaw_velocity = carrier.yaw_rate_rad_s as f32;
        message
    }
}
