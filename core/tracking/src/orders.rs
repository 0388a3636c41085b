//! What operators want of tracks that the swarm makes: another name, to be kept, an end, to be kept in view.
//!
//! Must never do: change what was told as it is; who told it tells it anew.

use crate::{TrackingState, shown};
use skein_coordination::TrackObservation;
use skein_domain::Refusal;
use skein_domain::exchange::Severity;
use skein_state::SharedState;
use skein_state::asks::TrackOrder;
use skein_view::EventKind;

/// Observations at once.
const MOST_OBSERVATIONS: usize = 16;

impl TrackingState {
    /// Does it, or says why not.
    pub(crate) fn order(&mut self, order: TrackOrder) -> Result<(), Refusal> {
        match order {
            TrackOrder::Change { track, name, pinned } => self.change(track, name.as_deref(), pinned),
            TrackOrder::Drop { track } => self.drop_track(track),
            TrackOrder::Observe(observation) => observe(&self.shared, observation),
        }
    }

    fn change(&mut self, track: u64, name: Option<&str>, pinned: Option<bool>) -> Result<(), Refusal> {
        let id = known(&self.shared, track)?;
        let unknown = || Refusal::UnknownTrack { track };
        let mut tracker = self.take_tracker();
        let named = name.is_none_or(|name| tracker.rename(id, name));
        let done = named && pinned.is_none_or(|pinned| tracker.pin(id, pinned));
        self.tracker = Some(tracker);
        if !done {
            return Err(unknown());
        }
        if let Some(name) = name {
            let text = if name.is_empty() {
                format!("track {track} has no name any more")
            } else {
                format!("track {track} is called \"{name}\"")
            };
            self.record(track, text);
        }
        if let Some(pinned) = pinned {
            let is = if pinned {
                "is pinned: it is kept longer"
            } else {
                "is not pinned any more"
            };
            self.record(track, format!("track {track} {is}"));
        }
        self.show(self.shared.now());
        Ok(())
    }

    fn drop_track(&mut self, track: u64) -> Result<(), Refusal> {
        let id = known(&self.shared, track)?;
        let mut tracker = self.take_tracker();
        let done = tracker.drop_track(id);
        self.tracker = Some(tracker);
        if !done {
            return Err(Refusal::UnknownTrack { track });
        }
        self.telling.forget(track);
        self.record(track, format!("track {track} was dropped"));
        self.show(self.shared.now());
        Ok(())
    }

    fn record(&self, track: u64, text: String) {
        let kind = EventKind::Track { track };
        let now = self.shared.now();
        self.shared.events.record(now, None, Severity::Info, kind, text);
    }
}

/// Its number in the tracker.
fn known(shared: &SharedState, track: u64) -> Result<u64, Refusal> {
    if let Some(id) = shown::id(track) {
        return Ok(id);
    }
    if shared.observed.tracks().iter().any(|known| known.track == track) {
        return Err(Refusal::not_supported(format!(
            "track {track} was told as it is: tell the tracks anew to change it"
        )));
    }
    Err(Refusal::UnknownTrack { track })
}

/// Keeps a track in view from now on, in place of what was asked of the same track or the same vehicles before.
fn observe(shared: &SharedState, asked: TrackObservation) -> Result<(), Refusal> {
    let taken = |observation: &TrackObservation| {
        let by = observation
            .by
            .iter()
            .filter(|(id, _)| !asked.by.iter().any(|(other, _)| other == id));
        TrackObservation {
            by: by.copied().collect(),
            ..observation.clone()
        }
    };
    let before = shared.observed.observations();
    let others = before
        .iter()
        .filter(|observation| observation.track != asked.track)
        .map(taken);
    let mut all: Vec<TrackObservation> = others.filter(|observation| !observation.by.is_empty()).collect();
    if all.len() >= MOST_OBSERVATIONS {
        return Err(Refusal::not_permitted(format!(
            "{MOST_OBSERVATIONS} tracks are kept in view already"
        )));
    }
    all.push(asked);
    shared.observed.set_observations(all);
    Ok(())
}
