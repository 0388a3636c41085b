//! The logs that an autopilot keeps by itself (PX4: ULog files on its card), and how far the fetching of one has come.
//!
//! Must never do: know how they are fetched.

use serde::{Deserialize, Serialize};

/// A log on an autopilot's own card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct AutopilotLog {
    /// Its number there. It may be another one after the autopilot has restarted or a log was deleted.
    pub number: u16,
    /// Its size in bytes.
    pub size_bytes: u32,
    /// When it was written last, in seconds since 1970 by the autopilot's clock; absent if that had no time.
    pub written_unix_s: Option<u32>,
}

/// How far the fetching of a log has come.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct LogFetch {
    /// Which log.
    pub log: AutopilotLog,
    /// Bytes that are there.
    pub received_bytes: u32,
    /// How it ended, if it has.
    pub end: Option<LogFetchEnd>,
}

/// How the fetching of a log ended.
#[derive(Debug, Clone, PartialEq, Eq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum LogFetchEnd {
    /// It lies beside the recordings of flights.
    Fetched {
        /// Its file there.
        file: String,
    },
    /// It was broken off.
    BrokenOff {
        /// Why.
        why: String,
    },
}
