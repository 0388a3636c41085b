//! `diagnostic_msgs`.
//!
//! Must never do: judge; the levels are given by who fills it.

use super::messages;
use super::standard::Header;

messages! { "diagnostic_msgs":
    /// One fact.
    KeyValue { key: String, value: String }
    /// How something is.
    DiagnosticStatus { level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue> }
    /// How things are.
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus> }
}

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Well.
    Ok = 0,
    /// To be looked at.
    Warn = 1,
    /// Wrong.
    Error = 2,
    /// Not heard of.
    Stale = 3,
}
