//! Which tracks are of our own vehicles: nobody must flee from itself, and nobody must take a stranger that comes near for one of ours.
//!
//! A track is ours if it was first seen at one of our vehicles and has stayed with it since. One that was a stranger and sticks to a
//! vehicle which gives way to it is that vehicle after all: from a stranger one gets away.
//!
//! Must never do: read a clock or the shared state.

use skein_domain::payload::Track;
use skein_domain::{NodeTime, VehicleId};
use skein_view::PeerEntry;
use std::collections::BTreeMap;

/// First seen this near to one of our vehicles, and with its velocity, a track is that vehicle's, in metres.
const FIRST_SEEN_M: f64 = 5.0;
/// It stays that as long as it is no further from it than this, in metres.
const STAYS_M: f64 = 8.0;
/// Velocities that differ by more than this are of two, in metres per second.
const SAME_VELOCITY_M_S: f64 = 3.0;
/// A stranger that is this near to a vehicle of ours, in metres, for so long, in seconds, is that vehicle: it is seen where it is.
const STICKS_M: f64 = 3.0;
const STICKS_S: f64 = 3.0;

/// Whose a track is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Owner {
    /// This vehicle of ours.
    Ours(VehicleId),
    /// Somebody else, perhaps right beside a vehicle of ours since a time.
    Stranger(Option<(VehicleId, NodeTime)>),
}

/// What is known of the tracks of this moment.
#[derive(Debug, Clone, Default)]
pub struct OwnTracks {
    known: BTreeMap<u64, Owner>,
}

impl OwnTracks {
    /// Those that are not ours. To be asked every period: it remembers where each was first seen.
    pub fn strangers<'a>(&mut self, tracks: &'a [Track], entries: &[PeerEntry], now: NodeTime) -> Vec<&'a Track> {
        self.known.retain(|id, _| tracks.iter().any(|track| track.track == *id));
        let mut strangers = Vec::new();
        for track in tracks {
            let owner = match self.known.get(&track.track) {
                None => first_seen(track, entries),
                Some(known) => still(*known, track, entries, now),
            };
            self.known.insert(track.track, owner);
            if matches!(owner, Owner::Stranger(_)) {
                strangers.push(track);
            }
        }
        strangers
    }

    /// Those that are ours, as they were when it was last asked, and whose each is.
    pub fn ours(&self) -> impl Iterator<Item = (u64, VehicleId)> {
        self.known.iter().filter_map(|(track, owner)| match owner {
            Owner::Ours(vehicle) => Some((*track, *vehicle)),
            Owner::Stranger(_) => None,
        })
    }
}

fn first_seen(track: &Track, entries: &[PeerEntry]) -> Owner {
    match nearest(track, entries) {
        Some((id, off_m, differs_m_s)) if off_m < FIRST_SEEN_M && differs_m_s < SAME_VELOCITY_M_S => Owner::Ours(id),
        _ => Owner::Stranger(None),
    }
}

fn still(known: Owner, track: &Track, entries: &[PeerEntry], now: NodeTime) -> Owner {
    match known {
        Owner::Ours(id) => {
            let with_it = entries.iter().find(|e| e.id == id).and_then(|e| off(track, e));
            match with_it {
                Some((off_m, _)) if off_m < STAYS_M => known,
                _ => Owner::Stranger(None),
            }
        }
        Owner::Stranger(beside) => match nearest(track, entries) {
            Some((id, off_m, differs_m_s)) if off_m < STICKS_M && differs_m_s < SAME_VELOCITY_M_S => match beside {
                Some((same, since)) if same == id => {
                    if now.seconds_since(since) >= STICKS_S {
                        Owner::Ours(id)
                    } else {
                        known
                    }
                }
                _ => Owner::Stranger(Some((id, now))),
            },
            _ => Owner::Stranger(None),
        },
    }
}

/// The vehicle nearest to a track, how far it is from it and by how much its velocity differs.
fn nearest(track: &Track, entries: &[PeerEntry]) -> Option<(VehicleId, f64, f64)> {
    let all = entries.iter().filter_map(|entry| {
        let (off_m, differs_m_s) = off(track, entry)?;
        Some((entry.id, off_m, differs_m_s))
    });
    all.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// How far a vehicle was from a track at the time of the track, and by how much its velocity differs.
fn off(track: &Track, entry: &PeerEntry) -> Option<(f64, f64)> {
    let kinematics = entry.kinematics?;
    let between_s = track.time.seconds_since(kinematics.measured).clamp(-2.0, 2.0);
    let place = kinematics.position.after(&kinematics.velocity, between_s);
    let differs = kinematics.velocity.vector() - track.velocity.vector();
    Some((place.distance_m(&track.position), differs.norm()))
}

#[cfg(test)]
mod tests;
