//! Kinds of vehicles: the same autopilot with other parameters, and how each answers to it, so that swarms can be mixed.

use crate::parameter_value::ParameterValue;

/// What kind of vehicle it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Airframe {
    /// PX4's default quadrotor: 12 m/s, 5 m/s in automatic modes.
    #[default]
    Quadrotor,
    /// A heavy carrier of a camera: 5 m/s, slow to climb, to speed up and to turn, and it flies level for the picture's sake.
    CameraCarrier,
    /// The quadrotor of PX4's own simulation in hardware (SIH), as six of them were recorded: through air that slows it down four times as
    /// strongly as a real one, and slow to tilt.
    Sih,
}

/// How an airframe answers to what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Linear drag per mass in 1/s: the speed lost per second, per speed through the air.
    pub drag_per_s: f64,
    /// How fast the tilt follows: an attitude loop, in 1/s,
    pub attitude_gain_per_s: f64,
    /// round a body-rate loop with this lag in seconds.
    pub rate_lag_s: f64,
}

impl Airframe {
    /// How it answers.
    #[must_use]
    pub fn response(self) -> Response {
        match self {
            Self::Quadrotor | Self::CameraCarrier => Response {
                drag_per_s: 0.25,
                attitude_gain_per_s: 6.5,
                rate_lag_s: 0.045,
            },
            Self::Sih => Response {
                drag_per_s: 1.0,
                attitude_gain_per_s: 3.45,
                rate_lag_s: 0.058,
            },
        }
    }

    /// The parameters in which it differs from PX4's defaults.
    #[must_use]
    pub fn parameters(self) -> Vec<(&'static str, ParameterValue)> {
        use ParameterValue::Real;
        match self {
            Self::Quadrotor | Self::Sih => Vec::new(),
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
