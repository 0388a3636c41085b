//! The plugin's configuration.

use payload_mavlink::Patience;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// What the gimbal is spoken to in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Backend {
    /// MAVLink's gimbal protocol v2, over the vehicle's link.
    #[default]
    Mavlink,
    /// SIYI's gimbal protocol, over the payload's own transport (UDP port 37260 or a serial line of 115200 baud).
    Siyi,
}

/// Configuration of the gimbal plugin. Every key may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What the gimbal is spoken to in.
    pub backend: Backend,
    /// Which gimbal of the vehicle, by its MAVLink device id; 0: the first that is heard.
    pub gimbal_device_id: u8,
    /// What this node calls itself on the vehicle's link: `own_system_id` of the link's configuration. Control of a MAVLink gimbal is
    /// given by these numbers; what the vehicle's acknowledgements say otherwise is believed more.
    #[schemars(range(min = 1))]
    pub own_system_id: u8,
    /// See `own_system_id`.
    #[schemars(range(min = 1))]
    pub own_component_id: u8,
    /// Lowest pitch to point to, in radians; the device's own limit holds beside it.
    #[schemars(range(min = -1.6, max = 1.6))]
    pub pitch_min_rad: f64,
    /// Highest pitch to point to, in radians; the device's own limit holds beside it.
    #[schemars(range(min = -1.6, max = 1.6))]
    pub pitch_max_rad: f64,
    /// Fastest turn that is asked for, in radians per second. With SIYI it is also what the device does at full deflection.
    #[schemars(range(min = 0.01))]
    pub rate_max_rad_s: f64,
    /// Angles are reached when the direction is off by no more than this, in radians.
    #[schemars(range(min = 0.001))]
    pub tolerance_rad: f64,
    /// A gimbal that looks farther from where it is wanted than this, in radians, for `follow_timeout_s` and without coming nearer does
    /// not follow.
    #[schemars(range(min = 0.001))]
    pub follow_tolerance_rad: f64,
    /// See `follow_tolerance_rad`; in seconds.
    #[schemars(range(min = 0.1))]
    pub follow_timeout_s: f64,
    /// How long a turn to angles or a place may take, in seconds, before its command counts as failed.
    #[schemars(range(min = 0.1))]
    pub turn_timeout_s: f64,
    /// How long an acknowledgement is waited for, in seconds, before a command is sent again.
    #[schemars(range(min = 0.05))]
    pub ack_timeout_s: f64,
    /// How often a command is sent before it counts as failed.
    #[schemars(range(min = 1))]
    pub attempts: u32,
    /// The gimbal counts as lost when nothing was heard of it for this long, in seconds.
    #[schemars(range(min = 0.1))]
    pub lost_after_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            backend: Backend::Mavlink,
            gimbal_device_id: 0,
            own_system_id: 245,
            own_component_id: 190,
            pitch_min_rad: -FRAC_PI_2,
            pitch_max_rad: FRAC_PI_4,
            rate_max_rad_s: FRAC_PI_2,
            tolerance_rad: 0.03,
            follow_tolerance_rad: 5_f64.to_radians(),
            follow_timeout_s: 2.0,
            turn_timeout_s: 10.0,
            ack_timeout_s: 0.7,
            attempts: 4,
            lost_after_s: 2.0,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot.
    pub fn check(&self) -> Result<(), String> {
        for (key, value) in [
            ("own_system_id", f64::from(self.own_system_id)),
            ("own_component_id", f64::from(self.own_component_id)),
            ("rate_max_rad_s", self.rate_max_rad_s),
            ("tolerance_rad", self.tolerance_rad),
            ("follow_tolerance_rad", self.follow_tolerance_rad),
            ("follow_timeout_s", self.follow_timeout_s),
            ("turn_timeout_s", self.turn_timeout_s),
            ("ack_timeout_s", self.ack_timeout_s),
            ("attempts", f64::from(self.attempts)),
            ("lost_after_s", self.lost_after_s),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key} = {value}: it must be above zero"));
            }
        }
        let (low, high) = (self.pitch_min_rad, self.pitch_max_rad);
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(format!(
                "pitch_min_rad = {low} must not be above pitch_max_rad = {high}"
            ));
        }
        Ok(())
    }

    pub(crate) fn patience(&self) -> Patience {
        Patience {
            wait_s: self.ack_timeout_s,
            attempts: self.attempts,
        }
    }
}
