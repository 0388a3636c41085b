//! Kinds of vehicles: the same autopilot with other parameters, so that swarms can be mixed.

use crate::vehicle::ParameterValue;

/// What kind of vehicle it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Airframe {
    /// PX4's default quadrotor: 12 m/s, 5 m/s in automatic modes.
    #[default]
    Quadrotor,
    /// A heavy carrier of a camera: 5 m/s, slow to climb, to speed up and to turn, and it flies level for the picture's sake.
    CameraCarrier,
}

impl Airframe {
    /// The parameters in which it differs from PX4's defaults.
    #[must_use]
    pub fn parameters(self) -> Vec<(&'static str, ParameterValue)> {
        use ParameterValue::Real;
        match self {
            Self::Quadrotor => Vec::new(),
            Self::CameraCarrier => vec![
                ("MPC_XY_VEL_MAX", Real(5.0)),
                ("MPC_XY_CRUISE", Real(4.0)),
                ("MPC_ACC_HOR", Real(1.5)),
                ("MPC_ACC_HOR_MAX", Real(2.0)),
                ("MPC_JERK_AUTO", Real(3.0)),
                ("MPC_TILTMAX_AIR", Real(20.0)),
                ("MPC_Z_VEL_MAX_UP", Real(1.5)),
                ("MPC_Z_VEL_MAX_DN", Real(1.0)),
                ("MPC_Z_V_AUTO_UP", Real(1.5)),
                ("MPC_Z_V_AUTO_DN", Real(1.0)),
                ("MPC_TKO_SPEED", Real(1.0)),
                ("MPC_YAWRAUTO_MAX", Real(30.0)),
            ],
        }
    }
}
