//! Recordings of flights, as the API has them.

use schemars::JsonSchema;
use serde::Serialize;
use ts_rs::TS;

/// Recordings on this node.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct FlightList {
    /// The newest first.
    pub flights: Vec<RecordedFlight>,
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
    /// It was ended. One that was not is being written, or was cut off with its program.
    pub finished: bool,
}
