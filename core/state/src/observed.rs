//! What is known of others than the swarm's vehicles: aircraft and movers that were sighted, references, tracks and whose they are.
//!
//! Must never do: judge whom to keep away from; that is the separation filter's.

mod seen;

pub use seen::{MOST_FOR_OTHERS, Seen, SeenCounts};

use arc_swap::ArcSwap;
use parking_lot::Mutex;
use skein_coordination::{OwnTracks, References, TrackObservation, neighbours};
use skein_domain::payload::{Track, TrackEstimate};
use skein_domain::{NodeTime, Refusal, VehicleId};
use skein_link_mavlink::Sightings;
use skein_view::PeerEntry;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is observed around the swarm.
pub struct Observed {
    /// Aircraft and movers that were sighted over MAVLink.
    pub sightings: Sightings,
    /// Things that formations may be anchored to.
    pub references: References,
    /// What cameras and other sensors saw, on its way to the tracks.
    pub seen: Seen,
    /// What was told, and what was made of what sensors saw; each is replaced as a whole.
    told: ArcSwap<Vec<Track>>,
    fused: ArcSwap<Vec<TrackEstimate>>,
    /// What steers vehicles: what was told, and of what was made here what may.
    all: ArcSwap<Vec<Track>>,
    /// Whether anything that was made may.
    steer_by_fused: bool,
    joining: Mutex<()>,
    /// They were told, or made, at this node last.
    told_here: AtomicBool,
    fused_here: AtomicBool,
    /// Which of them are of our own vehicles.
    own_tracks: Mutex<OwnTracks>,
    /// Which tracks vehicles are to keep in view.
    observations: ArcSwap<Vec<TrackObservation>>,
}

impl Observed {
    /// Nothing yet. References move no faster than that.
    pub(crate) fn new(max_speed_m_s: f64, steer_by_fused: bool) -> Self {
        Self {
            sightings: Sightings::new(),
            references: References::new(max_speed_m_s),
            seen: Seen::default(),
            told: ArcSwap::default(),
            fused: ArcSwap::default(),
            all: ArcSwap::default(),
            steer_by_fused,
            joining: Mutex::default(),
            told_here: AtomicBool::new(false),
            fused_here: AtomicBool::new(false),
            own_tracks: Mutex::default(),
            observations: ArcSwap::default(),
        }
    }

    /// What is tracked and steers vehicles, for plugins and the separation filter: what was told, and, if the node is set so, what was made of what
    /// sensors saw and is known well enough. The same value until something changes.
    pub fn tracks(&self) -> Arc<Vec<Track>> {
        self.all.load_full()
    }

    /// What is tracked, with all that is known of it.
    pub fn estimates(&self) -> Vec<TrackEstimate> {
        let told = self.told.load();
        let told = told.iter().copied().map(TrackEstimate::told);
        told.chain(self.fused.load().iter().cloned()).collect()
    }

    /// What the swarm has made of what its sensors saw.
    pub fn fused(&self) -> Arc<Vec<TrackEstimate>> {
        self.fused.load_full()
    }

    /// Whether such a track can steer a vehicle, or why not.
    ///
    /// # Errors
    /// There is no such track, none of those may, or its place is not known well enough.
    pub fn steering_track(&self, track: u64) -> Result<Track, Refusal> {
        if let Some(known) = self.tracks().iter().find(|known| known.track == track) {
            return Ok(*known);
        }
        if !self.fused.load().iter().any(|known| known.track.track == track) {
            return Err(Refusal::UnknownTrack { track });
        }
        if !self.steer_by_fused {
            let why = "tracks that this swarm makes are only shown here: tracking.steer_by_fused is off";
            return Err(Refusal::not_permitted(why));
        }
        let why = format!("the place of track {track} is not known well enough yet");
        Err(Refusal::invalid(why))
    }

    /// The same, if it was made here last.
    pub fn fused_here(&self) -> Option<Arc<Vec<TrackEstimate>>> {
        self.fused_here.load(Ordering::Acquire).then(|| self.fused())
    }

    /// What is tracked, as it was told here.
    pub fn tell_tracks(&self, tracks: Vec<Track>) {
        self.told_here.store(true, Ordering::Release);
        self.told.store(Arc::new(tracks));
        self.join();
    }

    /// What is tracked, as it was told at another node.
    pub fn hear_tracks(&self, tracks: Vec<Track>) {
        self.told_here.store(false, Ordering::Release);
        self.told.store(Arc::new(tracks));
        self.join();
    }

    /// What is tracked, if it was told here last.
    pub fn tracks_here(&self) -> Option<Vec<Track>> {
        let ours = self.told_here.load(Ordering::Acquire);
        ours.then(|| self.told.load().as_ref().clone())
    }

    /// What this node has made of what sensors saw.
    pub fn publish_fused(&self, tracks: Vec<TrackEstimate>) {
        self.fused_here.store(true, Ordering::Release);
        self.replace_fused(tracks);
    }

    /// What the node that coordinates has made of it.
    pub fn hear_fused(&self, tracks: Vec<TrackEstimate>) {
        self.fused_here.store(false, Ordering::Release);
        self.replace_fused(tracks);
    }

    /// Keeps of what another node made only what `keep` says: nobody tells of it any more.
    pub fn retain_fused(&self, keep: impl Fn(&TrackEstimate) -> bool) {
        let before = self.fused.load();
        if before.iter().any(|track| !keep(track)) {
            let kept = before.iter().filter(|track| keep(track)).cloned().collect();
            self.hear_fused(kept);
        }
    }

    fn replace_fused(&self, tracks: Vec<TrackEstimate>) {
        // Whoever reads nothing again and again is told of no change.
        if tracks.is_empty() && self.fused.load().is_empty() {
            return;
        }
        self.fused.store(Arc::new(tracks));
        self.join();
    }

    fn join(&self) {
        let _alone = self.joining.lock();
        let fused = self.fused.load();
        let may_steer = |estimate: &&TrackEstimate| self.steer_by_fused && neighbours::is_known(estimate);
        let fused = fused.iter().filter(may_steer).map(|estimate| estimate.track);
        let all = self.told.load().iter().copied().chain(fused).collect();
        self.all.store(Arc::new(all));
    }

    /// What is tracked and is no vehicle of ours. The control loop asks every period: it is remembered where each was first seen.
    pub fn strange_tracks(&self, entries: &[PeerEntry], now: NodeTime) -> Vec<TrackEstimate> {
        let (all, fused) = (self.all.load(), self.fused.load());
        let mut own = self.own_tracks.lock();
        let strangers = own.strangers(&all, entries, now).into_iter();
        let estimate = |track: &Track| {
            let made = fused.iter().find(|made| made.track.track == track.track);
            made.map_or_else(|| TrackEstimate::told(*track), Clone::clone)
        };
        strangers.map(estimate).collect()
    }

    /// Tracks that are taken for a vehicle of ours, and for which.
    pub fn tracks_of_ours(&self) -> Vec<(u64, VehicleId)> {
        self.own_tracks.lock().ours().collect()
    }

    /// Which tracks vehicles are to keep in view.
    pub fn observations(&self) -> Arc<Vec<TrackObservation>> {
        self.observations.load_full()
    }

    /// They are to keep these in view from now on.
    pub fn set_observations(&self, observations: Vec<TrackObservation>) {
        self.observations.store(Arc::new(observations));
    }
}

#[cfg(test)]
mod tests;
