//! What is known of an emergency stop: that it is unlocked, and why nothing is done with a vehicle that was stopped.
//!
//! Must never do: stop anything.

use skein_domain::{NodeTime, Refusal, RequestId};

/// Request id of the stop itself, beyond what models and actors use.
pub const EMERGENCY_REQUEST: RequestId = RequestId(u32::MAX - 1);

/// The stop, unlocked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmergencyUnlock {
    /// The key of the second step.
    pub key: String,
    /// Until then it is good.
    pub until: NodeTime,
}

/// Why nothing is done with a vehicle whose motors were stopped.
pub fn stopped() -> Refusal {
    Refusal::NotPermitted {
        detail: "its motors were stopped in an emergency; an operator has to arm it again".into(),
    }
}
