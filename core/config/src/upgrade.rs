//! `[upgrade]`: whether the swarm may give this node another version of the program, and how long that one has to show that it is well.
//!
//! Must never do: say which version runs.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};

/// `[upgrade]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UpgradeSettings {
    /// Whether this node takes another version of the program from its swarm.
    pub accept: bool,
    /// A version that has not confirmed itself after so long goes back, in seconds.
    pub confirm_within_s: f64,
}

impl Default for UpgradeSettings {
    fn default() -> Self {
        Self {
            accept: false,
            confirm_within_s: 60.0,
        }
    }
}

impl UpgradeSettings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        if !(10.0..=600.0).contains(&self.confirm_within_s) {
            problems.push(Problem {
                key: "upgrade.confirm_within_s".into(),
                message: format!("{} is not between 10 and 600", self.confirm_within_s),
            });
        }
    }
}
