//! Chance: quantities that wander about zero.
//!
//! Must never do: draw from anything but the generator that it is given.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// One draw from the normal distribution.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A quantity that wanders about zero: Ornstein-Uhlenbeck along three axes.
#[derive(Debug, Clone, Copy)]
pub struct Wander {
    sigma: Vector3<f64>,
    time_s: f64,
    value: Vector3<f64>,
}

impl Wander {
    /// Starts anywhere within its spread.
    pub fn new(sigma: Vector3<f64>, time_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let value = sigma.map(|s| s * normal(rng));
        Self {
            sigma,
            time_s: time_s.max(1e-3),
            value,
        }
    }

    /// Another spread and pace from now on; the value goes on and changes over.
    pub fn change(&mut self, sigma: Vector3<f64>, time_s: f64) {
        self.sigma = sigma;
        self.time_s = time_s.max(1e-3);
    }

    /// Lets `dt_s` pass.
    pub fn step(&mut self, dt_s: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        let keep = (-dt_s / self.time_s).exp();
        let draw = (1.0 - keep * keep).sqrt();
        for axis in 0..3 {
            self.value[axis] = self.value[axis] * keep + self.sigma[axis] * draw * normal(rng);
        }
        self.value
    }

    /// The present value.
    pub fn value(&self) -> Vector3<f64> {
        self.value
    }
}
