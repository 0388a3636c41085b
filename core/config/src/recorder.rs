//! `[recorder]`: what is recorded of flights, where, and how much of it is kept.
//!
//! Must never do: look at the disk.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;
use std::path::PathBuf;

/// `[recorder]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecorderSettings {
    /// Flights are recorded.
    pub enabled: bool,
    /// Where the files go; unset: `flights` beside the configuration file.
    pub folder: Option<PathBuf>,
    /// So much is kept of them, in megabytes.
    pub keep_mb: u64,
    /// So long, in days.
    pub keep_days: f64,
    /// Every setpoint with all it was judged by, instead of some of each second.
    pub everything: bool,
    /// Where Foxglove and Lichtblick may look on live; unset: nowhere.
    pub foxglove: Option<SocketAddr>,
}

impl Default for RecorderSettings {
    fn default() -> Self {
        Self {
            enabled: true,
            folder: None,
            keep_mb: 4096,
            keep_days: 90.0,
            everything: false,
            foxglove: None,
        }
    }
}

impl RecorderSettings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        let mut wrong = |key: &str, message: String| {
            problems.push(Problem {
                key: format!("recorder.{key}"),
                message,
            });
        };
        if !(16..=100_000_000).contains(&self.keep_mb) {
            wrong("keep_mb", format!("{} is not between 16 and 100000000", self.keep_mb));
        }
        if !(0.01..=36_500.0).contains(&self.keep_days) {
            wrong("keep_days", format!("{} is not between 0.01 and 36500", self.keep_days));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::NodeConfig;

    #[test]
    fn what_would_keep_nothing_is_named() {
        let config = NodeConfig::parse("[recorder]\nkeep_mb = 1\nkeep_days = nan\n");
        let error = config.expect_err("is wrong").to_string();
        assert!(
            error.contains("recorder.keep_mb") && error.contains("recorder.keep_days"),
            "{error}"
        );
    }
}
