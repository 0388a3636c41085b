//! `[resume]`: what a node that was killed in flight does with its vehicles when it starts again.
//!
//! Must never do: say which vehicle may be taken back; that is judged in flight.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// `[resume]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ResumeSettings {
    /// What is done with vehicles that this node flew until it ended.
    pub then: ResumeThen,
    /// What was flown longer ago than this is not gone on with, in seconds.
    pub within_s: f64,
    /// Where it is kept what is flown; unset: beside the configuration file.
    pub file: Option<PathBuf>,
}

impl Default for ResumeSettings {
    fn default() -> Self {
        Self {
            then: ResumeThen::default(),
            within_s: 30.0,
            file: None,
        }
    }
}

/// What is done with vehicles that this node flew until it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResumeThen {
    /// They hold where they are, and the operator is asked whether they fly on.
    #[default]
    Ask,
    /// They fly on.
    FlyOn,
    /// Nothing: they are left to their autopilots, and nothing is kept.
    Forget,
}
