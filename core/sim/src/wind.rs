//! The wind: steady, with gusts that all vehicles of a simulation share for the most part. Seeded; no clock.

use crate::settings::WindSettings;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use skein_sim_payloads::wander::Wander;

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
        let sigma = Vector3::new(1.0, 1.0, 0.2) * settings.gust_m_s;
        self.gusts.change(sigma, settings.gust_time_s);
    }

    /// Lets `dt_s` pass and gives the wind in metres per second.
    pub(crate) fn step(&mut self, dt_s: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        self.mean + self.gusts.step(dt_s, rng)
    }
}
