//! What a vehicle can do, as its UAV model says: what the coordinator plans formations and trajectories by.

use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// Limits of one vehicle's flight. The slowest member decides how fast a formation goes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct FlightLimits {
    /// Largest horizontal speed in metres per second.
    #[n(0)]
    pub max_speed_m_s: f64,
    /// Largest climb rate in metres per second.
    #[n(1)]
    pub max_climb_m_s: f64,
    /// Largest descent rate in metres per second.
    #[n(2)]
    pub max_descent_m_s: f64,
    /// Largest acceleration in metres per second squared.
    #[n(3)]
    pub max_acceleration_m_s2: f64,
    /// Smallest radius of a turn at its speed in metres; 0 for one that can turn on the spot.
    #[n(4)]
    pub min_turn_radius_m: f64,
    /// How long it can stay in the air with a full battery, in seconds, if known.
    #[n(5)]
    pub endurance_s: Option<f64>,
    /// It carries a camera that looks out of the formation: its slot is chosen so that nobody flies in its view.
    #[n(6)]
    pub keeps_view: bool,
}

impl FlightLimits {
    /// Whether every number can be planned with.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let above_zero = |v: f64| v.is_finite() && v > 0.0;
        [
            self.max_speed_m_s,
            self.max_climb_m_s,
            self.max_descent_m_s,
            self.max_acceleration_m_s2,
        ]
        .into_iter()
        .all(above_zero)
            && self.min_turn_radius_m.is_finite()
            && self.min_turn_radius_m >= 0.0
            && self.endurance_s.is_none_or(above_zero)
    }

    /// What both can do.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            max_speed_m_s: self.max_speed_m_s.min(other.max_speed_m_s),
            max_climb_m_s: self.max_climb_m_s.min(other.max_climb_m_s),
            max_descent_m_s: self.max_descent_m_s.min(other.max_descent_m_s),
            max_acceleration_m_s2: self.max_acceleration_m_s2.min(other.max_acceleration_m_s2),
            min_turn_radius_m: self.min_turn_radius_m.max(other.min_turn_radius_m),
            endurance_s: match (self.endurance_s, other.endurance_s) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            },
            keeps_view: self.keeps_view || other.keeps_view,
        }
    }
}
