//! Everything in the air as the separation filter wants it: our vehicles, tracks, and aircraft that were sighted.
//!
//! Must never do: leave out one whose position is known. Who is in doubt is taken for one that does not give way.

use skein_coordination::neighbours::{estimated, vehicle};
use skein_domain::NodeTime;
use skein_safety::avoidance::{Cooperation, Neighbour, NeighbourId, Surroundings};
use skein_state::SharedState;
use skein_view::PeerEntry;
use std::hash::{DefaultHasher, Hash, Hasher};

/// How far the position of an aircraft that reports itself may be wrong, with half its size, in metres.
const AIRCRAFT_UNCERTAINTY_M: f64 = 30.0;
/// A sighting older than this is not looked at any more, in seconds.
const SIGHTING_KEPT_S: f64 = 15.0;

/// All of them at this moment.
pub(crate) fn surroundings(shared: &SharedState, entries: &[PeerEntry], now: NodeTime) -> Surroundings {
    let settings = shared.gate().avoidance();
    let mut all: Vec<Neighbour> = entries.iter().flat_map(|entry| vehicle(entry, now)).collect();
    all.extend(
        shared
            .observed
            .strange_tracks(entries, now)
            .iter()
            .filter_map(estimated),
    );
    all.extend(sighted(shared, now));
    Surroundings::new(&all, &settings, now)
}

/// Aircraft and movers that were sighted. Those on the ground cannot be told from those in the air: all are kept away from.
fn sighted(shared: &SharedState, now: NodeTime) -> Vec<Neighbour> {
    let Some(frame) = shared.frame() else { return Vec::new() };
    shared
        .observed
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
