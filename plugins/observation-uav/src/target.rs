//! What is looked at: where it was last seen, how it moves, and whether it is still there.

use crate::settings::Settings;
use minicbor::{Decode, Encode};
use skein_plugin_sdk::domain::exchange::PeerState;
use skein_plugin_sdk::domain::payload::{Target, Track};
use skein_plugin_sdk::domain::{NodeTime, PositionNed, Refusal, VehicleId, VelocityNed};

/// A change of velocity above this is planned for at once, in metres per second.
const REPLAN_VELOCITY_M_S: f64 = 0.1;

/// Where something was at a moment, and how it moved.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Sighting {
    #[n(0)]
    pub position: PositionNed,
    #[n(1)]
    pub velocity: VelocityNed,
    #[n(2)]
    pub time: NodeTime,
    /// Standard deviation of the position in metres, if somebody says.
    #[n(3)]
    pub error_m: Option<f64>,
}

impl Sighting {
    fn usable(position: PositionNed, velocity: VelocityNed, time: NodeTime, error_m: Option<f64>) -> Option<Self> {
        let velocity = if velocity.is_finite() {
            velocity
        } else {
            VelocityNed::default()
        };
        position.is_finite().then_some(Self {
            position,
            velocity,
            time,
            error_m: error_m.filter(|error_m| error_m.is_finite()),
        })
    }

    /// Where it is at a moment if it goes on as it did, for at most `longest_s`.
    pub(crate) fn at(&self, now: NodeTime, longest_s: f64) -> PositionNed {
        let age_s = now.seconds_since(self.time).clamp(0.0, longest_s);
        self.position.after(&self.velocity, age_s)
    }
}

/// Everything that can be looked at beside places, as last heard of.
#[derive(Debug, Default)]
pub(crate) struct Sightings {
    pub peers: Vec<PeerState>,
    pub tracks: Vec<Track>,
}

impl Sightings {
    /// Where the target was last, if it is known at all.
    pub(crate) fn of(&self, target: &Target, now: NodeTime) -> Option<Sighting> {
        match target {
            Target::Place { position } => Sighting::usable(*position, VelocityNed::default(), now, None),
            Target::Vehicle { vehicle } => {
                let peer = self.peers.iter().find(|peer| peer.id == *vehicle)?.kinematics;
                Sighting::usable(peer.position, peer.velocity, peer.measured, None)
            }
            Target::Track { track } => {
                let track = self.tracks.iter().find(|known| known.track == *track)?;
                Sighting::usable(track.position, track.velocity, track.time, track.error_m)
            }
        }
    }
}

/// Why there is nothing to look at.
pub(crate) fn missing(target: &Target) -> Refusal {
    match target {
        Target::Place { .. } => Refusal::invalid("the place is not finite"),
        Target::Vehicle { vehicle } => Refusal::UnknownVehicle { vehicle: *vehicle },
        Target::Track { track } => Refusal::UnknownTrack { track: *track },
    }
}

/// In words.
pub(crate) fn words(target: &Target) -> String {
    match target {
        Target::Place { position } => format!(
            "the place {:.0} m north, {:.0} m east",
            position.north_m, position.east_m
        ),
        Target::Vehicle { vehicle } => format!("vehicle {vehicle}"),
        Target::Track { track } => format!("track {track}"),
    }
}

/// A target that is being looked at.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Aimed {
    #[n(0)]
    pub target: Target,
    /// When the looking began.
    #[n(1)]
    since: NodeTime,
    /// As last seen.
    #[n(2)]
    seen: Option<Sighting>,
    /// The motion that is planned with: only changed when it is off by enough.
    #[n(3)]
    planned: Option<Sighting>,
}

impl Aimed {
    pub(crate) fn new(target: Target, now: NodeTime) -> Self {
        Self {
            target,
            since: now,
            seen: None,
            planned: None,
        }
    }

    /// Looks where it is now; whether it is still there.
    pub(crate) fn look(&mut self, sightings: &Sightings, now: NodeTime, settings: &Settings) -> bool {
        let longest_s = settings.target_timeout_s;
        if let Some(sighting) = sightings.of(&self.target, now) {
            self.seen = Some(sighting);
            let fits = self.planned.is_some_and(|planned| {
                let off_m = planned.at(now, longest_s).distance_m(&sighting.at(now, longest_s));
                let change_m_s = (planned.velocity.vector() - sighting.velocity.vector()).norm();
                let fresh = now.seconds_since(planned.time) < longest_s;
                off_m <= settings.replan_distance_m && change_m_s <= REPLAN_VELOCITY_M_S && fresh
            });
            if !fits {
                self.planned = Some(sighting);
            }
        }
        let last = self.seen.map_or(self.since, |seen| seen.time);
        now.seconds_since(last) <= longest_s
    }

    /// Where it is, and how it moves, as planned with.
    pub(crate) fn motion(&self, now: NodeTime, settings: &Settings) -> Option<(PositionNed, VelocityNed)> {
        let planned = self.planned?;
        Some((planned.at(now, settings.target_timeout_s), planned.velocity))
    }

    /// How well it is known where it is: a standard deviation in metres, 0 where nobody says.
    pub(crate) fn error_m(&self) -> f64 {
        self.seen.and_then(|seen| seen.error_m).unwrap_or(0.0)
    }

    /// Where it is as far as is known.
    pub(crate) fn position(&self, now: NodeTime, settings: &Settings) -> Option<PositionNed> {
        self.seen.map(|seen| seen.at(now, settings.target_timeout_s))
    }
}

/// Whether a target can be one for this vehicle.
pub(crate) fn check(target: &Target, own: VehicleId) -> Result<(), Refusal> {
    match target {
        Target::Vehicle { vehicle } if *vehicle == own => Err(Refusal::invalid("a vehicle cannot look at itself")),
        Target::Place { position } if !position.is_finite() => Err(missing(target)),
        _ => Ok(()),
    }
}
