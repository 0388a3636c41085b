//! Commands and setpoints as MAVLink's messages.
//!
//! Must never do: decide what is sent.

use crate::outbox::Outbox;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, MavFrame, PositionTargetTypemask as Mask, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use skein_domain::setpoint::LocalSetpoint;
use skein_px4::commands::CommandOutlet;
use skein_px4::offboard::Wire;
use skein_px4::plan::Command;

/// The way out over MAVLink.
pub struct FramesTo<'a> {
    /// Takes the frames.
    pub outbox: &'a mut Outbox,
    /// System and component that they are for.
    pub target: (u8, u8),
    /// When they are sent, in milliseconds of this node.
    pub stamp_ms: u32,
}

impl CommandOutlet for FramesTo<'_> {
    fn command(&mut self, command: &Command, confirmation: u8) {
        self.outbox.push(&command_long(command, confirmation, self.target));
    }
}

impl Wire for FramesTo<'_> {
    fn setpoint(&mut self, setpoint: &LocalSetpoint) {
        self.outbox.push(&position_target(setpoint, self.stamp_ms, self.target));
    }
}

/// The message.
#[must_use]
pub fn command_long(command: &Command, confirmation: u8, target: (u8, u8)) -> COMMAND_LONG_DATA {
    let [param1, param2, param3, param4, param5, param6, param7] = command.parameters;
    COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command: command.id,
        target_system: target.0,
        target_component: target.1,
        confirmation,
    }
}

/// The setpoint as PX4 reads it: the vehicle's own frame (`MAV_FRAME_LOCAL_NED`, the one that keeps OFFBOARD alive), and every
/// part that is left out masked.
#[must_use]
pub fn position_target(
    setpoint: &LocalSetpoint,
    time_boot_ms: u32,
    target: (u8, u8),
) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    let ignore = |ignored: bool, bits: Mask| if ignored { bits } else { Mask::empty() };
    let type_mask = ignore(setpoint.position.is_none(), Mask::POSITION_TARGET_TYPEMASK_X_IGNORE)
        | ignore(setpoint.position.is_none(), Mask::POSITION_TARGET_TYPEMASK_Y_IGNORE)
        | ignore(setpoint.position.is_none(), Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE)
        | ignore(setpoint.velocity.is_none(), Mask::POSITION_TARGET_TYPEMASK_VX_IGNORE)
        | ignore(setpoint.velocity.is_none(), Mask::POSITION_TARGET_TYPEMASK_VY_IGNORE)
        | ignore(setpoint.velocity.is_none(), Mask::POSITION_TARGET_TYPEMASK_VZ_IGNORE)
        | ignore(
            setpoint.acceleration.is_none(),
            Mask::POSITION_TARGET_TYPEMASK_AX_IGNORE,
        )
        | ignore(
            setpoint.acceleration.is_none(),
            Mask::POSITION_TARGET_TYPEMASK_AY_IGNORE,
        )
        | ignore(
            setpoint.acceleration.is_none(),
            Mask::POSITION_TARGET_TYPEMASK_AZ_IGNORE,
        )
        | ignore(setpoint.yaw_rad.is_none(), Mask::POSITION_TARGET_TYPEMASK_YAW_IGNORE)
        | ignore(
            setpoint.yaw_rate_rad_s.is_none(),
            Mask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE,
        );
    let position = setpoint.position.unwrap_or_default();
    let velocity = setpoint.velocity.unwrap_or_default();
    let acceleration = setpoint.acceleration.unwrap_or_default();
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms,
        x: position.north_m as f32,
        y: position.east_m as f32,
        z: position.down_m as f32,
        vx: velocity.north_m_s as f32,
        vy: velocity.east_m_s as f32,
        vz: velocity.down_m_s as f32,
        afx: acceleration.north_m_s2 as f32,
        afy: acceleration.east_m_s2 as f32,
        afz: acceleration.down_m_s2 as f32,
        yaw: setpoint.yaw_rad.unwrap_or_default() as f32,
        yaw_rate: setpoint.yaw_rate_rad_s.unwrap_or_default() as f32,
        type_mask,
        target_system: target.0,
        target_component: target.1,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
    }
}

#[cfg(test)]
mod tests {
    //! What is left out is masked, and what is given comes through.

    use super::*;
    use proptest::prelude::*;
    use skein_domain::{AccelerationNed, LocalPositionNed, VelocityNed};

    proptest! {
        /// A bit of the mask is set exactly where a part is left out, and the parts that are given come through.
        #[test]
        fn masks_say_what_is_left_out(p: bool, v: bool, a: bool, yaw: bool, rate: bool, x in -1e4..1e4_f64) {
            let setpoint = LocalSetpoint {
                position: p.then(|| LocalPositionNed::new(x, x + 1.0, x + 2.0)),
                velocity: v.then(|| VelocityNed::new(x / 3.0, 4.0, 5.0)),
                acceleration: a.then(|| AccelerationNed::new(6.0, x / 7.0, 8.0)),
                yaw_rad: yaw.then_some(0.25),
                yaw_rate_rad_s: rate.then_some(-0.5),
            };
            let data = position_target(&setpoint, 7, (3, 1));
            let group = |given: bool, bits: u16| if given { 0 } else { bits };
            let expected = group(p, 0x007) | group(v, 0x038) | group(a, 0x1C0) | group(yaw, 0x400) | group(rate, 0x800);
            prop_assert_eq!(data.type_mask.bits(), expected);
            prop_assert_eq!(data.coordinate_frame, MavFrame::MAV_FRAME_LOCAL_NED);
            prop_assert_eq!((data.target_system, data.target_component), (3, 1));
            prop_assert_eq!(data.x, if p { x as f32 } else { 0.0 });
            prop_assert_eq!(data.vx, if v { (x / 3.0) as f32 } else { 0.0 });
            prop_assert_eq!(data.afy, if a { (x / 7.0) as f32 } else { 0.0 });
            prop_assert_eq!(data.yaw, if yaw { 0.25 } else { 0.0 });
        }
    }
}
