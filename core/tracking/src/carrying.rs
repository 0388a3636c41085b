//! Keeps tracks in view that an operator asked to be observed: where a vehicle no longer can, the next best one is asked to take over.
//!
//! Must never do: wait for a vehicle's answer, or ask anybody that an operator did not let the swarm ask.

use crate::candidates::{activity, candidates, looks_at};
use parking_lot::Mutex;
use skein_coordination::TrackObservation;
use skein_coordination::observing::{Change, ObserverState, Unable, changes, ranked};
use skein_domain::exchange::Severity;
use skein_domain::payload::Target;
use skein_domain::{NodeTime, VehicleCommand, VehicleId};
use skein_state::SharedState;
use skein_view::{EventKind, FleetSnapshot};
use std::collections::BTreeMap;
use std::pin::Pin;
use std::sync::Arc;

/// Gives a vehicle a command, wherever it is flown, and says whether it refused.
pub type AskVehicle =
    Arc<dyn Fn(VehicleId, VehicleCommand) -> Pin<Box<dyn Future<Output = bool> + Send>> + Send + Sync>;

/// Time between two looks, in seconds.
const LOOK_S: f64 = 0.5;
/// A vehicle that was asked has begun after so long, in seconds; until then it cannot have left.
const BEGUN_WITHIN_S: f64 = 5.0;
/// Who refused is not asked again for so long, in seconds.
const REFUSED_FOR_S: f64 = 20.0;

/// What is remembered from one look to the next.
#[derive(Debug, Default)]
pub(crate) struct Carrying {
    next: NodeTime,
    /// When each vehicle of an observation was first seen in it.
    since: BTreeMap<(u64, VehicleId), NodeTime>,
    refused: Arc<Mutex<BTreeMap<VehicleId, NodeTime>>>,
    /// Those for which nobody could take over, as told.
    told: BTreeMap<(u64, VehicleId), Unable>,
}

impl Carrying {
    /// Looks whether everybody still looks.
    pub(crate) fn look(&mut self, shared: &Arc<SharedState>, ask: &AskVehicle, now: NodeTime) {
        let observations = shared.observed.observations();
        if now < self.next || observations.is_empty() {
            return;
        }
        self.next = now.plus_seconds(LOOK_S);
        self.refused
            .lock()
            .retain(|_, at| now.seconds_since(*at) < REFUSED_FOR_S);
        let snapshot = shared.picture();
        let kept: Vec<TrackObservation> = observations
            .iter()
            .filter_map(|observation| self.keep(shared, ask, &snapshot, observation, now))
            .collect();
        let is_there = |(track, vehicle): &(u64, VehicleId)| {
            let mut of_track = kept.iter().filter(|kept| kept.track == *track);
            of_track.any(|kept| kept.by.iter().any(|(id, _)| id == vehicle))
        };
        self.since.retain(|key, _| is_there(key));
        self.told.retain(|key, _| is_there(key));
        if kept != *observations.as_ref() {
            shared.observed.set_observations(kept);
        }
    }

    /// One observation as it goes on; nothing once its track has ended, or nobody looks any more.
    fn keep(
        &mut self,
        shared: &Arc<SharedState>,
        ask: &AskVehicle,
        snapshot: &FleetSnapshot,
        observation: &TrackObservation,
        now: NodeTime,
    ) -> Option<TrackObservation> {
        let tracks = shared.observed.tracks();
        let target = tracks.iter().find(|track| track.track == observation.track)?.position;
        let states = self.states(snapshot, observation, now);
        let refused: Vec<VehicleId> = self.refused.lock().keys().copied().collect();
        let proposals = ranked(&target, &candidates(snapshot));
        let mut kept = observation.clone();
        for change in changes(observation, &states, &proposals, &refused) {
            match change {
                Change::Left(vehicle) => kept.by.retain(|(id, _)| *id != vehicle),
                Change::HandOver {
                    from,
                    why,
                    to,
                    bearing_rad,
                } => {
                    self.tell(shared, observation.track, from, why, to, now);
                    if let Some(to) = to {
                        kept.by.retain(|(id, _)| *id != from);
                        kept.by.push((to, bearing_rad));
                        self.ask(shared, ask, observation, to, bearing_rad);
                    }
                }
            }
        }
        (!kept.by.is_empty()).then_some(kept)
    }

    fn states(
        &mut self,
        snapshot: &FleetSnapshot,
        observation: &TrackObservation,
        now: NodeTime,
    ) -> BTreeMap<VehicleId, ObserverState> {
        let refused = self.refused.lock();
        let by = observation.by.iter().map(|(id, _)| *id);
        by.filter_map(|id| {
            let vehicle = snapshot.vehicles.iter().find(|vehicle| vehicle.id == id)?;
            let since = *self.since.entry((observation.track, id)).or_insert(now);
            let begun = now.seconds_since(since) >= BEGUN_WITHIN_S;
            let looks = activity(vehicle).is_some() && looks_at(vehicle, observation.track);
            let state = ObserverState {
                heard: vehicle.link.connected,
                energy: vehicle.energy.map(|energy| energy.level),
                refused: refused.contains_key(&id),
                left: begun && !looks,
            };
            Some((id, state))
        })
        .collect()
    }

    fn tell(
        &mut self,
        shared: &SharedState,
        track: u64,
        from: VehicleId,
        why: Unable,
        to: Option<VehicleId>,
        now: NodeTime,
    ) {
        if to.is_none() && self.told.insert((track, from), why) == Some(why) {
            return;
        }
        let why = match why {
            Unable::LowCharge => "must return soon",
            Unable::Lost => "is not heard any more",
            Unable::Refused => "has refused to take over",
        };
        let (severity, then) = match to {
            Some(to) => (Severity::Advisory, format!("vehicle {to} takes over")),
            None => (Severity::Warning, "nobody can take over".to_owned()),
        };
        let text = format!("vehicle {from}, which is to keep track {track} in view, {why}: {then}");
        let kind = EventKind::Track { track };
        shared.events.record(now, Some(from), severity, kind, text);
    }

    fn ask(
        &self,
        shared: &Arc<SharedState>,
        ask: &AskVehicle,
        observation: &TrackObservation,
        to: VehicleId,
        bearing_rad: f64,
    ) {
        let command = VehicleCommand::Observe {
            target: Target::Track {
                track: observation.track,
            },
            stand_off_m: observation.stand_off_m,
            height_m: None,
            bearing_rad: Some(bearing_rad),
        };
        let (shared, refused, answer) = (shared.clone(), self.refused.clone(), ask(to, command));
        tokio::spawn(async move {
            if answer.await {
                refused.lock().insert(to, shared.now());
            }
        });
    }
}
