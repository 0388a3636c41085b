//! A formation that keeps itself: each vehicle works out its own velocity from its neighbours' states alone.
//!
//! Must never do: use a state older than the limits say, steer by a number that is not finite, or ask for more speed than the limits allow.

mod graph;

use nalgebra::Vector3;
use skein_domain::exchange::PeerState;
use skein_domain::{
    FlightLimits, Keeping, KeepingLaw, NeighbourPlace, NodeTime, OffsetFrd, PositionNed, VehicleId, VelocityNed,
};
use std::collections::VecDeque;

pub use graph::{bearing_rank, distance_rank, neighbours};

/// Neighbours a vehicle gets if there are that many.
pub const USUAL_NEIGHBOURS: usize = 4;
/// In the distance law, the part of the correction that brings back the whole pattern of neighbours as it may be turned; the rest is the
/// gradient of the distances. Without it a row of vehicles could bend and a shape could flip over.
const PATTERN_SHARE: f64 = 0.5;
/// In the bearing law, the weight of the distance along the bearing, where one across it weighs one. Without it the shape could grow and
/// shrink.
const ALONG_BEARING: f64 = 0.4;
/// Nobody of those who know better is heard: the others' mean velocity is taken over with this share of it, so that a swarm whose leader
/// is gone comes to rest.
const LEADERLESS_SHARE: f64 = 0.9;

/// How a vehicle keeps its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeepingTuning {
    /// How fast a difference is closed, per second. Stable with delays up to about half its inverse.
    pub gain_hz: f64,
    /// The correction is never faster than this, in metres per second.
    pub max_correction_m_s: f64,
    /// A neighbour's state is carried on with its velocity for at most this long, in seconds; older ones are left out.
    pub max_age_s: f64,
}

impl Default for KeepingTuning {
    fn default() -> Self {
        Self {
            gain_hz: 0.6,
            max_correction_m_s: 2.5,
            max_age_s: 1.5,
        }
    }
}

/// What a vehicle should do now to keep its place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KeepingCommand {
    /// The velocity to fly: the formation's with the correction, within the limits.
    pub velocity: VelocityNed,
    /// The part of it that is the formation's.
    pub formation_velocity: VelocityNed,
    /// How far its place among its neighbours is off, in metres: the mean over them.
    pub error_m: f64,
    /// How many neighbours it goes by. With none the velocity is zero.
    pub neighbours: usize,
}

/// A neighbour as it is now.
struct SeenNeighbour {
    /// Where it is, relative to the vehicle.
    off: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Where it belongs, relative to the vehicle.
    place: Vector3<f64>,
    hops: Option<u16>,
}

/// The velocity for a vehicle at `position` at `now`, given what it knows of others. Those it does not have as neighbours are not looked
/// at; neighbours that are missing, too old, on the ground or not finite drop out, and the rest of the shape stays.
#[must_use]
pub fn command(
    keeping: &Keeping,
    position: &PositionNed,
    peers: &[PeerState],
    now: NodeTime,
    limits: &FlightLimits,
    tuning: &KeepingTuning,
) -> KeepingCommand {
    let seen: Vec<SeenNeighbour> = keeping
        .neighbours
        .iter()
        .filter_map(|neighbour| see(neighbour, position, peers, now, tuning))
        .collect();
    if seen.is_empty() || !position.is_finite() {
        return KeepingCommand::default();
    }
    let own_hops = own_hops(keeping);
    let formation = formation_velocity(&seen, own_hops);
    let (correction, error_m) = match keeping.law {
        KeepingLaw::Distances => by_distances(&seen),
        KeepingLaw::Bearings => by_bearings(&seen),
    };
    let correction = (correction * tuning.gain_hz).cap_magnitude(tuning.max_correction_m_s.max(0.0));
    KeepingCommand {
        velocity: within(formation + correction, limits).into(),
        formation_velocity: formation.into(),
        error_m,
        neighbours: seen.len(),
    }
}

fn see(
    neighbour: &NeighbourPlace,
    position: &PositionNed,
    peers: &[PeerState],
    now: NodeTime,
    tuning: &KeepingTuning,
) -> Option<SeenNeighbour> {
    let peer = peers
        .iter()
        .find(|peer| peer.id == neighbour.vehicle && peer.airborne)?;
    let kinematics = &peer.kinematics;
    let age_s = now.seconds_since(kinematics.measured);
    // One from the future is of another clock: as wrong as one too old.
    let young = age_s.abs() <= tuning.max_age_s;
    if !young {
        return None;
    }
    let there = kinematics.position.after(&kinematics.velocity, age_s.max(0.0));
    let seen = SeenNeighbour {
        off: there.vector() - position.vector(),
        velocity: kinematics.velocity.vector(),
        place: Vector3::new(neighbour.north_m, neighbour.east_m, neighbour.down_m),
        hops: neighbour.hops,
    };
    let finite = (seen.off.norm() + seen.velocity.norm() + seen.place.norm()).is_finite();
    finite.then_some(seen)
}

/// One more than the nearest neighbour to the leader has.
fn own_hops(keeping: &Keeping) -> Option<u16> {
    let nearest = keeping.neighbours.iter().filter_map(|n| n.hops).min()?;
    Some(nearest.saturating_add(1))
}

/// The velocity of the formation: that of the neighbours nearer to the leader. Taking it from nobody farther off keeps it from going round
/// in circles, in which delays would add up to swinging.
fn formation_velocity(seen: &[SeenNeighbour], own_hops: Option<u16>) -> Vector3<f64> {
    let mean = |nearer: &dyn Fn(&SeenNeighbour) -> bool| {
        let (count, sum) = seen
            .iter()
            .filter(|s| nearer(s))
            .fold((0.0, Vector3::zeros()), |(count, sum), s| {
                (count + 1.0, sum + s.velocity)
            });
        (count > 0.0).then(|| sum / count)
    };
    let leader = mean(&|s| s.hops == Some(0));
    let nearer = || mean(&|s| own_hops.is_some_and(|own| s.hops.is_some_and(|hops| hops < own)));
    leader
        .or_else(nearer)
        .or_else(|| mean(&|_| true).map(|all| all * LEADERLESS_SHARE))
        .unwrap_or_default()
}

/// The gradient of the distances in the plane (Krick, Broucke & Francis 2009), with the pattern as it is turned best; heights as they are.
fn by_distances(seen: &[SeenNeighbour]) -> (Vector3<f64>, f64) {
    let count = seen.len() as f64;
    let (along, across) = seen.iter().fold((0.0, 0.0), |(along, across), s| {
        (
            along + s.place.x * s.off.x + s.place.y * s.off.y,
            across + s.place.x * s.off.y - s.place.y * s.off.x,
        )
    });
    // The turn about the vertical that fits best (Kabsch 1976 in two dimensions).
    let (sin, cos) = across.atan2(along).sin_cos();
    let (mut correction, mut error_m) = (Vector3::zeros(), 0.0);
    for s in seen {
        let (is2, wanted2) = (s.off.xy().norm_squared(), s.place.xy().norm_squared());
        let stretch = if is2 + wanted2 > 0.0 {
            (is2 - wanted2) / (is2 + wanted2)
        } else {
            0.0
        };
        let gradient = s.off.xy() * stretch;
        let turned = nalgebra::Vector2::new(s.place.x * cos - s.place.y * sin, s.place.x * sin + s.place.y * cos);
        let pattern = s.off.xy() - turned;
        let level = gradient * (1.0 - PATTERN_SHARE) + pattern * PATTERN_SHARE;
        let height = s.off.z - s.place.z;
        correction += Vector3::new(level.x, level.y, height);
        error_m += (is2.sqrt() - wanted2.sqrt()).hypot(height);
    }
    (correction / count, error_m / count)
}

/// What is off across the wanted direction (Zhao & Zelazo 2016), and with less weight along it.
fn by_bearings(seen: &[SeenNeighbour]) -> (Vector3<f64>, f64) {
    let count = seen.len() as f64;
    let (mut correction, mut error_m) = (Vector3::zeros(), 0.0);
    for s in seen {
        let off = s.off - s.place;
        let along = s
            .place
            .try_normalize(1e-9)
            .map_or(Vector3::zeros(), |direction| direction * direction.dot(&off));
        correction += off - along * (1.0 - ALONG_BEARING);
        error_m += off.norm();
    }
    (correction / count, error_m / count)
}

fn within(velocity: Vector3<f64>, limits: &FlightLimits) -> Vector3<f64> {
    let level = velocity.xy().cap_magnitude(limits.max_speed_m_s.max(0.0));
    let vertical = velocity
        .z
        .max(-limits.max_climb_m_s.max(0.0))
        .min(limits.max_descent_m_s.max(0.0));
    Vector3::new(level.x, level.y, vertical)
}

/// What every vehicle but the leader has to keep, for a shape with these slots and this heading. Everyone's own place is among the
/// `members`, the leader's too.
#[must_use]
pub fn keepings(
    members: &[(VehicleId, OffsetFrd)],
    leader: Option<VehicleId>,
    heading_rad: f64,
    law: KeepingLaw,
    start: NodeTime,
) -> Vec<(VehicleId, Keeping)> {
    let slots: Vec<OffsetFrd> = members.iter().map(|(_, slot)| *slot).collect();
    let graph = neighbours(&slots, USUAL_NEIGHBOURS);
    let leads = members.iter().position(|(id, _)| Some(*id) == leader);
    let hops = hops_from(leads, &graph);
    let keeping = |i: usize, slot: &OffsetFrd| {
        let own = slot.rotated(heading_rad);
        let place = |j: &usize| {
            let (vehicle, slot) = members.get(*j)?;
            let off = slot.rotated(heading_rad) - own;
            Some(NeighbourPlace {
                vehicle: *vehicle,
                north_m: off.x,
                east_m: off.y,
                down_m: off.z,
                hops: hops.get(*j).copied().flatten(),
            })
        };
        Keeping {
            law,
            neighbours: graph.get(i).into_iter().flatten().filter_map(place).collect(),
            leader,
            start,
        }
    };
    members
        .iter()
        .enumerate()
        .filter(|(_, (id, _))| Some(*id) != leader)
        .map(|(i, (id, slot))| (*id, keeping(i, slot)))
        .collect()
}

/// How many steps everyone is from the leader.
fn hops_from(leads: Option<usize>, graph: &[Vec<usize>]) -> Vec<Option<u16>> {
    let mut hops = vec![None; graph.len()];
    let mut next = VecDeque::new();
    if let Some((leads, slot)) = leads.and_then(|i| hops.get_mut(i).map(|slot| (i, slot))) {
        *slot = Some(0_u16);
        next.push_back((leads, 0_u16));
    }
    while let Some((i, here)) = next.pop_front() {
        for j in graph.get(i).into_iter().flatten() {
            if let Some(slot @ None) = hops.get_mut(*j) {
                *slot = Some(here.saturating_add(1));
                next.push_back((*j, here.saturating_add(1)));
            }
        }
    }
    hops
}

#[cfg(test)]
mod tests;
