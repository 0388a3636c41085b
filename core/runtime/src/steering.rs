//! What becomes of a setpoint between a vehicle's model and its link, without actors: what the model is told, what the gate makes of what
//! it wants, what is sent where the gate refuses. The vehicle actor calls it once per period.
//!
//! Must never do: read a clock or the board by itself, or send anything.

pub use crate::neighbours::{track as tracked, vehicle as neighbour};
pub use crate::payload::others;
pub use crate::vehicle::{own_state, told};

use crate::board::PeerEntry;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, Refusal, Setpoint};
use skein_safety::avoidance::Surroundings;
use skein_safety::{Gate, Steered, Steering};

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
    let own = of(entry, own);
    let steer = |setpoint: &Setpoint| gate.steer(&own, setpoint, surroundings, now);
    match steer(wanted) {
        // Too fast is mended by flying slower on the same way; stopping in the midst of others would be worse.
        Err(refusal @ Refusal::TooFast { .. }) => Answer {
            slowed: Some(refusal),
            outcome: steer(&gate.slowed(wanted)),
        },
        outcome => Answer { slowed: None, outcome },
    }
}

/// What is flown in place of a setpoint that the gate refused: holding this place, off others and inside of the fences.
#[must_use]
pub fn hold(
    gate: &Gate,
    entry: &PeerEntry,
    place: PositionNed,
    surroundings: &Surroundings,
    now: NodeTime,
) -> Setpoint {
    let Some(own) = entry.kinematics.as_ref() else {
        return Setpoint::hold(place, None);
    };
    let hold = Setpoint::hold(place, Some(own.yaw_rad));
    gate.hold(&of(entry, own), &hold, surroundings, now).setpoint
}

/// How far below the swarm's origin the ground is under a vehicle, in metres: at the height of the place it took off from; where that
/// is not known, of the swarm's origin, which is another's.
#[must_use]
pub fn ground_down_m(entry: &PeerEntry) -> f64 {
    entry.home.map_or(0.0, |home| home.down_m)
}

fn of<'a>(entry: &PeerEntry, kinematics: &'a VehicleKinematics) -> Steering<'a> {
    Steering {
        id: entry.id,
        kinematics,
        airborne: entry.airborne,
        ground_down_m: Some(ground_down_m(entry)),
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
