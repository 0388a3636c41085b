//! A telemetry radio: how strong it is heard at a distance, and what that loses.
//!
//! Log-distance path loss with slow shadowing: the signal falls by ten times the exponent per decade of distance, and hills and trees
//! add a value that wanders.

use crate::wander::Wander;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use skein_domain::PositionNed;

/// A radio and the air it sends through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadioSettings {
    /// Where the ground station's radio stands.
    pub ground_station: PositionNed,
    /// Transmission power of both ends in decibels over a milliwatt, antennas included.
    pub power_dbm: f64,
    /// Loss over the first metre in decibels: 31.7 at 915 MHz, 40 at 2.4 GHz.
    pub reference_loss_db: f64,
    /// Path-loss exponent: 2 in free space, 2.7 to 3.5 near the ground.
    pub exponent: f64,
    /// Noise at the vehicle in decibels over a milliwatt.
    pub noise_dbm: f64,
    /// Noise at the ground station in decibels over a milliwatt.
    pub ground_noise_dbm: f64,
    /// Signal at which half of all packets is lost, in decibels over a milliwatt.
    pub sensitivity_dbm: f64,
    /// Decibels over which loss goes from a half to about a quarter.
    pub slope_db: f64,
    /// Standard deviation of the shadowing in decibels.
    pub shadowing_db: f64,
    /// Time over which the shadowing wanders, in seconds.
    pub shadowing_time_s: f64,
    /// Packets per second that the radio carries; lost ones are counted as errors.
    pub packets_hz: f64,
    /// Whether the vehicle's datagrams really get lost as the radio loses packets.
    pub loses_datagrams: bool,
}

impl Default for RadioSettings {
    fn default() -> Self {
        Self {
            ground_station: PositionNed::default(),
            power_dbm: 20.0,
            reference_loss_db: 31.7,
            exponent: 2.7,
            noise_dbm: -108.0,
            ground_noise_dbm: -104.0,
            sensitivity_dbm: -100.0,
            slope_db: 1.5,
            shadowing_db: 1.5,
            shadowing_time_s: 12.0,
            packets_hz: 50.0,
            loses_datagrams: false,
        }
    }
}

impl RadioSettings {
    /// Mean signal at a distance in decibels over a milliwatt, shadowing left out.
    #[must_use]
    pub fn signal_dbm(&self, distance_m: f64) -> f64 {
        self.power_dbm - self.reference_loss_db - 10.0 * self.exponent * distance_m.max(1.0).log10()
    }

    /// Distance at which the mean signal is this weak, in metres.
    #[must_use]
    pub fn distance_m(&self, signal_dbm: f64) -> f64 {
        10_f64.powf((self.power_dbm - self.reference_loss_db - signal_dbm) / (10.0 * self.exponent))
    }

    /// Share of packets lost at a signal, 0..=1.
    #[must_use]
    pub fn loss(&self, signal_dbm: f64) -> f64 {
        1.0 / (1.0 + ((signal_dbm - self.sensitivity_dbm) / self.slope_db).exp())
    }
}

/// How a SiK radio reports a strength: 1.9 per decibel, zero at -127 dBm; 255 would mean "not known".
pub fn sik_raw(dbm: f64) -> u8 {
    ((dbm + 127.0) * 1.9).round().clamp(0.0, 254.0) as u8
}

/// A radio at work.
#[derive(Debug, Clone)]
pub struct Radio {
    /// How it is built.
    pub settings: RadioSettings,
    shadowing: Wander,
    /// Signal at the vehicle in decibels over a milliwatt.
    pub signal_dbm: f64,
    /// Signal at the ground station in decibels over a milliwatt.
    pub ground_signal_dbm: f64,
    /// Share of packets lost, 0..=1.
    pub loss: f64,
    errors: f64,
}

impl Radio {
    /// Where the vehicle starts.
    pub fn new(settings: RadioSettings, at: &PositionNed, rng: &mut ChaCha8Rng) -> Self {
        // What is in the way is in the way of both directions; the antennas differ a little.
        let sigma = Vector3::new(settings.shadowing_db, 0.4 * settings.shadowing_db, 0.0);
        let mut radio = Self {
            settings,
            shadowing: Wander::new(sigma, settings.shadowing_time_s, rng),
            signal_dbm: 0.0,
            ground_signal_dbm: 0.0,
            loss: 0.0,
            errors: 0.0,
        };
        let shadow = radio.shadowing.value();
        radio.hear(at, &shadow);
        radio
    }

    /// Lets `dt_s` pass, the vehicle being at `at`.
    pub fn step(&mut self, at: &PositionNed, dt_s: f64, rng: &mut ChaCha8Rng) {
        let shadow = self.shadowing.step(dt_s, rng);
        self.hear(at, &shadow);
        self.errors += self.loss * self.settings.packets_hz * dt_s;
    }

    fn hear(&mut self, at: &PositionNed, shadow: &Vector3<f64>) {
        let mean_dbm = self.settings.signal_dbm(at.distance_m(&self.settings.ground_station));
        self.signal_dbm = mean_dbm + shadow.x;
        self.ground_signal_dbm = mean_dbm + shadow.x + shadow.y;
        self.loss = self.settings.loss(self.signal_dbm.min(self.ground_signal_dbm));
    }

    /// Packets lost since the start; wraps as the counter on the wire does.
    pub fn errors(&self) -> u16 {
        (self.errors as u64 & 0xFFFF) as u16
    }
}

#[cfg(test)]
mod tests;
