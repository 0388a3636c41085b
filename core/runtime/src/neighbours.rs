//! Everything in the air as the separation filter wants it: our vehicles, with whether they do their part, tracks, and aircraft that
//! were sighted.
//!
//! Must never do: leave out one whose position is known. Who is in doubt is taken for one that does not give way.

use crate::board::{Board, PeerEntry};
use skein_domain::payload::Track;
use skein_domain::{FlightState, NodeTime, PositionNed, VelocityNed};
use skein_safety::avoidance::{Cooperation, Neighbour, NeighbourId, Surroundings};
use std::hash::{DefaultHasher, Hash, Hasher};

/// How far a vehicle's position may be wrong, in metres: three standard deviations of an ordinary satellite estimate relative to another
/// one of the same swarm.
const VEHICLE_UNCERTAINTY_M: f64 = 0.3;
/// The same for what is seen in a picture.
const TRACK_UNCERTAINTY_M: f64 = 2.0;
/// The same for an aircraft that reports itself, with half its size.
const AIRCRAFT_UNCERTAINTY_M: f64 = 30.0;
/// A vehicle not heard for so long, in seconds, hears us no more than we hear it: without setpoints its autopilot stops it.
const STOPS_AFTER_S: f64 = 2.0;
/// By then it has come as far as it came before in so many seconds, give or take half of it: it went on for a second, and braked.
const STOPS_WITHIN_S: f64 = 1.5;
/// Heights over its last known place at which a silent vehicle may be met, in metres: so close that nobody fits between two.
const COLUMN_M: [f64; 7] = [0.0, 5.0, 10.0, 15.0, 20.0, -5.0, -10.0];
/// A vehicle whose state is older than this does not do its part, in seconds.
const FRESH_S: f64 = 0.5;
/// A sighting older than this is not looked at any more, in seconds.
const SIGHTING_KEPT_S: f64 = 15.0;

/// All of them at this moment.
pub fn surroundings(board: &Board, entries: &[PeerEntry], now: NodeTime) -> Surroundings {
    let settings = board.gate().avoidance();
    let mut all: Vec<Neighbour> = entries.iter().flat_map(|entry| column(entry, now)).collect();
    let tracks = board.tracks.load();
    all.extend(
        board
            .own_tracks
            .lock()
            .strangers(&tracks, entries, now)
            .into_iter()
            .map(track),
    );
    all.extend(sighted(board, now));
    Surroundings::new(&all, &settings, now)
}

/// Something tracked as the filters see it.
#[must_use]
pub fn track(track: &Track) -> Neighbour {
    Neighbour {
        id: NeighbourId::Foreign(track.track),
        position: track.position,
        velocity: track.velocity,
        measured: track.time,
        uncertainty_m: TRACK_UNCERTAINTY_M,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    }
}

/// One of our vehicles, and the column over and under it if it has not been heard for so long that its autopilot's own failsafe has it: it
/// returns, for which it climbs first, or it lands. Whoever gave way to it over or under it would meet it.
fn column(entry: &PeerEntry, now: NodeTime) -> Vec<Neighbour> {
    let Some(known) = vehicle(entry, now) else {
        return Vec::new();
    };
    let silent = entry
        .kinematics
        .is_some_and(|k| now.seconds_since(k.measured) > STOPS_AFTER_S);
    let heights_m: &[f64] = if silent && entry.airborne { &COLUMN_M } else { &[0.0] };
    let at = |height_m: &f64| Neighbour {
        position: PositionNed {
            down_m: known.position.down_m - height_m,
            ..known.position
        },
        ..known
    };
    heights_m.iter().map(at).collect()
}

/// One of our vehicles as the others' filters see it; none without a position.
#[must_use]
pub fn vehicle(entry: &PeerEntry, now: NodeTime) -> Option<Neighbour> {
    let kinematics = entry.kinematics?;
    let fresh = now.seconds_since(kinematics.measured) <= FRESH_S;
    let lost = matches!(entry.flight_state, FlightState::PilotControl | FlightState::Faulted);
    let in_our_hands = entry.link.connected && !lost && entry.link.setpoint_rate_hz > 0.0;
    let stopped = now.seconds_since(kinematics.measured) > STOPS_AFTER_S;
    let stops_m = STOPS_WITHIN_S * kinematics.velocity.norm();
    Some(Neighbour {
        id: NeighbourId::Vehicle(entry.id),
        position: if stopped {
            kinematics.position.after(&kinematics.velocity, STOPS_WITHIN_S)
        } else {
            kinematics.position
        },
        velocity: if stopped {
            VelocityNed::default()
        } else {
            kinematics.velocity
        },
        measured: if stopped { now } else { kinematics.measured },
        uncertainty_m: if stopped {
            VEHICLE_UNCERTAINTY_M + 0.5 * stops_m
        } else {
            VEHICLE_UNCERTAINTY_M
        },
        cooperation: if fresh && in_our_hands {
            Cooperation::Shares
        } else {
            Cooperation::DoesNot
        },
        airborne: entry.airborne,
    })
}

/// Aircraft and movers that were sighted. Those on the ground cannot be told from those in the air: all are kept away from.
fn sighted(board: &Board, now: NodeTime) -> Vec<Neighbour> {
    let Some(frame) = board.frame() else { return Vec::new() };
    board
        .sightings
        .since(now.plus_seconds(-SIGHTING_KEPT_S))
        .into_iter()
        .map(|sighting| {
            let mut hasher = DefaultHasher::new();
            sighting.source.hash(&mut hasher);
            Neighbour {
                id: NeighbourId::Foreign(hasher.finish()),
                position: frame.position(&sighting.place),
                velocity: sighting.velocity.unwrap_or_default(),
                measured: sighting.time,
                uncertainty_m: AIRCRAFT_UNCERTAINTY_M,
                cooperation: Cooperation::DoesNot,
                airborne: true,
            }
        })
        .collect()
}
