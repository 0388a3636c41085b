//! What the vehicle believes of itself: truth plus an offset that wanders and a quick jitter, in a frame of its own whose
//! origin is where it believed to be when it was started.

use super::body::Body;
use super::gnss::Satellites;
use crate::settings::NoiseSettings;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use skein_sim_payloads::wander::Wander;

/// State as the vehicle's own controller sees it, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    /// Metres north, east, down of the estimator's origin.
    pub position: Vector3<f64>,
    /// Metres per second.
    pub velocity: Vector3<f64>,
    /// Metres per second squared.
    pub acceleration: Vector3<f64>,
    /// Radians.
    pub yaw_rad: f64,
    /// Height over the ground below in metres, as a distance sensor would see it.
    pub height_m: f64,
}

/// The estimator.
#[derive(Debug, Clone)]
pub(crate) struct Estimator {
    offset: Wander,
    jitter: Wander,
    velocity_jitter: Wander,
    limit_m: f64,
    /// The estimator's origin about the start place, in metres.
    origin: Vector3<f64>,
    /// The receivers it follows.
    pub satellites: Satellites,
    /// The latest estimate.
    pub now: Estimate,
}

impl Estimator {
    /// Starts where the body is.
    pub(crate) fn new(noise: &NoiseSettings, second_gnss: bool, body: &Body, rng: &mut ChaCha8Rng) -> Self {
        let wander = Vector3::new(
            noise.wander_horizontal_m,
            noise.wander_horizontal_m,
            noise.wander_vertical_m,
        );
        let jitter = Vector3::repeat(noise.jitter_m);
        let velocity_jitter = Vector3::repeat(noise.velocity_jitter_m_s);
        let mut estimator = Self {
            offset: Wander::new(wander, noise.wander_time_s, rng),
            jitter: Wander::new(jitter, 0.15, rng),
            velocity_jitter: Wander::new(velocity_jitter, 0.15, rng),
            limit_m: noise.wander_limit_m,
            origin: Vector3::zeros(),
            satellites: Satellites::new(second_gnss),
            now: Estimate {
                position: Vector3::zeros(),
                velocity: Vector3::zeros(),
                acceleration: Vector3::zeros(),
                yaw_rad: body.yaw_rad,
                height_m: 0.0,
            },
        };
        estimator.restart(body);
        estimator
    }

    /// Takes the place where the body is believed to be as the new origin.
    pub(crate) fn restart(&mut self, body: &Body) {
        self.satellites.restart();
        self.origin = body.position + self.error();
        self.observe(body);
    }

    /// Lets `dt_s` pass and looks at the body.
    pub(crate) fn step(&mut self, body: &Body, dt_s: f64, rng: &mut ChaCha8Rng) {
        self.offset.step(dt_s, rng);
        self.jitter.step(dt_s, rng);
        self.velocity_jitter.step(dt_s, rng);
        self.satellites.step(dt_s, rng);
        self.observe(body);
    }

    fn observe(&mut self, body: &Body) {
        self.now = Estimate {
            position: body.position + self.error() - self.origin,
            velocity: body.velocity + self.satellites.drift + self.velocity_jitter.value(),
            acceleration: body.acceleration,
            yaw_rad: body.yaw_rad,
            height_m: -body.position.z,
        };
    }

    /// Estimated minus true position in metres.
    pub(crate) fn error(&self) -> Vector3<f64> {
        let offset = self.offset.value();
        let level = offset.xy().norm();
        let scale = if level > self.limit_m && level > 0.0 {
            self.limit_m / level
        } else {
            1.0
        };
        let slow = Vector3::new(
            offset.x * scale,
            offset.y * scale,
            offset.z.clamp(-self.limit_m, self.limit_m),
        );
        slow + self.jitter.value() + self.satellites.error
    }

    /// The origin about the start place in metres.
    pub(crate) fn origin(&self) -> Vector3<f64> {
        self.origin
    }
}
