//! What all know of an emergency stop: its request, and why nothing is done with a vehicle that was stopped.
//!
//! Must never do: stop anything.

use skein_domain::{Refusal, RequestId};

/// Request id of the stop itself, beyond what models and actors use.
pub const EMERGENCY_REQUEST: RequestId = RequestId(u32::MAX - 1);

/// Why nothing is done with a vehicle whose motors were stopped.
pub fn stopped() -> Refusal {
    Refusal::not_permitted("its motors were stopped in an emergency; an operator has to arm it again")
}
