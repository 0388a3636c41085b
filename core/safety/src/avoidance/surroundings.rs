//! All neighbours of one control period, carried on to now and sorted once, so that each of many vehicles looks at few of them.

use super::{AvoidanceSettings, Cooperation, Neighbour, NeighbourId};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;

/// A state is carried on along its velocity for at most this long, in seconds; after that it stays and only grows less certain.
const CARRIED_ON_S: f64 = 3.0;
/// What is not known of a place grows to this at most, in metres: a vehicle that has long been silent may not sweep the sky.
const UNKNOWN_MAX_M: f64 = 8.0;

/// How far something may be from where it would be at constant velocity after so many seconds.
pub(super) fn unknown_m(age_s: f64, acceleration_m_s2: f64) -> f64 {
    (0.5 * acceleration_m_s2 * age_s * age_s).min(UNKNOWN_MAX_M)
}

/// How long ago something was measured, within what is believed.
pub(super) fn age_s(measured: NodeTime, now: NodeTime) -> f64 {
    now.seconds_since(measured).max(0.0)
}

/// Where something measured a while ago is now at constant velocity.
pub(super) fn carried_on(position: &Vector3<f64>, velocity: &Vector3<f64>, age_s: f64) -> Vector3<f64> {
    position + velocity * age_s.min(CARRIED_ON_S)
}

/// A neighbour as it is believed to be now.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Carried {
    pub id: NeighbourId,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// How far it may be from that place.
    pub uncertain_m: f64,
    /// How much slower it may be than when it was measured, in metres per second: it may have begun to brake at once.
    pub braked_m_s: f64,
    pub age_s: f64,
    pub shares: bool,
    /// It is there as far as is known.
    pub is_there: bool,
}

impl Carried {
    /// None for what is on the ground, or not known in numbers.
    pub fn new(neighbour: &Neighbour, settings: &AvoidanceSettings, now: NodeTime) -> Option<Self> {
        let usable = neighbour.airborne && neighbour.position.is_finite() && neighbour.velocity.is_finite();
        if !usable {
            return None;
        }
        let age_s = age_s(neighbour.measured, now);
        let velocity = neighbour.velocity.vector();
        // What is not a number says nothing; then the own noise is the best guess.
        let given_m = if neighbour.uncertainty_m >= 0.0 {
            neighbour.uncertainty_m
        } else {
            settings.noise_m
        };
        Some(Self {
            id: neighbour.id,
            position: carried_on(&neighbour.position.vector(), &velocity, age_s),
            velocity,
            uncertain_m: given_m + unknown_m(age_s, settings.peer_acceleration_m_s2),
            braked_m_s: (settings.peer_acceleration_m_s2 * age_s).min(velocity.norm()),
            age_s,
            shares: neighbour.cooperation == Cooperation::Shares,
            is_there: neighbour.cooperation != Cooperation::MayCome,
        })
    }
}

/// The neighbours of one control period, for any number of vehicles.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Surroundings {
    /// Those that share, sorted by north.
    sharing: Vec<Carried>,
    /// The others: few, fast, and looked at by everybody.
    others: Vec<Carried>,
    /// Mean velocity of those that share. Relative to it a formation hardly moves, however fast it is.
    drift: Vector3<f64>,
    /// The fastest of them relative to that.
    fastest_m_s: f64,
    /// The least certain of them.
    uncertain_m: f64,
    braked_m_s: f64,
    oldest_s: f64,
}

impl Surroundings {
    /// Everything in the air at this moment. The vehicles that are to be filtered may be among them.
    #[must_use]
    pub fn new(neighbours: &[Neighbour], settings: &AvoidanceSettings, now: NodeTime) -> Self {
        let carried = neighbours.iter().filter_map(|n| Carried::new(n, settings, now));
        let (mut sharing, others): (Vec<_>, Vec<_>) = carried.partition(|c| c.shares);
        sharing.sort_by(|a, b| a.position.x.total_cmp(&b.position.x));
        let count = sharing.len().max(1) as f64;
        let drift = sharing.iter().map(|c| c.velocity).sum::<Vector3<f64>>() / count;
        let most = |of: &dyn Fn(&Carried) -> f64| sharing.iter().map(of).fold(0.0, f64::max);
        Self {
            drift,
            fastest_m_s: most(&|c| (c.velocity - drift).norm()),
            uncertain_m: most(&|c| c.uncertain_m),
            braked_m_s: most(&|c| c.braked_m_s),
            oldest_s: most(&|c| c.age_s),
            sharing,
            others,
        }
    }

    /// How fast anybody that shares may be relative to this velocity.
    pub(super) fn fastest_against_m_s(&self, velocity: &Vector3<f64>) -> f64 {
        (velocity - self.drift).norm() + self.fastest_m_s + self.braked_m_s
    }

    /// The largest uncertainty and age of those that share.
    pub(super) fn worst(&self) -> (f64, f64) {
        (self.uncertain_m, self.oldest_s)
    }

    /// All that share within `reach_m` along north of a place, and all others.
    pub(super) fn near(&self, place: &Vector3<f64>, reach_m: f64) -> impl Iterator<Item = &Carried> {
        let from = self.sharing.partition_point(|c| c.position.x < place.x - reach_m);
        let east = place.y;
        self.sharing
            .iter()
            .skip(from)
            .take_while(move |c| c.position.x <= place.x + reach_m)
            .filter(move |c| (c.position.y - east).abs() <= reach_m)
            .chain(&self.others)
    }
}
