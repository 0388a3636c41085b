//! What operators and programs do, as it is recorded.
//!
//! Must never do: hold a secret that was sent along.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;

/// One action.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Audit {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// Who: an operator's name or a program's; empty if nobody says.
    pub who: String,
    /// Over what: `api`, `ros2`, `node`.
    pub over: String,
    /// What was asked: `POST /api/v1/formations`, the name of a service.
    pub what: String,
    /// With what: the body of the request, as text, cut where it is long.
    pub with: String,
    /// What came of it: a status of HTTP, `accepted`, a refusal.
    pub outcome: String,
}
