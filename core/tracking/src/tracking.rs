//! The tracking actor: makes tracks of the swarm of what this node's detectors find, of what other sensors tell over the API, and of what other nodes' sensors
//! saw. Where another node coordinates, it hands on what was seen here and waits for that node's tracks; when this node coordinates, or hears nobody who does, it
//! goes on with them.
//!
//! Bound: one step at a time, the next is asked for when the last is done; of each kind of sightings a step takes the newest 512. Must never do: command a
//! vehicle by itself, but for who takes over an observation that an operator asked for; hold up anything that flies.

use crate::carrying::{AskVehicle, Carrying};
use crate::geolocation::DetectorsSeen;
use crate::shown;
use crate::telling::Telling;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::NodeTime;
use skein_domain::payload::TrackEstimate;
use skein_failover::LeaderState;
use skein_state::{SharedState, TrackingMessage};
use skein_view::PeerSnapshot;
use skein_vision::{OwnVehicle, Sighting, SwarmSettings, SwarmTracker};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;

/// Time between two looks at what was seen.
const LOOK: Duration = Duration::from_millis(20);
/// Time between two steps, in seconds, while nothing is seen.
const STEP_S: f64 = 0.05;
/// Of each kind of sightings a step takes no more than this: the newest.
const MOST_PER_STEP: usize = 512;
/// Time between two pictures of the tracks, in seconds: plugins and other nodes are told no more often.
const SHOWN_EVERY_S: f64 = 0.1;
/// How far a vehicle of ours may be from where its telemetry says it is, with half of its size, in metres: one standard deviation.
const OWN_ERROR_M: f64 = 1.5;

/// The actor.
pub struct Tracking;

/// What the actor is given.
#[derive(Clone)]
pub struct TrackingArguments {
    /// The node's shared state.
    pub shared: Arc<SharedState>,
    /// For who takes over an observation.
    pub ask: AskVehicle,
}

/// State. The tracks themselves are in the shared state too, from where the next incarnation, or another node, goes on with them.
pub struct TrackingState {
    ask: AskVehicle,
    pub(crate) shared: Arc<SharedState>,
    detectors: DetectorsSeen,
    /// There while tracks are made here.
    pub(crate) tracker: Option<SwarmTracker>,
    pub(crate) telling: Telling,
    carrying: Carrying,
    stepped: NodeTime,
    shown: NodeTime,
}

impl Actor for Tracking {
    type Msg = TrackingMessage;
    type State = TrackingState;
    type Arguments = TrackingArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<TrackingMessage>,
        arguments: TrackingArguments,
    ) -> Result<TrackingState, ActorProcessingErr> {
        myself.cast(TrackingMessage::Step)?;
        Ok(TrackingState {
            shared: arguments.shared,
            ask: arguments.ask,
            detectors: DetectorsSeen::default(),
            tracker: None,
            telling: Telling::default(),
            carrying: Carrying::default(),
            stepped: NodeTime::default(),
            shown: NodeTime::default(),
        })
    }

    async fn handle(
        &self,
        myself: ActorRef<TrackingMessage>,
        message: TrackingMessage,
        state: &mut TrackingState,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            TrackingMessage::Step => {
                let began = Instant::now();
                state.step().await;
                // After one that took long it rests as long: no more than half of a processor goes into it, whatever comes.
                myself.send_after(LOOK.max(began.elapsed()), || TrackingMessage::Step);
            }
            // Who has gone does not wait for the answer.
            TrackingMessage::Order(order, reply) => drop(reply.send(state.order(order))),
        }
        Ok(())
    }
}

impl TrackingState {
    async fn step(&mut self) {
        let now = self.shared.now();
        let seen = &self.shared.observed.seen;
        let mut sightings = self.detectors.look(&self.shared, now);
        seen.count_by_cameras(sightings.len());
        let pictures: BTreeSet<NodeTime> = sightings.iter().map(|sighting| sighting.time).collect();
        sightings.extend(seen.take_told(MOST_PER_STEP));
        if !self.makes_tracks() {
            self.follow(sightings, now);
            return;
        }
        sightings.extend(seen.take_heard(MOST_PER_STEP));
        if sightings.is_empty() && now.seconds_since(self.stepped) < STEP_S {
            return;
        }
        self.stepped = now;
        let own = own_vehicles(&self.shared.peers());
        let mut tracker = self.take_tracker();
        // Beside the actors: what is seen is worked on for as long as it takes, and nobody waits for it.
        let worked = tokio::task::spawn_blocking(move || {
            work(&mut tracker, sightings, &own, now);
            tracker
        });
        match worked.await {
            Ok(tracker) => {
                self.tracker = Some(tracker);
                let known = self.shared.now();
                for taken in pictures {
                    self.shared.observed.seen.count_in_tracks(known.seconds_since(taken));
                }
            }
            // The next step goes on from what was shown last.
            Err(error) => tracing::error!("tracks were lost and are taken up again as last shown: {error}"),
        }
        if now.seconds_since(self.shown) >= SHOWN_EVERY_S {
            self.show(now);
        }
    }

    /// Whether tracks are made here: where this node coordinates, or as long as it hears nobody who does.
    fn makes_tracks(&self) -> bool {
        let role = self.shared.swarm.as_ref().map(|swarm| swarm.role());
        role.is_none_or(|role| {
            let alone = matches!(role.leader_state, LeaderState::Nobody | LeaderState::Unled { .. });
            role.acting.is_some() || alone
        })
    }

    /// Another node coordinates: it is told what was seen here, and its tracks are shown for as long as they mean anything.
    fn follow(&mut self, sightings: Vec<Sighting>, now: NodeTime) {
        let observed = &self.shared.observed;
        observed.seen.tell_others(sightings);
        // What others told while this node coordinated is theirs again.
        observed.seen.take_heard(0);
        observed.retain_fused(|track| shown::is_kept(track, now));
        self.tracker = None;
        self.telling = Telling::default();
        self.carrying = Carrying::default();
    }

    /// The tracker, or one that goes on with the tracks that were shown last.
    pub(crate) fn take_tracker(&mut self) -> SwarmTracker {
        self.tracker.take().unwrap_or_else(|| {
            let before = self.shared.observed.fused();
            let mut tracker = SwarmTracker::new(SwarmSettings::default());
            tracker.take_over(before.iter().filter_map(shown::taken_over));
            self.telling.know(before.iter().map(|track| track.track.track));
            tracker
        })
    }

    /// Shows the tracks to everybody, and does what follows from them.
    pub(crate) fn show(&mut self, now: NodeTime) {
        self.shown = now;
        let tracks = self.tracks(now);
        self.telling.tell(&self.shared, &tracks, now);
        self.shared.observed.publish_fused(tracks);
        self.carrying.look(&self.shared, &self.ask, now);
    }

    fn tracks(&self, now: NodeTime) -> Vec<TrackEstimate> {
        let tracks = self.tracker.iter().flat_map(|tracker| tracker.tracks(now));
        tracks.map(shown::estimate).collect()
    }
}

/// Takes in what was seen, and puts together what belongs together.
fn work(tracker: &mut SwarmTracker, sightings: Vec<Sighting>, own: &[OwnVehicle], now: NodeTime) {
    for sighting in sightings {
        // What cannot be true was refused where it came in; what another node tells in spite of that is left out.
        if let Err(unsound) = tracker.take(sighting) {
            tracing::debug!("a sighting is left out: {unsound}");
        }
    }
    tracker.step(now, own);
}

/// The swarm's own vehicles, which are no tracks.
fn own_vehicles(peers: &PeerSnapshot) -> Vec<OwnVehicle> {
    let of = |entry: &skein_view::PeerEntry| {
        let at = entry.kinematics?;
        Some(OwnVehicle {
            id: entry.id,
            time: at.measured,
            position: at.position.vector(),
            velocity: at.velocity.vector(),
            error_m: OWN_ERROR_M,
        })
    };
    peers.entries.iter().filter_map(of).collect()
}
