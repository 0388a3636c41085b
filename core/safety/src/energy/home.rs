//! What the way home costs: the distance against the wind, the climb to the height of the return, and the landing.

use super::consumption::Rates;
use crate::wind::Wind;
use skein_domain::{EnergySettings, PositionNed};

/// The way home from where the vehicle is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WayHome {
    /// Horizontal distance in metres.
    pub distance_m: f64,
    /// Direction of home in radians clockwise from north.
    pub bearing_rad: f64,
    /// How far it must climb to the height at which it returns, in metres; 0 if it is above.
    pub climb_m: f64,
    /// How far it must descend at home, from the height at which it returns, in metres.
    pub descent_m: f64,
    /// How fast it gets further away now, in metres per second; negative when it comes nearer.
    pub receding_m_s: f64,
}

/// This near it is home: there is nothing to be gained by landing somewhere else, in metres.
const IS_HOME_M: f64 = 10.0;

/// In full batteries.
const UNPAYABLE: f64 = 1e6;

impl WayHome {
    /// The way between two places of the swarm frame, returning no lower than `return_height_m` above home.
    #[must_use]
    pub fn between(position: &PositionNed, home: &PositionNed, return_height_m: f64, receding_m_s: f64) -> Self {
        let (north_m, east_m) = (home.north_m - position.north_m, home.east_m - position.east_m);
        let height_m = home.down_m - position.down_m;
        let at_m = height_m.max(return_height_m);
        Self {
            distance_m: north_m.hypot(east_m),
            bearing_rad: east_m.atan2(north_m),
            climb_m: (at_m - height_m).max(0.0),
            descent_m: at_m.max(0.0),
            receding_m_s,
        }
    }
}

/// What the way home costs, in shares of a full battery, as the model has it: without allowance and reserve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HomeCost {
    /// The way, with the climb; absent if it does not get there against the wind.
    pub way: Option<f64>,
    /// Descending and touching down.
    pub landing: f64,
    /// One metre of the way, if it gets there.
    pub per_metre: Option<f64>,
    /// Speed over the ground in metres per second; 0 if it does not get there.
    pub ground_speed_m_s: f64,
    /// It is there already.
    pub is_home: bool,
}

impl HomeCost {
    /// Way and landing; absent if it does not get there.
    #[must_use]
    pub fn total(&self) -> Option<f64> {
        self.way.map(|way| way + self.landing)
    }
}

/// What the way home costs with these rates in this wind. A way that is not finite is one that cannot be paid for.
pub(super) fn cost(way: &WayHome, wind: Wind, rates: &Rates, settings: &EnergySettings) -> HomeCost {
    let given = [way.distance_m, way.bearing_rad, way.climb_m, way.descent_m]
        .iter()
        .all(|v| v.is_finite());
    let is_home = way.distance_m <= IS_HOME_M;
    let climb_s = seconds(way.climb_m, settings.climb_m_s);
    let landing_s = seconds(way.descent_m, settings.descent_m_s) + settings.landing_s.max(0.0);
    let gust_m_s = match wind {
        Wind::Reported { .. } => settings.gust_m_s,
        Wind::Assumed { .. } => 0.0,
    };
    // Gusts make the way dearer; that home is out of reach is only said for the wind itself.
    let speed_m_s = wind
        .ground_speed_m_s(settings.airspeed_m_s, way.bearing_rad, gust_m_s)
        .or_else(|| {
            wind.ground_speed_m_s(settings.airspeed_m_s, way.bearing_rad, 0.0)
                .map(|s| s.min(crate::wind::SLOWEST_M_S))
        });
    let climb = climb_s * rates.hovering * settings.climb_factor.max(1.0);
    let per_metre = speed_m_s.map(|speed_m_s| rates.flying / speed_m_s);
    let flown = per_metre.map(|per_metre| per_metre * way.distance_m.max(0.0));
    let way = if is_home {
        Some(climb)
    } else {
        flown.map(|flown| flown + climb)
    };
    HomeCost {
        way: way.map(|w| payable(w, given)),
        landing: payable(landing_s * rates.hovering, given),
        per_metre,
        ground_speed_m_s: speed_m_s.unwrap_or(0.0),
        is_home,
    }
}

fn seconds(distance_m: f64, speed_m_s: f64) -> f64 {
    if speed_m_s > 0.0 {
        distance_m.max(0.0) / speed_m_s
    } else {
        f64::INFINITY
    }
}

/// A cost that is not a number, or of a way that is not known, is more than any battery holds.
fn payable(cost: f64, given: bool) -> f64 {
    if given && cost.is_finite() { cost } else { UNPAYABLE }
}
