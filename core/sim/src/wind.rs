//! The wind: steady, with gusts that all vehicles of a simulation share for the most part. Seeded; no clock.

use crate::settings::WindSettings;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// One draw from the normal distribution.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A quantity that wanders about zero: Ornstein-Uhlenbeck along three axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wander {
    sigma: Vector3<f64>,
    time_s: f64,
    value: Vector3<f64>,
}

impl Wander {
    /// Starts anywhere within its spread.
    pub(crate) fn new(sigma: Vector3<f64>, time_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let value = sigma.map(|s| s * normal(rng));
        Self {
            sigma,
            time_s: time_s.max(1e-3),
            value,
        }
    }

    /// Lets `dt_s` pass.
    pub(crate) fn step(&mut self, dt_s: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        let keep = (-dt_s / self.time_s).exp();
        let draw = (1.0 - keep * keep).sqrt();
        for axis in 0..3 {
            self.value[axis] = self.value[axis] * keep + self.sigma[axis] * draw * normal(rng);
        }
        self.value
    }

    /// The present value.
    pub(crate) fn value(&self) -> Vector3<f64> {
        self.value
    }
}

/// The wind that all vehicles share.
#[derive(Debug, Clone)]
pub(crate) struct Wind {
    mean: Vector3<f64>,
    gusts: Wander,
}

impl Wind {
    pub(crate) fn new(settings: &WindSettings, rng: &mut ChaCha8Rng) -> Self {
        // Gusts are much weaker along the vertical near the ground.
        let sigma = Vector3::new(1.0, 1.0, 0.2) * settings.gust_m_s;
        Self {
            mean: Vector3::new(settings.mean_north_m_s, settings.mean_east_m_s, 0.0),
            gusts: Wander::new(sigma, settings.gust_time_s, rng),
        }
    }

    /// Another wind from now on; the gusts that blow go on and change over.
    pub(crate) fn change(&mut self, settings: &WindSettings) {
        self.mean = Vector3::new(settings.mean_north_m_s, settings.mean_east_m_s, 0.0);
        self.gusts.sigma = Vector3::new(1.0, 1.0, 0.2) * settings.gust_m_s;
        self.gusts.time_s = settings.gust_time_s.max(1e-3);
    }

    /// Lets `dt_s` pass and gives the wind in metres per second.
    pub(crate) fn step(&mut self, dt_s: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        self.mean + self.gusts.step(dt_s, rng)
    }
}
