//! What is known of others than the swarm's vehicles: aircraft and movers that were sighted, references, tracks and whose they are.
//!
//! Must never do: judge whom to keep away from; that is the separation filter's.

use arc_swap::ArcSwap;
use parking_lot::Mutex;
use skein_coordination::{OwnTracks, References};
use skein_domain::NodeTime;
use skein_domain::payload::Track;
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
    /// Replaced as a whole.
    tracks: ArcSwap<Vec<Track>>,
    /// They were told at this node last.
    tracks_are_ours: AtomicBool,
    /// Which of them are of our own vehicles.
    own_tracks: Mutex<OwnTracks>,
}

impl Observed {
    /// Nothing yet. References move no faster than that.
    pub(crate) fn new(max_speed_m_s: f64) -> Self {
        Self {
            sightings: Sightings::new(),
            references: References::new(max_speed_m_s),
            tracks: ArcSwap::default(),
            tracks_are_ours: AtomicBool::new(false),
            own_tracks: Mutex::default(),
        }
    }

    /// What is tracked.
    pub fn tracks(&self) -> Arc<Vec<Track>> {
        self.tracks.load_full()
    }

    /// What is tracked, as it was told here.
    pub fn tell_tracks(&self, tracks: Vec<Track>) {
        self.tracks_are_ours.store(true, Ordering::Release);
        self.tracks.store(Arc::new(tracks));
    }

    /// What is tracked, as it was told at another node.
    pub fn hear_tracks(&self, tracks: Vec<Track>) {
        self.tracks_are_ours.store(false, Ordering::Release);
        self.tracks.store(Arc::new(tracks));
    }

    /// What is tracked, if it was told here last.
    pub fn tracks_here(&self) -> Option<Vec<Track>> {
        let ours = self.tracks_are_ours.load(Ordering::Acquire);
        ours.then(|| self.tracks.load().as_ref().clone())
    }

    /// What is tracked and is no vehicle of ours. The control loop asks every period: it is remembered where each was first seen.
    pub fn strange_tracks(&self, entries: &[PeerEntry], now: NodeTime) -> Vec<Track> {
        let tracks = self.tracks.load();
        let mut own = self.own_tracks.lock();
        own.strangers(&tracks, entries, now).into_iter().copied().collect()
    }
}
