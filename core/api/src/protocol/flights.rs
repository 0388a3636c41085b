//! Recordings of flights, as the API has them.

use schemars::JsonSchema;
use serde::Serialize;
use skein_domain::{AutopilotLog, LogFetch};
use ts_rs::TS;

/// Recordings on this node.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct FlightList {
    /// The newest first.
    pub flights: Vec<RecordedFlight>,
}

/// Logs on an autopilot's card.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct AutopilotLogList {
    /// By their numbers.
    pub logs: Vec<AutopilotLog>,
}

/// The log of a vehicle that is being fetched, or was last.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct LogFetchAnswer {
    /// How far it has come; null if none was since the node started.
    pub fetch: Option<LogFetch>,
}

/// A recording of a flight, or of vehicles that stood.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct RecordedFlight {
    /// The file's name. One that ends with `_ground.mcap` is of vehicles that stood.
    pub file: String,
    /// Name of the node that recorded it.
    pub node: String,
    /// When it begins, in seconds since 1970 by the clock of that node's computer.
    pub begun_unix_s: f64,
    /// How long it is, in seconds.
    pub seconds: f64,
    /// Its size in bytes.
    #[ts(type = "number")]
    pub bytes: u64,
    /// Logs of autopilots that lie beside it, by their files' names.
    pub logs: Vec<String>,
    /// It was ended. One that was not is being written, or was cut off with its program.
    pub finished: bool,
}
