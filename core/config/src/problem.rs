//! One thing that is wrong with a configuration.
//!
//! Must never do: say that something is wrong without saying what would be right.

use std::fmt;

/// One wrong value: its key as it stands in the file, and what would be right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The key, for example `safety.max_speed_m_s`.
    pub key: String,
    /// What is wrong and what would be right.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.message)
    }
}
