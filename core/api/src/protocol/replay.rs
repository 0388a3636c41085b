//! A recorded flight that is shown again, as the API has it.

use schemars::JsonSchema;
use serde::Serialize;
use skein_replay::ReplayState;
use ts_rs::TS;

/// Whether what is shown is a recorded flight.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ReplayAnswer {
    /// Where it is; null for a node that flies.
    pub replay: Option<ReplayState>,
}
