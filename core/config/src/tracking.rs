//! `[tracking]`: what tracks are made with, and what makes these values wrong.
//!
//! Must never do: guess what a class means.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `[tracking]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackingSettings {
    /// Tracks of the swarm's own making steer vehicles: they are kept away from, and can be observed.
    pub steer_by_fused: bool,
    /// How wide things of a class typically are, in metres, by the class as detectors name it.
    pub width_m: BTreeMap<String, f64>,
}

impl Default for TrackingSettings {
    fn default() -> Self {
        let widths = [
            ("airplane", 20.0),
            ("bird", 0.6),
            ("drone", 0.5),
            ("helicopter", 12.0),
            ("uav", 0.5),
        ];
        Self {
            // A detector that sees what is not there would move vehicles.
            steer_by_fused: false,
            width_m: widths.into_iter().map(|(class, m)| (class.to_owned(), m)).collect(),
        }
    }
}

impl TrackingSettings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        for (class, width_m) in &self.width_m {
            if !(0.01..=100.0).contains(width_m) {
                problems.push(Problem {
                    key: format!("tracking.width_m.{class}"),
                    message: format!("{width_m} is not between 0.01 and 100"),
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::NodeConfig;

    #[test]
    fn a_width_that_nothing_has_is_named() {
        let config = NodeConfig::parse("[tracking.width_m]\nkite = 1.5\nmoth = 0.0\n");
        let error = config.expect_err("is wrong").to_string();
        assert!(
            error.contains("tracking.width_m.moth") && !error.contains("kite"),
            "{error}"
        );
    }
}
