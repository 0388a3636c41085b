//! What becomes of a setpoint between a vehicle's model and its link, without actors: what the model is told, what the gate makes of what
//! it wants, what is sent where the gate refuses. The vehicle actor calls it once per period.
//!
//! Must never do: read a clock or the board by itself, or send anything.

pub use crate::neighbours::{track as tracked, vehicle as neighbour};
pub use crate::vehicle::{own_state, told};

use crate::board::PeerEntry;
use skein_domain::{NodeTime, Refusal, Setpoint};
use skein_safety::avoidance::Surroundings;
use skein_safety::{Gate, Steered};

/// The gate's answer to one setpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// It was too fast as it was wanted, and is flown slower.
    pub slowed: Option<Refusal>,
    /// What may be sent.
    pub outcome: Result<Steered, Refusal>,
}

/// Has the gate steer a setpoint of the vehicle of this entry.
#[must_use]
pub fn steer(gate: &Gate, entry: &PeerEntry, wanted: &Setpoint, surroundings: &Surroundings, now: NodeTime) -> Answer {
    let Some(own) = entry.kinematics.as_ref() else {
        return Answer {
            slowed: None,
            outcome: Err(Refusal::NoPosition),
        };
    };
    let steer = |setpoint: &Setpoint| gate.steer(entry.id, own, entry.airborne, setpoint, surroundings, now);
    match steer(wanted) {
        // Too fast is mended by flying slower on the same way; stopping in the midst of others would be worse.
        Err(refusal @ Refusal::TooFast { .. }) => Answer {
            slowed: Some(refusal),
            outcome: steer(&gate.slowed(wanted)),
        },
        outcome => Answer { slowed: None, outcome },
    }
}

/// Whether a refused setpoint is answered with a stop. Nothing is sent when the vehicle is not ours to steer or cannot be steered.
#[must_use]
pub fn is_answered_by_holding(refusal: &Refusal) -> bool {
    !matches!(
        refusal,
        Refusal::PilotInControl
            | Refusal::NotPermitted { .. }
            | Refusal::LinkLost { .. }
            | Refusal::NoPosition
            | Refusal::NoSwarmFrame
    )
}
