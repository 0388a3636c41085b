//! How a gimbal behind a manager is turned, by what that manager can.
//!
//! Three ways are in the protocol, and managers differ in which they know:
//!
//! * the command DO_GIMBAL_MANAGER_PITCHYAW (1000), which is acknowledged: a single move goes by it, so that a refusal is heard. PX4
//!   denies it to whoever is not in control. Not for rates: PX4 takes an angle that is no number for level and ahead;
//! * the message GIMBAL_MANAGER_SET_ATTITUDE (282), which is not: whatever is sent again and again goes by it, and a single move that was
//!   acknowledged but not reached yet, or by a manager that does not know the command. PX4 and ArduPilot take it. Either the attitude
//!   or the velocity is a number, never both;
//! * the message GIMBAL_MANAGER_SET_PITCHYAW (287), which says the same as 282 with angles. PX4 does not know it and drops it without a
//!   word, so it is never sent. GIMBAL_MANAGER_SET_MANUAL_CONTROL (288) has no unit in which to say an angle.
//!
//! Nothing that a manager says of itself names the messages it knows; so what is chosen is what all of them know.

use super::{Errand, Manager};
use crate::attitude::{Direction, Limits, Yaw};
use crate::orders::{Moment, Turn};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, GIMBAL_MANAGER_SET_ATTITUDE_DATA, GimbalManagerCapFlags, GimbalManagerFlags, MavCmd,
};
use nalgebra::UnitQuaternion;
use payload_mavlink::send;
use skein_domain::frames::wrap_angle_rad;
use skein_plugin_sdk::Effects;
use std::f64::consts::PI;

/// Nearer to the end of the circle than this, in radians, servos are told a yaw from the nose: the vehicle turns meanwhile.
const NEAR_END_RAD: f64 = 0.1;
/// Moves that follow each other faster than this, in seconds, are a stream.
const STREAM_PAUSE_S: f64 = 0.5;

impl Manager {
    pub(crate) fn turn(&mut self, at: &Moment, turn: Turn, effects: &mut Effects) {
        match turn {
            Turn::Once(direction) if !self.by_messages_only && !at.within(self.turn_asked, STREAM_PAUSE_S) => {
                self.turn_asked = Some(at.now);
                // An earlier move that nobody acknowledged yet is out of date.
                self.requests.forget(&Errand::Turn);
                // The next tick sends it.
                self.requests.ask(Errand::Turn, &self.pitch_yaw(direction));
            }
            Turn::Once(direction) | Turn::To(direction) => {
                let (flags, yaw_rad) = frame(self.reachable(at, direction.yaw));
                let turn = UnitQuaternion::from_euler_angles(0.0, direction.pitch_rad, yaw_rad);
                let message = GIMBAL_MANAGER_SET_ATTITUDE_DATA {
                    flags,
                    q: [turn.w, turn.i, turn.j, turn.k].map(|value| value as f32),
                    ..self.still()
                };
                send(&message, effects);
            }
            Turn::At(rates) => {
                let message = GIMBAL_MANAGER_SET_ATTITUDE_DATA {
                    angular_velocity_x: 0.0,
                    angular_velocity_y: rates.pitch_rad_s as f32,
                    angular_velocity_z: rates.yaw_rad_s as f32,
                    ..self.still()
                };
                send(&message, effects);
            }
        }
    }

    /// A message that asks for nothing yet.
    fn still(&self) -> GIMBAL_MANAGER_SET_ATTITUDE_DATA {
        GIMBAL_MANAGER_SET_ATTITUDE_DATA {
            flags: frame(Yaw::Vehicle(0.0)).0,
            q: [f32::NAN; 4],
            angular_velocity_x: f32::NAN,
            angular_velocity_y: f32::NAN,
            angular_velocity_z: f32::NAN,
            target_system: self.system_id,
            target_component: self.component.unwrap_or_default(),
            gimbal_device_id: self.device,
        }
    }

    fn pitch_yaw(&self, direction: Direction) -> COMMAND_LONG_DATA {
        let (flags, yaw_rad) = frame(direction.yaw);
        COMMAND_LONG_DATA {
            param1: direction.pitch_rad.to_degrees() as f32,
            param2: yaw_rad.to_degrees() as f32,
            param3: f32::NAN,
            param4: f32::NAN,
            // Flags below 2^24 are exact.
            param5: flags.bits() as f32,
            param6: 0.0,
            param7: f32::from(self.device),
            command: MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
            target_system: self.system_id,
            target_component: self.component.unwrap_or_default(),
            ..COMMAND_LONG_DATA::default()
        }
    }

    /// The same yaw, as servos get there: PX4 takes the vehicle's yaw from one to north without going round the circle (as long as
    /// MNT_RC_IN_MODE is not 0), so that they would stand at their end stop with the vehicle between the two. From the nose is right then.
    fn reachable(&self, at: &Moment, yaw: Yaw) -> Yaw {
        match (yaw, at.vehicle_yaw_rad) {
            (Yaw::North(north_rad), Some(nose_rad)) if self.has_servos() => {
                let (north_rad, nose_rad) = (wrap_angle_rad(north_rad), wrap_angle_rad(nose_rad));
                if (north_rad - nose_rad).abs() > PI - NEAR_END_RAD {
                    Yaw::Vehicle(wrap_angle_rad(north_rad - nose_rad))
                } else {
                    yaw
                }
            }
            _ => yaw,
        }
    }

    /// Whether it keeps to north by itself when the vehicle turns. Servos do not all the way: see [`Self::reachable`].
    pub(crate) fn holds_north(&self) -> bool {
        let holds = GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK
            | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME;
        !self.has_servos() && self.can(holds)
    }

    /// Whether rates are for it to keep. Not where an autopilot turns servos: PX4 integrates a rate behind the filter of its outputs,
    /// and with that at its default (MNT_TAU 0.3 s) the gimbal turns at a thirtieth of the rate. Such a one is told angles that move.
    pub(crate) fn turns_at_rates(&self) -> bool {
        !self.has_servos()
    }

    /// How far it can turn; an axis that it does not have stays at zero.
    pub(super) fn limits(&self) -> Option<Limits> {
        use GimbalManagerCapFlags as Can;
        let limits = self.manager_limits.or(self.device_limits);
        let pitches = self.can(
            Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
                | Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW
                | Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK,
        );
        let yaws = self.can(
            Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
                | Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW
                | Can::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK,
        );
        if pitches && yaws {
            return limits;
        }
        Some(limits.unwrap_or(Limits::ANY).of_axes(pitches, yaws))
    }

    /// Whether it can any of these; one that says nothing is taken to.
    fn can(&self, any: GimbalManagerCapFlags) -> bool {
        self.capabilities
            .is_none_or(|bits| GimbalManagerCapFlags::from_bits_retain(bits).intersects(any))
    }
}

/// The flags for a yaw, and its number in radians. Roll and pitch are held to the horizon. The lock alone tells PX4 in which frame the
/// yaw is; others go by the frame that is named besides.
fn frame(yaw: Yaw) -> (GimbalManagerFlags, f64) {
    let level =
        GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_ROLL_LOCK | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_PITCH_LOCK;
    match yaw {
        Yaw::North(yaw_rad) => (
            level
                | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_YAW_LOCK
                | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME,
            yaw_rad,
        ),
        Yaw::Vehicle(yaw_rad) => (
            level | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME,
            yaw_rad,
        ),
    }
}
