//! The airframe: a point mass under a thrust vector that lags behind what is asked of it, with drag, wind and a ground.
//!
//! Axes are north, east, down about the place where the vehicle stood at its start; the ground there is at zero.

use crate::airframe::Response;
use nalgebra::Vector3;
use skein_domain::frames::wrap_angle_rad;

/// Standard gravity in metres per second squared.
pub(crate) const GRAVITY_M_S2: f64 = 9.806_65;

/// The rate of tilting is bounded, in radians per second.
const TILT_RATE_MAX_RAD_S: f64 = 3.84;
/// Lag of the motors in seconds.
const MOTOR_LAG_S: f64 = 0.04;
const YAW_GAIN_PER_S: f64 = 2.8;
const YAW_LAG_S: f64 = 0.1;

/// What the motors are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    /// Thrust per mass as a vector in metres per second squared; zero = motors off or idle.
    pub force: Vector3<f64>,
    /// Yaw to turn to in radians.
    pub yaw_rad: f64,
    /// Yaw rate on top of that, in radians per second.
    pub yaw_rate_rad_s: f64,
    /// Bound of the yaw rate in radians per second.
    pub yaw_rate_max_rad_s: f64,
}

impl Drive {
    /// Motors off.
    pub(crate) fn off(yaw_rad: f64) -> Self {
        Self {
            force: Vector3::zeros(),
            yaw_rad,
            yaw_rate_rad_s: 0.0,
            yaw_rate_max_rad_s: 0.0,
        }
    }
}

/// State of the airframe.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    response: Response,
    /// Metres north, east, down of the start.
    pub position: Vector3<f64>,
    /// Metres per second.
    pub velocity: Vector3<f64>,
    /// Metres per second squared, without gravity's share when at rest on the ground.
    pub acceleration: Vector3<f64>,
    /// Unit vector of the thrust; straight up is (0, 0, -1).
    pub up: Vector3<f64>,
    /// Turning rate of that vector in radians per second.
    pub spin: Vector3<f64>,
    /// Thrust per mass in metres per second squared.
    pub thrust_m_s2: f64,
    /// Radians, clockwise from north.
    pub yaw_rad: f64,
    /// Radians per second.
    pub yaw_rate_rad_s: f64,
    /// Stands on the ground.
    pub on_ground: bool,
    /// Hardest touch-down so far in metres per second.
    pub touch_down_max_m_s: f64,
}

impl Body {
    /// At rest on the ground.
    pub(crate) fn new(response: Response, yaw_rad: f64) -> Self {
        Self {
            response,
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            up: -Vector3::z(),
            spin: Vector3::zeros(),
            thrust_m_s2: 0.0,
            yaw_rad: wrap_angle_rad(yaw_rad),
            yaw_rate_rad_s: 0.0,
            on_ground: true,
            touch_down_max_m_s: 0.0,
        }
    }

    /// Lets `dt_s` pass.
    pub(crate) fn step(&mut self, drive: &Drive, wind: &Vector3<f64>, dt_s: f64) {
        self.turn(drive, dt_s);
        self.thrust_m_s2 += (drive.force.norm() - self.thrust_m_s2) * (dt_s / (MOTOR_LAG_S + dt_s));
        let gravity = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
        let drag = (wind - self.velocity) * self.response.drag_per_s;
        let total = self.up * self.thrust_m_s2 + gravity + drag;
        if self.on_ground && total.z >= 0.0 {
            // Friction holds it where it stands.
            self.rest();
            return;
        }
        self.acceleration = total;
        let before = self.velocity;
        self.velocity += total * dt_s;
        self.position += (before + self.velocity) * (0.5 * dt_s);
        self.on_ground = self.position.z >= 0.0 && self.velocity.z >= 0.0;
        if self.on_ground {
            self.touch_down_max_m_s = self.touch_down_max_m_s.max(self.velocity.norm());
            self.position.z = 0.0;
            self.rest();
        }
    }

    /// On the ground: no motion, level.
    fn rest(&mut self) {
        self.velocity = Vector3::zeros();
        self.acceleration = Vector3::zeros();
        self.up = -Vector3::z();
        self.spin = Vector3::zeros();
        self.yaw_rate_rad_s = 0.0;
    }

    fn turn(&mut self, drive: &Drive, dt_s: f64) {
        let size = drive.force.norm();
        let wanted = if size > 1e-3 { drive.force / size } else { -Vector3::z() };
        let axis = self.up.cross(&wanted);
        let sine = axis.norm();
        let angle = sine.atan2(self.up.dot(&wanted));
        let rate = (self.response.attitude_gain_per_s * angle).min(TILT_RATE_MAX_RAD_S);
        let wanted_spin = if sine > 1e-9 {
            axis * (rate / sine)
        } else {
            Vector3::zeros()
        };
        self.spin += (wanted_spin - self.spin) * (dt_s / (self.response.rate_lag_s + dt_s));
        self.up = (self.up + self.spin.cross(&self.up) * dt_s).normalize();
        if !self.on_ground {
            let error = wrap_angle_rad(drive.yaw_rad - self.yaw_rad);
            let limit = drive.yaw_rate_max_rad_s;
            let wanted_rate = (YAW_GAIN_PER_S * error + drive.yaw_rate_rad_s).clamp(-limit, limit);
            self.yaw_rate_rad_s += (wanted_rate - self.yaw_rate_rad_s) * (dt_s / (YAW_LAG_S + dt_s));
            self.yaw_rad = wrap_angle_rad(self.yaw_rad + self.yaw_rate_rad_s * dt_s);
        }
    }

    /// Roll and pitch in radians.
    pub(crate) fn roll_pitch_rad(&self) -> (f64, f64) {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let down = -self.up;
        let forward = down.x * cos + down.y * sin;
        let right = down.y * cos - down.x * sin;
        ((-right).clamp(-1.0, 1.0).asin(), forward.atan2(down.z))
    }

    /// Tilt from the level in radians.
    pub(crate) fn tilt_rad(&self) -> f64 {
        (-self.up.z).clamp(-1.0, 1.0).acos()
    }

    /// Body rates about roll and pitch in radians per second.
    pub(crate) fn roll_pitch_rates_rad_s(&self) -> (f64, f64) {
        let (sin, cos) = self.yaw_rad.sin_cos();
        (
            self.spin.x * cos + self.spin.y * sin,
            self.spin.y * cos - self.spin.x * sin,
        )
    }
}
