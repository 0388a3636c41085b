//! What the parameters say about how the vehicle may move.

use super::guidance::GuidanceLimits;
use super::parameters::Parameters;
use super::position_control::ControlLimits;

/// Everything taken from the parameters that is needed in every step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Of the position control.
    pub control: ControlLimits,
    /// Of the automatic modes.
    pub guidance: GuidanceLimits,
    /// Fastest turn of the automatic modes in radians per second.
    pub yaw_auto_rad_s: f64,
    /// Time of the motors' run-up in seconds.
    pub spool_up_s: f64,
    /// Time from landing to disarming in seconds.
    pub disarm_after_landing_s: f64,
    /// Time from arming to disarming without a take-off in seconds.
    pub disarm_idle_s: f64,
    /// Time without a setpoint after which OFFBOARD is left, in seconds.
    pub setpoint_timeout_s: f64,
    /// What is done then.
    pub loss_action: i32,
    /// Height of a take-off without one in metres.
    pub take_off_height_m: f64,
}

/// The limits that parameters set.
pub(super) fn limits_from(p: &Parameters) -> Limits {
    Limits {
        control: ControlLimits {
            horizontal_m_s: p.number("MPC_XY_VEL_MAX"),
            up_m_s: p.number("MPC_Z_VEL_MAX_UP"),
            down_m_s: p.number("MPC_Z_VEL_MAX_DN"),
            tilt_rad: p.number("MPC_TILTMAX_AIR").to_radians(),
        },
        guidance: GuidanceLimits {
            cruise_m_s: p.number("MPC_XY_CRUISE"),
            up_m_s: p.number("MPC_Z_V_AUTO_UP"),
            down_m_s: p.number("MPC_Z_V_AUTO_DN"),
            take_off_m_s: p.number("MPC_TKO_SPEED"),
            land_m_s: p.number("MPC_LAND_SPEED"),
            crawl_m_s: p.number("MPC_LAND_CRWL"),
            slow_from_m: p.number("MPC_LAND_ALT1"),
            slow_below_m: p.number("MPC_LAND_ALT2"),
            return_height_m: p.number("RTL_RETURN_ALT"),
            acceleration_m_s2: p.number("MPC_ACC_HOR").max(0.1),
            jerk_m_s3: p.number("MPC_JERK_AUTO").max(0.1),
        },
        yaw_auto_rad_s: p.number("MPC_YAWRAUTO_MAX").to_radians(),
        spool_up_s: p.number("COM_SPOOLUP_TIME"),
        disarm_after_landing_s: p.number("COM_DISARM_LAND"),
        disarm_idle_s: p.number("COM_DISARM_PRFLT"),
        setpoint_timeout_s: p.number("COM_OF_LOSS_T"),
        loss_action: p.number("COM_OBL_RC_ACT") as i32,
        take_off_height_m: p.number("MIS_TAKEOFF_ALT"),
    }
}
