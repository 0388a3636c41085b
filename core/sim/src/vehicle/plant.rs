//! The flight of one vehicle alone: airframe, estimator and position control of [`super::SimVehicle`] without its autopilot's modes, its
//! battery and its MAVLink. For simulations of many vehicles that are only about where they fly; starts in the air.
//!
//! Positions and setpoints are in the swarm's frame, the ground is at its height zero.

use super::body::{Body, Drive, GRAVITY_M_S2};
use super::estimator::{Estimate, Estimator};
use super::limits::limits_from;
use super::parameters::Parameters;
use super::position_control::{ControlLimits, PositionControl, Target};
use crate::airframe::Airframe;
use crate::settings::{NoiseSettings, WindSettings};
use crate::wind::Wind;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::Setpoint;
use skein_sim_payloads::wander::Wander;

/// Turns in OFFBOARD are no faster than this, in radians per second.
const YAW_RATE_MAX_RAD_S: f64 = 3.49;

/// One vehicle in the air.
#[derive(Debug, Clone)]
pub struct Plant {
    body: Body,
    control: PositionControl,
    estimator: Estimator,
    limits: ControlLimits,
    gusts: Wander,
    target: Target,
    rng: ChaCha8Rng,
}

impl Plant {
    /// The usual quadrotor, hovering at a place. `gust_m_s` are gusts of its own.
    #[must_use]
    pub fn hovering(place: Vector3<f64>, yaw_rad: f64, noise: &NoiseSettings, gust_m_s: f64, seed: u64) -> Self {
        Self::of(Airframe::default(), place, yaw_rad, noise, gust_m_s, seed)
    }

    /// The same of a kind.
    #[must_use]
    pub fn of(
        airframe: Airframe,
        place: Vector3<f64>,
        yaw_rad: f64,
        noise: &NoiseSettings,
        gust_m_s: f64,
        seed: u64,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut body = Body::new(airframe.response(), yaw_rad);
        body.position = place;
        body.on_ground = false;
        body.thrust_m_s2 = GRAVITY_M_S2;
        let estimator = Estimator::new(noise, false, &body, &mut rng);
        let mut plant = Self {
            gusts: Wander::new(Vector3::new(1.0, 1.0, 0.2) * gust_m_s, 1.5, &mut rng),
            limits: limits_from(&Parameters::new(1, airframe, &[])).control,
            control: PositionControl::new(),
            target: Target::NONE,
            body,
            estimator,
            rng,
        };
        plant.obey(&Setpoint::hold(place.into(), Some(yaw_rad)));
        plant
    }

    /// Flies this from now on.
    pub fn obey(&mut self, setpoint: &Setpoint) {
        let none = Target::NONE;
        self.target = Target {
            position: setpoint.position.map_or(none.position, |p| p.vector()),
            velocity: setpoint.velocity.map_or(none.velocity, |v| v.vector()),
            acceleration: setpoint.acceleration.map_or(none.acceleration, |a| a.vector()),
            yaw_rad: setpoint.yaw_rad.unwrap_or(f64::NAN),
            yaw_rate_rad_s: setpoint.yaw_rate_rad_s.unwrap_or(f64::NAN),
        };
    }

    /// Lets `dt_s` pass in this wind.
    pub fn step(&mut self, dt_s: f64, wind_m_s: &Vector3<f64>) {
        let believed = self.estimate();
        let force = self.control.step(&believed, &self.target, &self.limits, dt_s);
        let or = |value: f64, otherwise: f64| if value.is_finite() { value } else { otherwise };
        let drive = Drive {
            force,
            yaw_rad: or(self.target.yaw_rad, self.body.yaw_rad),
            yaw_rate_rad_s: or(self.target.yaw_rate_rad_s, 0.0),
            yaw_rate_max_rad_s: YAW_RATE_MAX_RAD_S,
        };
        let wind = wind_m_s + self.gusts.step(dt_s, &mut self.rng);
        self.body.step(&drive, &wind, dt_s);
        self.estimator.step(&self.body, dt_s, &mut self.rng);
    }

    fn estimate(&self) -> Estimate {
        Estimate {
            // In the swarm's frame, as a vehicle knows itself by its satellites.
            position: self.body.position + self.estimator.error(),
            ..self.estimator.now
        }
    }

    /// Where it is.
    #[must_use]
    pub fn position(&self) -> Vector3<f64> {
        self.body.position
    }

    /// How fast it is.
    #[must_use]
    pub fn velocity(&self) -> Vector3<f64> {
        self.body.velocity
    }

    /// Roll and pitch in radians.
    #[must_use]
    pub fn roll_pitch_rad(&self) -> (f64, f64) {
        self.body.roll_pitch_rad()
    }

    /// Where it believes to be, how fast, and how it points.
    #[must_use]
    pub fn believed(&self) -> (Vector3<f64>, Vector3<f64>, f64) {
        let now = self.estimate();
        (now.position, now.velocity, now.yaw_rad)
    }
}

/// The air that all of them fly in.
#[derive(Debug, Clone)]
pub struct Air {
    wind: Wind,
    rng: ChaCha8Rng,
}

impl Air {
    /// With this wind.
    #[must_use]
    pub fn new(wind: &WindSettings, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wind = Wind::new(wind, &mut rng);
        Self { wind, rng }
    }

    /// Lets `dt_s` pass and gives the wind in metres per second.
    pub fn step(&mut self, dt_s: f64) -> Vector3<f64> {
        self.wind.step(dt_s, &mut self.rng)
    }
}
