//! What sensors saw and what was made of it, told and heard: a node that does not coordinate tells what was seen, the one that does tells its tracks.
//!
//! Must never do: take more of the line than a share of it, or make a track.

use super::SwarmState;
use crate::parts::{pack, unpack};
use crate::tracks::{SightingsTold, TracksTold};
use skein_domain::payload::TrackEstimate;
use skein_domain::{NodeId, NodeTime, SwarmFrame};
use skein_state::cluster::report::{Kind, key};
use std::sync::Arc;

/// Time between two tellings, in seconds.
const TOLD_EVERY_S: f64 = 0.1;
/// The share of what the node may send that goes into it at most.
const SHARE: f64 = 0.25;
/// Something told later than this after it was true, or before, was told by a clock that is wrong, in seconds.
const LATEST_S: f64 = 5.0;
const SOONEST_S: f64 = 0.25;

/// What was told.
#[derive(Debug, Default)]
pub(super) struct TrackingTold {
    next: NodeTime,
    tracks: Option<Arc<Vec<TrackEstimate>>>,
}

impl SwarmState {
    /// Tells what is due.
    pub(super) fn tell_tracking(&mut self, now: NodeTime) {
        if now < self.tracking.next {
            return;
        }
        let bytes = if self.leadership.acting().is_some() {
            self.tell_no_more(Kind::Sightings);
            self.tell_tracks(now)
        } else {
            self.tracking.tracks = None;
            self.tell_no_more(Kind::Tracks);
            self.tell_sightings(now)
        };
        let most_bytes_per_s = SHARE * self.shared.config.swarm.max_bytes_per_s;
        self.tracking.next = now.plus_seconds(TOLD_EVERY_S.max(bytes as f64 / most_bytes_per_s));
    }

    /// What its sensors saw since the last time. Gives how many bytes that are.
    fn tell_sightings(&mut self, now: NodeTime) -> usize {
        let sightings = self.shared.observed.seen.take_for_others();
        if sightings.is_empty() {
            // What was seen before is no news to who comes later.
            self.tell_no_more(Kind::Sightings);
            return 0;
        }
        let Ok(packed) = pack(&SightingsTold::of(&sightings, now)) else {
            return 0;
        };
        self.tell_parts(now, Kind::Sightings, 0, &packed);
        packed.len()
    }

    /// The tracks that this node has made, if they are others than those told last. Gives how many bytes that are.
    fn tell_tracks(&mut self, now: NodeTime) -> usize {
        let observed = &self.shared.observed;
        let Some(tracks) = observed.fused_here() else { return 0 };
        let before = self.tracking.tracks.replace(tracks.clone());
        if before.is_some_and(|before| Arc::ptr_eq(&before, &tracks)) {
            return 0;
        }
        let told = TracksTold {
            tracks: tracks.as_ref().clone(),
            observations: observed.observations().as_ref().clone(),
        };
        let Ok(packed) = pack(&told) else { return 0 };
        self.tell_parts(now, Kind::Tracks, 0, &packed);
        packed.len()
    }

    /// Another node tells what its sensors saw: for the tracks that this node makes, if it coordinates.
    pub(super) fn hear_sightings(&mut self, from: NodeId, bytes: &[u8], now: NodeTime) {
        let (Some(ahead_us), true) = (self.ahead_us(from), self.leadership.acting().is_some()) else {
            return;
        };
        let Ok(told) = unpack::<SightingsTold>(bytes) else {
            return;
        };
        let at = told.told.on_clock_ahead_by(ahead_us);
        if (-SOONEST_S..=LATEST_S).contains(&now.seconds_since(at)) {
            let sightings = told.sightings(at.min(now), self.other_frames(from));
            self.shared.observed.seen.hear(sightings);
        }
    }

    /// The node that coordinates tells its tracks.
    pub(super) fn hear_fused(&mut self, from: NodeId, bytes: &[u8], now: NodeTime) {
        let obeyed = self.leadership.obeyed().map(|term| term.holder.node);
        let (Some(ahead_us), true) = (self.ahead_us(from), obeyed == Some(from)) else {
            return;
        };
        if let Ok(told) = unpack::<TracksTold>(bytes) {
            let heard = told.heard(ahead_us, now, self.other_frames(from));
            self.shared.observed.hear_fused(heard.tracks);
            self.shared.observed.set_observations(heard.observations);
        }
    }

    /// A node's frame and this node's, if they differ.
    fn other_frames(&self, from: NodeId) -> Option<(SwarmFrame, SwarmFrame)> {
        let theirs = self.nodes.get(&from)?.frame()?;
        Some((theirs, self.shared.frame()?)).filter(|(theirs, ours)| theirs != ours)
    }

    fn tell_no_more(&mut self, kind: Kind) {
        for index in 0..self.told.forget_parts(kind) {
            self.bus.tell_no_more(key(kind, 0, index));
        }
    }
}
