//! What is asked about parameters of autopilots.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::ReadingAction;
use ts_rs::TS;

/// A value for a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterBody {
    /// The value; a whole number where the parameter is one.
    pub value: f64,
}

/// What is to be done about the reading of all parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReadingBody {
    /// What.
    pub action: ReadingAction,
}

/// Name of a parameter, as it stands in a path.
#[derive(JsonSchema)]
#[schemars(transparent)]
pub struct ParameterName(#[schemars(regex(pattern = "^[!-~]{1,16}$"))] pub String);
