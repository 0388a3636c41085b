//! The numbers that the separation filter works with, and what must hold between them. Values only; nothing is decided here.

use thiserror::Error;

/// A setting that is not usable.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{setting} = {value}: it must be a finite number of at least {least}")]
pub struct AvoidanceSettingsError {
    /// Which one.
    pub setting: &'static str,
    /// What was given.
    pub value: f64,
    /// The least that is usable with the other settings.
    pub least: f64,
}

/// What the filter may assume and demand. Distances in metres, speeds in metres per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AvoidanceSettings {
    /// Smallest real distance between two vehicles in the air.
    pub min_separation_m: f64,
    /// How much taller than wide the volume is that is kept free, for downwash: its half height is this many smallest distances.
    /// At least 1.
    pub vertical_stretch: f64,
    /// Encounters further ahead than this are left alone, in seconds.
    pub horizon_s: f64,
    /// How hard a vehicle can be relied on to brake or to dodge.
    pub braking_m_s2: f64,
    /// How long it takes until a changed setpoint shows in the velocity: period, link and the lag of the velocity control.
    pub reaction_s: f64,
    /// Largest horizontal speed that may be asked for.
    pub max_speed_m_s: f64,
    /// Largest climb rate that may be asked for.
    pub max_climb_m_s: f64,
    /// Largest descent rate that may be asked for.
    pub max_descent_m_s: f64,
    /// How far the own position estimate may be wrong (a bound that is hardly ever exceeded, about three standard deviations).
    pub noise_m: f64,
    /// How hard another vehicle may accelerate while nothing is heard of it.
    pub peer_acceleration_m_s2: f64,
    /// Gain of the autopilot's position control, per second: how a distance from the asked place becomes a velocity.
    pub position_gain_per_s: f64,
}

impl Default for AvoidanceSettings {
    fn default() -> Self {
        Self {
            min_separation_m: 2.0,
            vertical_stretch: 1.5,
            horizon_s: 6.0,
            braking_m_s2: 2.5,
            reaction_s: 0.8,
            max_speed_m_s: 12.0,
            max_climb_m_s: 4.0,
            max_descent_m_s: 3.0,
            noise_m: 0.3,
            peer_acceleration_m_s2: 3.0,
            position_gain_per_s: 0.95,
        }
    }
}

impl AvoidanceSettings {
    /// Whether every number is finite and in its range. Zero separation turns the filter off.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), AvoidanceSettingsError> {
        let above_zero = 1e-3;
        for (setting, value, least) in [
            ("min_separation_m", self.min_separation_m, 0.0),
            ("vertical_stretch", self.vertical_stretch, 1.0),
            ("horizon_s", self.horizon_s, self.least_horizon_s()),
            ("braking_m_s2", self.braking_m_s2, above_zero),
            ("reaction_s", self.reaction_s, above_zero),
            ("max_speed_m_s", self.max_speed_m_s, above_zero),
            ("max_climb_m_s", self.max_climb_m_s, above_zero),
            ("max_descent_m_s", self.max_descent_m_s, above_zero),
            ("noise_m", self.noise_m, 0.0),
            ("peer_acceleration_m_s2", self.peer_acceleration_m_s2, 0.0),
            ("position_gain_per_s", self.position_gain_per_s, above_zero),
        ] {
            if !(value.is_finite() && value >= least) {
                return Err(AvoidanceSettingsError { setting, value, least });
            }
        }
        Ok(())
    }

    /// Two vehicles at top speed that brake both need this long to stop; a shorter look ahead would see each other too late.
    fn least_horizon_s(&self) -> f64 {
        self.reaction_s + 0.5 * self.max_speed_m_s / self.braking_m_s2
    }
}
