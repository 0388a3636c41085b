//! One picture of what all sensors see: bearings of cameras, and bearings and positions of others, become tracks of the swarm, whose names last
//! when one camera loses sight and another takes over.
//!
//! 1. What one sensor follows under one name is a [tracklet](tracklet). It belongs to nothing at first.
//! 2. Two cameras' tracklets that one place and velocity explain, and no other pair explains nearly as well, begin a track.
//! 3. Further tracklets go to the track that predicts what they saw, if no other track does nearly as well.
//! 4. A tracklet alone begins a track with a guessed range, if its sensor gives a guess; it becomes a better one when a second camera comes.
//! 5. What is explained by a vehicle of the swarm is no track.
//!
//! Bounds: [`SwarmSettings::most_tracks`] tracks, [`SwarmSettings::most_tracklets`] tracklets, a dozen sightings of each.

mod birth;
mod estimate;
mod evidence;
mod guessing;
mod joining;
mod observation;
mod own;
mod tracklet;

pub use observation::{Observation, OwnVehicle, RangeGuess, Sensor, Sighting, Unsound};

use crate::ClassScores;
use estimate::Estimate;
use evidence::Evidence;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use skein_domain::NodeTime;
use tracklet::{Belongs, Tracklet};

/// What is expected of what is looked for, and how long it is remembered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwarmSettings {
    /// How quickly velocities wander: the density of an unknown acceleration in m²/s³.
    pub acceleration_m2_s3: f64,
    /// A track of which nothing is seen ends after this, in seconds.
    pub keep_s: f64,
    /// A pinned one after this.
    pub keep_pinned_s: f64,
    /// What a sensor names counts as out of its sight after this, in seconds.
    pub sight_lost_s: f64,
    /// Most tracks.
    pub most_tracks: usize,
    /// Most things that sensors name.
    pub most_tracklets: usize,
}

impl Default for SwarmSettings {
    fn default() -> Self {
        Self {
            acceleration_m2_s3: 2.0,
            keep_s: 5.0,
            keep_pinned_s: 30.0,
            sight_lost_s: 0.4,
            most_tracks: 64,
            most_tracklets: 512,
        }
    }
}

/// Something that the swarm follows.
#[derive(Debug, Clone, PartialEq)]
pub struct SwarmTrack {
    /// Its number, from 1.
    pub id: u64,
    /// What an operator calls it; empty if nobody named it.
    pub name: String,
    /// An operator wants it kept.
    pub pinned: bool,
    /// Of the numbers that follow.
    pub time: NodeTime,
    /// In the swarm frame, in metres.
    pub position: Vector3<f64>,
    /// In metres per second.
    pub velocity: Vector3<f64>,
    /// Of position and velocity together, in that order.
    pub covariance: Matrix6<f64>,
    /// Its range is guessed from its size: one camera alone has seen it so far.
    pub guessed_range: bool,
    /// What it is taken for.
    pub scores: ClassScores,
    /// Since it began, in seconds.
    pub age_s: f64,
    /// How sure it is that something is there, 0..=1.
    pub confidence: f64,
    /// When it was last seen.
    pub seen: NodeTime,
    /// The sensors that see it now.
    pub sensors: Vec<Sensor>,
}

impl SwarmTrack {
    /// Covariance of its position in square metres.
    #[must_use]
    pub fn position_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into()
    }
}

#[derive(Debug)]
struct Track {
    id: u64,
    name: String,
    pinned: bool,
    estimate: Estimate,
    guessed_range: bool,
    scores: ClassScores,
    began: NodeTime,
    seen: NodeTime,
    /// Who saw it when another tracker made it: where its range is only guessed, it goes on with what these see.
    taken_over_from: Vec<Sensor>,
    /// What speaks for it.
    evidence: Evidence,
    /// Of sightings without a name: one of a scan at most, and so many until it is believed.
    last_scan: Option<(Sensor, NodeTime)>,
    sightings: u32,
}

/// Makes one picture of all that is seen.
#[derive(Debug)]
pub struct SwarmTracker {
    settings: SwarmSettings,
    tracks: Vec<Track>,
    tracklets: Vec<Tracklet>,
    last_id: u64,
}

/// How the class of a track follows its sightings.
const CLASS_SHARE: f64 = 0.03;
/// A sighting farther from what is predicted than this is none of the track: 99.9 % of the squared deviations of a bearing, and of a position.
const FARTHEST: [f64; 4] = [0.0, 10.8, 13.8, 16.3];
/// Of a larger deviation than this for each dimension (90 % are smaller) a sighting is doubted the more the larger it is.
const DOUBTED_FROM: f64 = 2.3;
/// A sighting without a name needs to fit this much better to one track than to any other.
const CLEARLY: f64 = 6.0;
/// Sightings without a name that make a track believed.
const BELIEVED_AFTER: u32 = 3;
/// One that is not believed yet ends after this without a sighting, in seconds: a radar may turn slowly.
const KEEP_UNBELIEVED_S: f64 = 2.5;
/// After so many its class follows slowly.
const SETTLED_AFTER: u32 = 40;
/// Nothing is older that another tracker made, in seconds: a day.
const LONGEST_AGE_S: f64 = 86_400.0;

impl SwarmTracker {
    /// One that knows of nothing yet.
    #[must_use]
    pub fn new(settings: SwarmSettings) -> Self {
        Self {
            settings,
            tracks: Vec::new(),
            tracklets: Vec::new(),
            last_id: 0,
        }
    }

    /// Takes one sighting, whose time may lie a little back.
    ///
    /// # Errors
    ///
    /// It cannot be true.
    pub fn take(&mut self, sighting: Sighting) -> Result<(), Unsound> {
        sighting.check()?;
        match sighting.name {
            Some(name) => self.take_named(name, sighting),
            None => self.take_nameless(&sighting),
        }
        Ok(())
    }

    /// Puts together what belongs together, and forgets what is gone. To be called several times a second.
    pub fn step(&mut self, now: NodeTime, own: &[OwnVehicle]) {
        self.forget(now);
        self.leave_out_own(own);
        self.join_tracks();
        self.pair_cameras();
        self.begin_from_guesses(now);
        self.hold_by_guesses(now);
        self.begin_from_positions();
        self.merge();
    }

    /// What is followed and is likely to be there, as of `now`. What an operator named or pinned is there.
    pub fn tracks(&self, now: NodeTime) -> impl Iterator<Item = SwarmTrack> {
        let told = self.tracks.iter().filter(move |track| {
            let wanted = track.pinned || !track.name.is_empty();
            track.sightings >= BELIEVED_AFTER && (wanted || track.evidence.is_told(now))
        });
        told.map(move |track| {
            let estimate = track.estimate.at(now, self.settings.acceleration_m2_s3);
            SwarmTrack {
                id: track.id,
                name: track.name.clone(),
                pinned: track.pinned,
                time: now,
                position: estimate.position(),
                velocity: estimate.velocity(),
                covariance: estimate.covariance,
                guessed_range: track.guessed_range,
                scores: track.scores.clone(),
                age_s: now.seconds_since(track.began),
                confidence: track.evidence.confidence(now),
                seen: track.seen,
                sensors: self.sensors_of(track.id, now),
            }
        })
    }

    /// Goes on with tracks that another tracker made, with their numbers, names and places: what sensors see from now on joins them. One whose number is known
    /// here already, or of which nothing is known any more, is left out.
    pub fn take_over(&mut self, tracks: impl IntoIterator<Item = SwarmTrack>) {
        for track in tracks {
            let estimate = Estimate {
                time: track.time,
                state: stacked(&track.position, &track.velocity),
                covariance: track.covariance,
            };
            let known = self.tracks.iter().any(|known| known.id == track.id);
            if known || self.tracks.len() >= self.settings.most_tracks || !estimate.is_sound() {
                continue;
            }
            self.last_id = self.last_id.max(track.id);
            self.tracks.push(Track {
                id: track.id,
                name: track.name,
                pinned: track.pinned,
                estimate,
                guessed_range: track.guessed_range,
                scores: track.scores,
                began: track.time.plus_seconds(-track.age_s.clamp(0.0, LONGEST_AGE_S)),
                seen: track.seen,
                taken_over_from: track.sensors,
                evidence: Evidence::of(track.time, track.confidence),
                last_scan: None,
                sightings: SETTLED_AFTER,
            });
        }
    }

    /// Calls a track by a name; an empty one takes the name away. False if there is no such track.
    pub fn rename(&mut self, id: u64, name: &str) -> bool {
        self.change(id, |track| name.clone_into(&mut track.name))
    }

    /// Keeps a track longer, or no longer. False if there is no such track.
    pub fn pin(&mut self, id: u64, pinned: bool) -> bool {
        self.change(id, |track| track.pinned = pinned)
    }

    /// Ends a track; what its sensors see under the present names begins no new one. False if there is no such track.
    pub fn drop_track(&mut self, id: u64) -> bool {
        let before = self.tracks.len();
        self.tracks.retain(|track| track.id != id);
        for tracklet in &mut self.tracklets {
            if tracklet.belongs == Belongs::Track(id) {
                tracklet.belongs = Belongs::Dropped;
            }
        }
        self.tracks.len() < before
    }

    fn change(&mut self, id: u64, change: impl FnOnce(&mut Track)) -> bool {
        let track = self.tracks.iter_mut().find(|track| track.id == id);
        track.map(change).is_some()
    }

    fn sensors_of(&self, id: u64, now: NodeTime) -> Vec<Sensor> {
        let of_it = self
            .tracklets
            .iter()
            .filter(|tracklet| tracklet.belongs == Belongs::Track(id));
        let seeing = of_it.filter(|tracklet| now.seconds_since(tracklet.seen()) < self.settings.sight_lost_s);
        let mut sensors: Vec<Sensor> = seeing.map(|tracklet| tracklet.sensor.clone()).collect();
        sensors.sort();
        sensors.dedup();
        sensors
    }

    fn take_named(&mut self, name: u64, sighting: Sighting) {
        let known = self
            .tracklets
            .iter()
            .position(|one| one.sensor == sighting.sensor && one.name == name);
        let index = match known {
            Some(index) => index,
            None => {
                if self.tracklets.len() >= self.settings.most_tracklets {
                    return;
                }
                self.tracklets.push(Tracklet::new(sighting.sensor.clone(), name));
                self.tracklets.len() - 1
            }
        };
        let tracklet = &mut self.tracklets[index];
        let Some(counts) = tracklet.remember(&sighting) else {
            return;
        };
        let Belongs::Track(id) = tracklet.belongs else { return };
        let fits = match self.tracks.iter_mut().find(|track| track.id == id) {
            Some(track) => track.take(&sighting, counts, self.settings.acceleration_m2_s3),
            None => false,
        };
        self.tracklets[index].note(fits);
    }

    /// To the track that predicts it, or the beginning of one.
    fn take_nameless(&mut self, sighting: &Sighting) {
        let density = self.settings.acceleration_m2_s3;
        let scan = (sighting.sensor.clone(), sighting.time);
        let mut fits: Vec<(f64, usize)> = Vec::new();
        for (index, track) in self.tracks.iter().enumerate() {
            let fit = track.estimate.fit(sighting.time, &sighting.observation, density);
            if let Some(fit) = fit.filter(|fit| fit.squared < FARTHEST[fit.dimensions])
                && track.last_scan.as_ref() != Some(&scan)
            {
                fits.push((fit.cost(), index));
            }
        }
        fits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let clear = fits.get(1).is_none_or(|second| second.0 - fits[0].0 > CLEARLY);
        match (fits.first(), &sighting.observation) {
            (Some((_, index)), _) if clear => {
                let track = &mut self.tracks[*index];
                track.last_scan = Some(scan);
                track.take(sighting, true, density);
            }
            (None, Observation::Position { position, covariance }) => {
                let estimate = Estimate::of_position(sighting.time, position, covariance);
                let worth = evidence::worth(&sighting.observation, &sighting.scores);
                self.begin(estimate, sighting.scores.clone(), 1, worth);
            }
            _ => {}
        }
    }

    /// A new track, if there is room: its number. So many sightings, which are worth so much, speak for it.
    fn begin(&mut self, estimate: Estimate, scores: ClassScores, sightings: u32, worth: f64) -> Option<u64> {
        if self.tracks.len() >= self.settings.most_tracks || !estimate.is_sound() {
            return None;
        }
        self.last_id += 1;
        self.tracks.push(Track {
            id: self.last_id,
            name: String::new(),
            pinned: false,
            guessed_range: false,
            scores,
            evidence: Evidence::new(estimate.time, worth),
            began: estimate.time,
            seen: estimate.time,
            estimate,
            taken_over_from: Vec::new(),
            last_scan: None,
            sightings,
        });
        Some(self.last_id)
    }

    fn forget(&mut self, now: NodeTime) {
        let settings = self.settings;
        self.tracklets
            .retain(|tracklet| now.seconds_since(tracklet.seen()) < tracklet::FORGOTTEN_AFTER_S);
        self.tracks.retain(|track| {
            let unseen_s = now.seconds_since(track.seen);
            let most_s = match (track.pinned, track.sightings < BELIEVED_AFTER) {
                (true, _) => settings.keep_pinned_s,
                (false, true) => KEEP_UNBELIEVED_S,
                (false, false) => settings.keep_s,
            };
            unseen_s < most_s && track.estimate.is_sound()
        });
        for tracklet in &mut self.tracklets {
            if let Belongs::Track(id) = tracklet.belongs
                && !self.tracks.iter().any(|track| track.id == id)
            {
                tracklet.belongs = Belongs::Nothing;
            }
        }
    }
}

/// Position and velocity as one.
fn stacked(position: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector6<f64> {
    let mut state = Vector6::zeros();
    state.fixed_rows_mut::<3>(0).copy_from(position);
    state.fixed_rows_mut::<3>(3).copy_from(velocity);
    state
}

impl Track {
    /// Takes a sighting in, which counts as evidence or not. False if it does not fit.
    fn take(&mut self, sighting: &Sighting, counts: bool, density: f64) -> bool {
        let fit = self.estimate.fit(sighting.time, &sighting.observation, density);
        let fit = fit.filter(|fit| fit.squared < FARTHEST[fit.dimensions]);
        let fits = fit.is_some_and(|fit| {
            // What one sensor sees beside the track moves it little, or a wrong bearing would lead it away from what the others see.
            let times = (fit.squared / (DOUBTED_FROM * fit.dimensions as f64)).max(1.0);
            let estimate = &mut self.estimate;
            estimate.correct_by(sighting.time, &sighting.observation, density, times)
        });
        if fits {
            self.seen = self.seen.max(sighting.time);
            if counts {
                self.evidence.add(sighting);
            }
            self.sightings = self.sightings.saturating_add(1);
            self.scores
                .blend(&sighting.scores, CLASS_SHARE.max(1.0 / f64::from(self.sightings)));
        }
        fits
    }
}

#[cfg(test)]
mod tests;
