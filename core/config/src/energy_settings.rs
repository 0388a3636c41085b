//! `[safety.energy]`: what makes its values wrong. The settings themselves are `skein-domain`'s.
//!
//! Must never do: let values through with which no vehicle would ever be sent home, or none would ever get there.

use crate::problem::Problem;
use skein_domain::EnergySettings;

/// Everything that is wrong with the energy settings.
pub(crate) fn problems(energy: &EnergySettings, problems: &mut Vec<Problem>) {
    let e = energy;
    for (key, value, low, high) in [
        ("hover_endurance_s", e.hover_endurance_s, 30.0, 100_000.0),
        ("flying_endurance_s", e.flying_endurance_s, 30.0, 100_000.0),
        ("capacity_ah", e.capacity_ah.unwrap_or(1.0), 0.05, 1_000.0),
        ("cells", e.cells.map_or(1.0, f64::from), 1.0, 100.0),
        ("empty_cell_v", e.empty_cell_v, 1.0, 5.0),
        ("full_cell_v", e.full_cell_v, e.empty_cell_v + 0.1, 5.0),
        ("airspeed_m_s", e.airspeed_m_s, 1.0, 60.0),
        ("climb_m_s", e.climb_m_s, 0.1, 30.0),
        ("descent_m_s", e.descent_m_s, 0.1, 30.0),
        ("climb_factor", e.climb_factor, 1.0, 10.0),
        ("landing_s", e.landing_s, 0.0, 600.0),
        // With more than this from ahead no vehicle would ever reach home.
        ("assumed_wind_m_s", e.assumed_wind_m_s, 0.0, e.airspeed_m_s - 1.0),
        ("gust_m_s", e.gust_m_s, 0.0, e.airspeed_m_s - e.assumed_wind_m_s - 0.5),
        ("reserve_share", e.reserve_share, 0.0, 0.9),
        ("model_error_share", e.model_error_share, 0.0, 2.0),
        ("critical_share", e.critical_share, 0.01, 0.9),
        ("replan_before_s", e.replan_before_s, 0.0, 3_600.0),
        ("hysteresis_share", e.hysteresis_share, 0.0, 0.2),
        ("learned_after_s", e.learned_after_s, 5.0, 3_600.0),
        ("memory_s", e.memory_s, 10.0, 36_000.0),
    ] {
        if !(low..=high).contains(&value) {
            problems.push(Problem {
                key: format!("safety.energy.{key}"),
                message: format!("{value} is not between {low} and {high}"),
            });
        }
    }
}

#[cfg(test)]
mod tests;
