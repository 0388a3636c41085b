//! What is sent to PX4: setpoints and commands as messages.
//!
//! Must never do: send a number that was not given; what is left out is not a number, which PX4 takes for "not controlled".

use crate::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use skein_domain::setpoint::LocalSetpoint;
use skein_px4::plan::Command;

/// Something for the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub enum Outgoing {
    /// A command.
    Command(VehicleCommand),
    /// A setpoint, with what of it counts; that goes first.
    Setpoint(OffboardControlMode, TrajectorySetpoint),
}

/// Who sends.
#[derive(Debug, Clone, Copy)]
pub struct Sender {
    /// System id of the node.
    pub system_id: u8,
    /// Component id of the node.
    pub component_id: u8,
}

/// A command to the autopilot of a vehicle.
#[must_use]
pub fn command(command: &Command, confirmation: u8, stamp_us: u64, target_system: u8, from: Sender) -> VehicleCommand {
    let [param1, param2, param3, param4, param5, param6, param7] = command.parameters;
    VehicleCommand {
        timestamp: stamp_us,
        param1,
        param2,
        param3,
        param4,
        param5: f64::from(param5),
        param6: f64::from(param6),
        param7,
        command: u32::from(command.number()),
        target_system,
        target_component: skein_px4::AUTOPILOT_COMPONENT,
        source_system: from.system_id,
        source_component: u16::from(from.component_id),
        confirmation,
        // Of others PX4 takes no command.
        from_external: true,
    }
}

/// A setpoint. The first true value of the mode says which controller leads; the others' parts are fed forward.
#[must_use]
pub fn setpoint(setpoint: &LocalSetpoint, stamp_us: u64) -> Outgoing {
    let unset = [f32::NAN; 3];
    let three = |given: Option<[f64; 3]>| given.map_or(unset, |parts| parts.map(|part| part as f32));
    let one = |given: Option<f64>| given.map_or(f32::NAN, |value| value as f32);
    let position = setpoint.position.map(|p| [p.north_m, p.east_m, p.down_m]);
    let velocity = setpoint.velocity.map(|v| [v.north_m_s, v.east_m_s, v.down_m_s]);
    let acceleration = setpoint.acceleration.map(|a| [a.north_m_s2, a.east_m_s2, a.down_m_s2]);
    let mode = OffboardControlMode {
        timestamp: stamp_us,
        position: position.is_some(),
        velocity: velocity.is_some(),
        acceleration: acceleration.is_some(),
        attitude: false,
        body_rate: false,
        thrust_and_torque: false,
        direct_actuator: false,
    };
    let setpoint = TrajectorySetpoint {
        timestamp: stamp_us,
        position: three(position),
        velocity: three(velocity),
        acceleration: three(acceleration),
        jerk: unset,
        yaw: one(setpoint.yaw_rad),
        yawspeed: one(setpoint.yaw_rate_rad_s),
    };
    Outgoing::Setpoint(mode, setpoint)
}
