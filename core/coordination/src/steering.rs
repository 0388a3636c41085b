//! What becomes of a setpoint between a vehicle's model and its link, without actors: what the model is told, what the gate makes of what
//! it wants, what is sent where the gate refuses. The vehicle actor calls it once per period.
//!
//! Must never do: read a clock or the shared state by itself, or send anything.

use skein_domain::exchange::{Event, OwnState, PeerState};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{Intent, NodeTime, PositionNed, Refusal, Setpoint, SwarmFrame, Task, VehicleId};
use skein_safety::avoidance::Surroundings;
use skein_safety::{Gate, Steered, Steering};
use skein_view::{PeerEntry, PeerSnapshot};

/// The gate's answer to one setpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct GateAnswer {
    /// It was too fast as it was wanted, and is flown slower.
    pub slowed: Option<Refusal>,
    /// What may be sent.
    pub outcome: Result<Steered, Refusal>,
}

/// Has the gate steer a setpoint of the vehicle of this entry.
#[must_use]
pub fn steer(
    gate: &Gate,
    entry: &PeerEntry,
    wanted: &Setpoint,
    surroundings: &Surroundings,
    now: NodeTime,
) -> GateAnswer {
    let Some(own) = entry.kinematics.as_ref() else {
        return GateAnswer {
            slowed: None,
            outcome: Err(Refusal::NoPosition),
        };
    };
    let own = of(entry, own);
    let steer = |setpoint: &Setpoint| gate.steer(&own, setpoint, surroundings, now);
    match steer(wanted) {
        // Too fast is mended by flying slower on the same way; stopping in the midst of others would be worse.
        Err(refusal @ Refusal::TooFast { .. }) => GateAnswer {
            slowed: Some(refusal),
            outcome: steer(&gate.slowed(wanted)),
        },
        outcome => GateAnswer { slowed: None, outcome },
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

/// What a vehicle's model is told of the intent in one period: a task that is newer than `version`, and the anchor of its formation.
pub fn told(intent: &Intent, peers: &PeerSnapshot, id: VehicleId, version: &mut u64) -> Vec<Event> {
    let mut events = Vec::new();
    let Some(task) = intent.tasks.get(&id) else {
        return events;
    };
    if task.version > *version {
        *version = task.version;
        events.push(Event::Task(task.clone()));
    }
    if let Task::Follow { leader, .. } = &task.task {
        let anchor = match leader {
            Some(leader) => peers.entry(*leader).and_then(|e| e.anchor),
            None => peers.anchor,
        };
        events.extend(anchor.map(Event::Anchor));
    }
    events
}

/// A vehicle's own state as its plugins see it.
#[must_use]
pub fn own_state(entry: &PeerEntry, frame: Option<SwarmFrame>) -> OwnState {
    OwnState {
        kinematics: entry.kinematics,
        mode: entry.telemetry.mode,
        armed: entry.telemetry.armed,
        landed: entry.telemetry.landed,
        ready_to_arm: entry.telemetry.ready_to_arm,
        home: entry.home,
        battery: entry.telemetry.battery,
        link_connected: entry.link.connected,
        roll_rad: Some(f64::from(entry.telemetry.roll_rad)),
        pitch_rad: Some(f64::from(entry.telemetry.pitch_rad)),
        global: entry.telemetry.global,
        frame_origin: frame.map(|frame| frame.origin),
        link_loss: entry.link.connected.then_some(f64::from(entry.link.loss)),
        link_round_trip_s: entry.link.round_trip_s.map(f64::from),
    }
}

/// All vehicles with a position but one, as plugins see them.
#[must_use]
pub fn others(peers: &PeerSnapshot, own: VehicleId) -> Vec<PeerState> {
    let known = |entry: &PeerEntry| {
        Some(PeerState {
            id: entry.id,
            kinematics: entry.kinematics?,
            airborne: entry.airborne,
        })
    };
    let others = peers.entries.iter().filter(|entry| entry.id != own);
    others.filter_map(known).collect()
}
