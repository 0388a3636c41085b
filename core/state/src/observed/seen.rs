//! What cameras and other sensors saw, between who hears of it and who makes tracks of it: three queues with a bound each, and counts.
//!
//! Must never do: grow beyond the bounds, or lose anything without counting it.

use parking_lot::Mutex;
use skein_vision::Sighting;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};

/// Sightings that wait after they were told over the API, at most: what more comes is refused.
const MOST_TOLD: usize = 4_096;
/// Sightings that wait after other nodes told of them, at most: the oldest go.
const MOST_HEARD: usize = 4_096;
/// Sightings that wait to be told to the node that coordinates, at most: the oldest go. No message has more.
pub const MOST_FOR_OTHERS: usize = 128;

/// Of so many pictures it is remembered how long it took until the tracks knew of them.
const MOST_PICTURES: usize = 512;

/// How much was seen since the node started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SeenCounts {
    /// By cameras of this node's vehicles.
    pub by_cameras: u64,
    /// By other sensors, as told over the API of this node.
    pub told: u64,
    /// As heard of other nodes.
    pub heard: u64,
    /// Left out, because more came than is worked on.
    pub dropped: u64,
    /// Time from the taking of a picture until the tracks knew what is in it, of the last pictures of this node's cameras, in microseconds: the median and the
    /// 95th percentile.
    pub camera_to_track_us: Option<(u64, u64)>,
}

/// What was seen.
#[derive(Debug, Default)]
pub struct Seen {
    told: Mutex<VecDeque<Sighting>>,
    heard: Mutex<VecDeque<Sighting>>,
    for_others: Mutex<VecDeque<Sighting>>,
    by_cameras: AtomicU64,
    by_told: AtomicU64,
    by_heard: AtomicU64,
    dropped: AtomicU64,
    /// Of the last pictures, in microseconds.
    camera_to_track_us: Mutex<VecDeque<u64>>,
}

impl Seen {
    /// Over the API somebody tells of what another sensor saw: as much of it as there is room for is taken, from the front. Gives how much.
    pub fn tell(&self, sightings: impl IntoIterator<Item = Sighting>) -> usize {
        let mut told = self.told.lock();
        let room = MOST_TOLD.saturating_sub(told.len());
        let before = told.len();
        told.extend(sightings.into_iter().take(room));
        let taken = told.len() - before;
        self.by_told.fetch_add(taken as u64, Ordering::Relaxed);
        taken
    }

    /// Some that were refused, because too much waited.
    pub fn count_refused(&self, count: usize) {
        self.drop_some(count);
    }

    /// Cameras of this node's vehicles saw so many things.
    pub fn count_by_cameras(&self, count: usize) {
        self.by_cameras.fetch_add(count as u64, Ordering::Relaxed);
    }

    /// What was in a picture that was taken so long ago is in the tracks now, in seconds.
    pub fn count_in_tracks(&self, after_s: f64) {
        let mut all = self.camera_to_track_us.lock();
        if all.len() == MOST_PICTURES {
            all.pop_front();
        }
        all.push_back((after_s.max(0.0) * 1e6) as u64);
    }

    fn camera_to_track_us(&self) -> Option<(u64, u64)> {
        let mut all: Vec<u64> = self.camera_to_track_us.lock().iter().copied().collect();
        all.sort_unstable();
        let at = |percent: usize| all.get(all.len().saturating_sub(1) * percent / 100).copied();
        at(50).zip(at(95))
    }

    /// Another node tells of what its sensors saw.
    pub fn hear(&self, sightings: Vec<Sighting>) {
        self.by_heard.fetch_add(sightings.len() as u64, Ordering::Relaxed);
        self.push(&self.heard, sightings, MOST_HEARD);
    }

    /// The node that coordinates is to be told of these.
    pub fn tell_others(&self, sightings: Vec<Sighting>) {
        self.push(&self.for_others, sightings, MOST_FOR_OTHERS);
    }

    /// What the node that coordinates is to be told of, oldest first.
    pub fn take_for_others(&self) -> Vec<Sighting> {
        std::mem::take(&mut *self.for_others.lock()).into()
    }

    /// What was told over the API: the newest `most`, oldest first. The rest is dropped.
    pub fn take_told(&self, most: usize) -> Vec<Sighting> {
        self.take(&self.told, most)
    }

    /// What other nodes told of: the newest `most`, oldest first. The rest is dropped.
    pub fn take_heard(&self, most: usize) -> Vec<Sighting> {
        self.take(&self.heard, most)
    }

    /// How much was seen since the node started.
    #[must_use]
    pub fn counts(&self) -> SeenCounts {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        SeenCounts {
            by_cameras: of(&self.by_cameras),
            told: of(&self.by_told),
            heard: of(&self.by_heard),
            dropped: of(&self.dropped),
            camera_to_track_us: self.camera_to_track_us(),
        }
    }

    fn push(&self, queue: &Mutex<VecDeque<Sighting>>, sightings: Vec<Sighting>, most: usize) {
        let mut queue = queue.lock();
        queue.extend(sightings);
        let over = queue.len().saturating_sub(most);
        queue.drain(..over);
        self.drop_some(over);
    }

    fn take(&self, queue: &Mutex<VecDeque<Sighting>>, most: usize) -> Vec<Sighting> {
        let mut taken = std::mem::take(&mut *queue.lock());
        let over = taken.len().saturating_sub(most);
        taken.drain(..over);
        self.drop_some(over);
        taken.into()
    }

    fn drop_some(&self, count: usize) {
        self.dropped.fetch_add(count as u64, Ordering::Relaxed);
    }
}
