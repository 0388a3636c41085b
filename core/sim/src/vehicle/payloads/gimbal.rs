//! The gimbal's messages and commands: those of its manager, which is the autopilot, and those of the device.

use super::super::SimVehicle;
use super::super::channel::{AUTOPILOT_COMPONENT, Channel, Outbox};
use super::super::telemetry::wire_quaternion;
use crate::wire::{CommandRequest, Sender};
use mavlink::dialects::common::*;
use mavlink::types::CharArray;
use nalgebra::UnitQuaternion;
use skein_domain::Geodetic;
use skein_sim_payloads::manager::{Asked, Party};
use skein_sim_payloads::{GIMBAL_COMPONENT, GimbalOutput, GimbalSettings};
use std::f64::consts::FRAC_PI_6;

const DO_SET_ROI_LOCATION: u16 = 195;
const DO_SET_ROI_NONE: u16 = 197;
pub(in crate::vehicle) const GIMBAL_PITCHYAW: u16 = 1000;
pub(in crate::vehicle) const GIMBAL_CONFIGURE: u16 = 1001;
/// Has neutral and retracted positions; roll, pitch and yaw locked to the horizon and to north, yaw following too; yaw given from
/// north.
const DEVICE_CAPABILITIES: u32 = 1 | 2 | 4 | 16 | 32 | 128 | 256 | 512 | 1024 | 4096;
/// What PX4's manager says of servos: neutral, locks of all axes, turns in pitch and yaw, can keep a place on Earth in view.
const SERVO_CAPABILITIES: u32 = 2 | 16 | 32 | 128 | 256 | 1024 | 131_072;
/// The id of a device that the autopilot turns by servos.
const SERVO_DEVICE: u8 = 1;
/// MNT_RATE_PITCH and MNT_RATE_YAW, 30 degrees per second.
const MANUAL_RATE_RAD_S: f64 = FRAC_PI_6;
/// `GIMBAL_DEVICE_ERROR_FLAGS`: at the end stop of pitch, of yaw.
const AT_PITCH_LIMIT: u32 = 2;
const AT_YAW_LIMIT: u32 = 4;
/// So near to an end stop counts as at it, in radians.
const AT_LIMIT_RAD: f64 = 1e-3;

impl SimVehicle {
    /// A message that steers the gimbal came to its manager. Nothing is answered: whoever is not in control is ignored.
    pub(in crate::vehicle) fn take_gimbal_message(&mut self, sender: Sender, message: &MavMessage) {
        let carrier = self.carrier();
        let Some(gimbal) = &mut self.payloads.gimbal else {
            return;
        };
        let (own_device, own) = (device_id(&gimbal.head.settings), self.identity.system_id);
        let for_me = |system: u8, component: u8, device: u8| {
            (system == 0 || system == own)
                && matches!(component, 0 | AUTOPILOT_COMPONENT)
                && (device == 0 || device == own_device)
        };
        let asked = match message {
            MavMessage::GIMBAL_MANAGER_SET_ATTITUDE(m)
                if for_me(m.target_system, m.target_component, m.gimbal_device_id) =>
            {
                let velocity = [m.angular_velocity_x, m.angular_velocity_y, m.angular_velocity_z];
                Asked::from_attitude(m.q, velocity, m.flags.bits())
            }
            MavMessage::GIMBAL_MANAGER_SET_MANUAL_CONTROL(m)
                if for_me(m.target_system, m.target_component, m.gimbal_device_id) =>
            {
                // PX4 takes the shares of a deflection for radians, and a rate for a share of MNT_RATE_PITCH and _YAW.
                let both = |a: f32, b: f32| {
                    let known = a.is_finite() && b.is_finite();
                    if known {
                        (f64::from(a), f64::from(b))
                    } else {
                        (f64::NAN, f64::NAN)
                    }
                };
                let (pitch_rad, yaw_rad) = both(m.pitch, m.yaw);
                let (pitch_share, yaw_share) = both(m.pitch_rate, m.yaw_rate);
                Asked {
                    pitch_rad,
                    yaw_rad,
                    pitch_rad_s: pitch_share * MANUAL_RATE_RAD_S,
                    yaw_rad_s: yaw_share * MANUAL_RATE_RAD_S,
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
                // Unlike in the messages, an angle that is no number is level and ahead.
                let angle = |deg: f64| if deg.is_finite() { deg.to_radians() } else { 0.0 };
                let asked = Asked {
                    pitch_rad: angle(a),
                    yaw_rad: angle(b),
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
        let Some(gimbal) = &self.payloads.gimbal else {
            return false;
        };
        let by_servos = is_by_servos(&gimbal.head.settings);
        match (message_id, by_servos) {
            (265, true) => channel.send_as(component, out, &self.mount_orientation()),
            (280, _) => channel.send_as(component, out, &self.gimbal_manager_information()),
            (281, _) => channel.send_as(component, out, &self.gimbal_manager_status()),
            (283, false) => channel.send_as(component, out, &self.gimbal_device_information()),
            (285, _) if by_servos == (component == AUTOPILOT_COMPONENT) => {
                channel.send_as(component, out, &self.gimbal_attitude());
            }
            _ => return false,
        }
        true
    }

    fn gimbal_manager_information(&self) -> GIMBAL_MANAGER_INFORMATION_DATA {
        let settings = self.gimbal_settings();
        let capabilities = if is_by_servos(&settings) {
            SERVO_CAPABILITIES
        } else {
            DEVICE_CAPABILITIES
        };
        GIMBAL_MANAGER_INFORMATION_DATA {
            time_boot_ms: self.up_ms(),
            cap_flags: GimbalManagerCapFlags::from_bits_retain(capabilities),
            pitch_min: settings.pitch_min_rad as f32,
            pitch_max: settings.pitch_max_rad as f32,
            yaw_min: -settings.yaw_max_rad as f32,
            yaw_max: settings.yaw_max_rad as f32,
            gimbal_device_id: device_id(&settings),
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
            gimbal_device_id: device_id(&self.gimbal_settings()),
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

    fn gimbal_settings(&self) -> GimbalSettings {
        self.payloads
            .gimbal
            .as_ref()
            .map_or_else(Default::default, |gimbal| gimbal.head.settings)
    }

    /// How the servos stand to the vehicle, in degrees: PX4 has nothing that would measure it, and means the angles it puts out.
    #[expect(deprecated, reason = "PX4 sends it, and nothing else of servos is true")]
    fn mount_orientation(&self) -> MOUNT_ORIENTATION_DATA {
        let mut message = MOUNT_ORIENTATION_DATA {
            time_boot_ms: self.up_ms(),
            ..MOUNT_ORIENTATION_DATA::default()
        };
        if let Some(gimbal) = &self.payloads.gimbal {
            let (roll_rad, pitch_rad) = self.body.roll_pitch_rad();
            message.roll = -roll_rad.to_degrees() as f32;
            message.pitch = (gimbal.head.pitch.angle_rad - pitch_rad).to_degrees() as f32;
            message.yaw = gimbal.head.yaw.angle_rad.to_degrees() as f32;
            message.yaw_absolute = gimbal.yaw_north_rad(&self.carrier()).to_degrees().rem_euclid(360.0) as f32;
        }
        message
    }

    /// Angles about the horizon; yaw from the nose, or from north while it is held there. Of servos it is what was asked for.
    fn gimbal_attitude(&self) -> GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
        let mut message = GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
            time_boot_ms: self.up_ms(),
            ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
        };
        let Some(gimbal) = &self.payloads.gimbal else {
            return message;
        };
        let (carrier, head) = (self.carrier(), &gimbal.head);
        message.flags = GimbalDeviceFlags::from_bits_retain(gimbal.flags() as u16);
        if is_by_servos(&head.settings) {
            let (pitch_rad, yaw_rad) = gimbal.asked_rad(&carrier);
            message.q = wire_quaternion(&UnitQuaternion::from_euler_angles(0.0, pitch_rad, yaw_rad));
            message.gimbal_device_id = SERVO_DEVICE;
            return message;
        }
        let yaw_rad = gimbal.yaw_held_rad(&carrier);
        let drift_rad_s = if gimbal.is_yaw_locked() {
            carrier.yaw_rate_rad_s
        } else {
            0.0
        };
        message.q = wire_quaternion(&UnitQuaternion::from_euler_angles(0.0, head.pitch.angle_rad, yaw_rad));
        message.angular_velocity_y = head.pitch.rate_rad_s as f32;
        message.angular_velocity_z = (head.yaw.rate_rad_s + drift_rad_s) as f32;
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

fn is_by_servos(settings: &GimbalSettings) -> bool {
    matches!(settings.output, GimbalOutput::Servos { .. })
}

fn device_id(settings: &GimbalSettings) -> u8 {
    if is_by_servos(settings) {
        SERVO_DEVICE
    } else {
        GIMBAL_COMPONENT
    }
}
