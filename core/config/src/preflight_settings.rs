//! `[safety.preflight]`: what makes its values wrong. The settings themselves are `skein-domain`'s.
//!
//! Must never do: let a limit through that nothing could ever pass, or everything would.

use crate::problem::Problem;
use skein_domain::PreflightSettings;

/// Everything that is wrong with the preflight settings.
pub(crate) fn problems(preflight: &PreflightSettings, problems: &mut Vec<Problem>) {
    let p = preflight;
    for (key, value, low, high) in [
        ("loss_amber_share", p.loss_amber_share, 0.0, p.loss_red_share),
        ("loss_red_share", p.loss_red_share, 0.01, 1.0),
        ("position_within_s", p.position_within_s, 0.05, 10.0),
        ("min_satellites", f64::from(p.min_satellites), 0.0, 40.0),
        ("max_disagreement_m", p.max_disagreement_m, 0.1, 1_000.0),
        ("min_battery_share", p.min_battery_share, 0.05, 1.0),
        ("full_battery_share", p.full_battery_share, p.min_battery_share, 1.0),
        ("max_ground_speed_m_s", p.max_ground_speed_m_s, 0.05, 10.0),
        ("max_clock_error_s", p.max_clock_error_s, 0.001, 10.0),
        ("max_clock_spread_s", p.max_clock_spread_s, 0.001, 10.0),
        ("min_ground_distance_m", p.min_ground_distance_m, 0.0, 100.0),
    ] {
        if !(low..=high).contains(&value) {
            problems.push(Problem {
                key: format!("safety.preflight.{key}"),
                message: format!("{value} is not between {low} and {high}"),
            });
        }
    }
}

#[cfg(test)]
mod tests;
