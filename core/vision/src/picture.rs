//! Tracks in the picture of one camera: boxes of a detector become things with a name, a class and a velocity, through gaps.
//!
//! In the manner of ByteTrack (Zhang et al., 2022): what is found with certainty is assigned first, what is found with doubt only to tracks
//! that exist. Bound: [`PictureSettings::most_tracks`] tracks; of more boxes than [`PictureSettings::most_found`] the best are looked at.

mod filter;
mod stillness;

use crate::assignment::assign;
use crate::{Bounds, ClassScores, Turn};
use filter::{BoxFilter, Noise};
use skein_domain::NodeTime;
use stillness::Stillness;

/// One box of a detector.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Where.
    pub bounds: Bounds,
    /// What it is taken for.
    pub scores: ClassScores,
}

impl Found {
    fn score(&self) -> f64 {
        self.scores.best().map_or(0.0, |(_, score)| score)
    }
}

/// When a track begins and ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureSettings {
    /// A box with this score may begin a track.
    pub certain_score: f64,
    /// A box with this score may go on with one.
    pub doubtful_score: f64,
    /// Boxes that a track needs before it is told of.
    pub confirm_after: u32,
    /// A track without a box ends after this, in seconds.
    pub coast_s: f64,
    /// A track that was not told of yet ends after this without a box, in seconds.
    pub tentative_coast_s: f64,
    /// How quickly the class follows the boxes: the time in which old ones count half, in seconds.
    pub class_half_life_s: f64,
    /// Acceleration that things have in the picture, in their own sizes per second squared.
    pub acceleration_sizes_s2: f64,
    /// Error of the middle of a box, in its own sizes.
    pub center_error_sizes: f64,
    /// Most tracks at a time.
    pub most_tracks: usize,
    /// Most boxes of one picture.
    pub most_found: usize,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            certain_score: 0.4,
            doubtful_score: 0.1,
            confirm_after: 3,
            coast_s: 1.0,
            tentative_coast_s: 0.2,
            class_half_life_s: 1.0,
            acceleration_sizes_s2: 20.0,
            center_error_sizes: 0.15,
            most_tracks: 64,
            most_found: 256,
        }
    }
}

/// Two tracks whose boxes share so much of their area are of one thing.
const SAME_OVERLAP: f64 = 0.7;
/// If they do so in as many pictures, one after the other.
const SAME_FOR: u32 = 8;

/// Something that is followed in the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureTrack {
    /// Names it for as long as it is followed, from 1.
    pub id: u64,
    /// Where it is, or is thought to be.
    pub bounds: Bounds,
    /// Velocity of its middle, in pixels per second to the right and down.
    pub velocity_px_s: (f64, f64),
    /// Standard deviation of its middle in pixels.
    pub error_px: f64,
    /// What it is taken for, from all its boxes.
    pub scores: ClassScores,
    /// Since its first box, in seconds.
    pub age_s: f64,
    /// Since its last box, in seconds; 0 if it was found in this picture.
    pub coasted_s: f64,
    /// The box of this picture that it was given, as it was found.
    pub found: Option<Bounds>,
    /// Whether it has ever moved relative to the scene: by a fifth of its longer side, or 8 pixels if that is less, within 2 s.
    pub moved: bool,
}

#[derive(Debug, Clone)]
struct Track {
    id: u64,
    filter: BoxFilter,
    scores: ClassScores,
    began: NodeTime,
    found: NodeTime,
    /// Its last box.
    last: Bounds,
    boxes: u32,
    stillness: Stillness,
    /// Pictures, one after the other, in which its box was nearly that of an older track.
    doubled: u32,
}

/// Follows what a detector finds in the pictures of one camera.
#[derive(Debug, Clone)]
pub struct PictureTracker {
    settings: PictureSettings,
    tracks: Vec<Track>,
    last_id: u64,
    time: Option<NodeTime>,
}

impl PictureTracker {
    /// One that follows nothing yet.
    #[must_use]
    pub fn new(settings: PictureSettings) -> Self {
        Self::after(settings, 0)
    }

    /// One that numbers its tracks from behind `last_id`, as if it had followed those before.
    #[must_use]
    pub fn after(settings: PictureSettings, last_id: u64) -> Self {
        Self {
            settings,
            tracks: Vec::new(),
            last_id,
            time: None,
        }
    }

    /// The number of the newest track.
    #[must_use]
    pub fn last_id(&self) -> u64 {
        self.last_id
    }

    /// Takes what was found in the next picture, and how the camera has turned since the last one. A picture that is not newer than the last one is left out.
    pub fn take(&mut self, time: NodeTime, turn: &Turn, mut found: Vec<Found>) {
        if self.time.is_some_and(|last| time <= last) {
            return;
        }
        let since_s = self.time.replace(time).map_or(0.0, |last| time.seconds_since(last));
        let noise = self.noise();
        for track in &mut self.tracks {
            track.filter.advance(since_s, turn, &noise);
            track.stillness.advance(turn);
        }
        found.retain(|one| one.bounds.is_sound() && one.score() >= self.settings.doubtful_score);
        found.sort_by(|a, b| b.score().total_cmp(&a.score()));
        found.truncate(self.settings.most_found);
        let certain = found
            .iter()
            .take_while(|one| one.score() >= self.settings.certain_score)
            .count();
        let doubtful = found.split_off(certain);
        let left = self.go_on(time, found, |_| true);
        self.go_on(time, doubtful, |track| track.found < time);
        for one in left {
            self.begin(time, one);
        }
        self.end(time);
    }

    /// What is followed and was seen often enough to be believed.
    pub fn tracks(&self) -> impl Iterator<Item = PictureTrack> {
        let now = self.time.unwrap_or_default();
        let told = self
            .tracks
            .iter()
            .filter(|track| track.boxes >= self.settings.confirm_after);
        told.map(move |track| PictureTrack {
            id: track.id,
            bounds: track.filter.bounds(),
            velocity_px_s: track.filter.velocity_px_s(),
            error_px: track.filter.error_px(),
            scores: track.scores.clone(),
            age_s: now.seconds_since(track.began),
            coasted_s: now.seconds_since(track.found),
            found: (track.found == now).then_some(track.last),
            moved: track.stillness.moved(),
        })
    }

    fn noise(&self) -> Noise {
        Noise {
            acceleration_sizes_s2: self.settings.acceleration_sizes_s2,
            center_error_sizes: self.settings.center_error_sizes,
        }
    }

    /// Gives boxes to tracks; returns those that no track takes.
    fn go_on(&mut self, time: NodeTime, found: Vec<Found>, may: impl Fn(&Track) -> bool) -> Vec<Found> {
        let noise = self.noise();
        let free: Vec<usize> = (0..self.tracks.len())
            .filter(|index| may(&self.tracks[*index]))
            .collect();
        let pairs = assign(free.len(), found.len(), filter::FARTHEST, |row, column| {
            self.tracks[free[row]].filter.distance(&found[column].bounds, &noise)
        });
        let mut taken = vec![false; found.len()];
        for (row, column) in pairs {
            let (track, one) = (&mut self.tracks[free[row]], &found[column]);
            track.filter.correct(&one.bounds, &noise);
            let since_s = time.seconds_since(track.found);
            let keeps = 0.5_f64.powf(since_s / self.settings.class_half_life_s);
            // The mean of the first boxes, and the newer ones after that.
            let share = (1.0 - keeps).max(1.0 / f64::from(track.boxes + 1)).min(1.0);
            track.scores.blend(&one.scores, share);
            track.boxes = track.boxes.saturating_add(1);
            track.found = time;
            track.last = one.bounds;
            track.stillness.take(time, &track.filter.bounds());
            taken[column] = true;
        }
        let left = found.into_iter().zip(taken).filter(|(_, taken)| !taken);
        left.map(|(one, _)| one).collect()
    }

    fn begin(&mut self, time: NodeTime, one: Found) {
        if self.tracks.len() >= self.settings.most_tracks {
            return;
        }
        self.last_id += 1;
        self.tracks.push(Track {
            id: self.last_id,
            filter: BoxFilter::new(one.bounds, &self.noise()),
            scores: one.scores,
            began: time,
            found: time,
            last: one.bounds,
            boxes: 1,
            stillness: Stillness::default(),
            doubled: 0,
        });
    }

    /// Of two tracks of one thing the older stays. Two things that cross are one for a moment only.
    fn end_doubles(&mut self) {
        let boxes: Vec<Bounds> = self.tracks.iter().map(|track| track.filter.bounds()).collect();
        // They are in the order in which they began.
        for (index, track) in self.tracks.iter_mut().enumerate() {
            let double = boxes[..index]
                .iter()
                .any(|older| older.overlap(&boxes[index]) > SAME_OVERLAP);
            track.doubled = if double { track.doubled + 1 } else { 0 };
        }
        self.tracks.retain(|track| track.doubled < SAME_FOR);
    }

    fn end(&mut self, now: NodeTime) {
        self.end_doubles();
        let settings = self.settings;
        self.tracks.retain(|track| {
            let told = track.boxes >= settings.confirm_after;
            let most_s = if told {
                settings.coast_s
            } else {
                settings.tentative_coast_s
            };
            now.seconds_since(track.found) <= most_s
        });
    }
}

#[cfg(test)]
mod tests;
