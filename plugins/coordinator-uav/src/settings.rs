//! What can be set.

use schemars::JsonSchema;
use serde::Deserialize;

/// Settings of the model.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How it flies: the settings of `generic-uav`.
    pub flight: generic_uav::Settings,
    /// The vehicle with the greatest takes over first.
    pub priority: u8,
    /// With less charge than this it does not host the coordinator, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_battery: f64,
    /// So much more than `min_battery` is needed to become capable again, so that a charge about the limit does not change it back and
    /// forth.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub battery_margin: f64,
    /// Whether a vehicle that does not tell its charge can host the coordinator.
    pub without_battery: bool,
    /// Whether it needs a position estimate.
    pub needs_position: bool,
    /// Whether it must be in the air and under the swarm's control.
    pub needs_flight: bool,
    /// The conditions must have held for so long before it says that it is capable, in seconds. That it is not any more it says at once.
    #[schemars(range(min = 0.0))]
    pub settle_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            flight: generic_uav::Settings::default(),
            priority: 100,
            min_battery: 0.3,
            battery_margin: 0.05,
            without_battery: true,
            needs_position: true,
            needs_flight: false,
            settle_s: 2.0,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot. The flight's are checked by `generic-uav`.
    pub fn check(&self) -> Result<(), String> {
        let shares = [
            ("min_battery", self.min_battery),
            ("battery_margin", self.battery_margin),
        ];
        for (key, value) in shares {
            if !(0.0..=1.0).contains(&value) {
                return Err(format!("{key} = {value}: it must be within 0 to 1"));
            }
        }
        if self.settle_s.is_finite() && self.settle_s >= 0.0 {
            Ok(())
        } else {
            Err(format!("settle_s = {}: it must not be below zero", self.settle_s))
        }
    }
}
