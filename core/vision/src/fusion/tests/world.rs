//! Cameras that look at targets, drawn from a seed, and how well the tracks agree with the truth.

use super::super::*;
use crate::ClassScores;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use std::collections::BTreeMap;

const STEP_S: f64 = 0.1;
const ERROR_RAD: f64 = 0.008;
const VIEW_RAD: f64 = 1.3;
/// Two things nearer to each other than this in a picture are one.
const ONE_RAD: f64 = 0.012;
/// Share of the pictures in which a target is found.
const FOUND: f64 = 0.9;
/// Share of the pictures after which it has another name.
const RENAMED: f64 = 0.002;

struct Target {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
}

struct Camera {
    angle_rad: f64,
    distance_m: f64,
    height_m: f64,
    /// What it calls each target.
    names: Vec<u64>,
    last_name: u64,
}

pub(super) struct World {
    chance: ChaCha8Rng,
    targets: Vec<Target>,
    cameras: Vec<Camera>,
    settings: SwarmSettings,
    /// In how many cameras' view each target is now.
    in_view: Vec<usize>,
}

/// How well the truth was followed.
#[derive(Debug, Default)]
pub(super) struct Judged {
    /// Targets times moments at which they were to be followed.
    pub(super) wanted: u32,
    /// Of which they were.
    pub(super) samples: u32,
    square_m2: f64,
    /// Sum of squared deviations of six dimensions.
    pub(super) squared: f64,
    /// A target got another track.
    pub(super) switches: u32,
    /// Tracks that two cameras see, times moments at which there was no such target.
    pub(super) strangers: u32,
    names: BTreeMap<usize, u64>,
}

impl Judged {
    pub(super) fn error_m(&self) -> f64 {
        (self.square_m2 / f64::from(self.samples)).sqrt()
    }

    pub(super) fn followed(&self) -> f64 {
        f64::from(self.samples) / f64::from(self.wanted)
    }
}

impl World {
    pub(super) fn new(seed: u64, cameras: usize, targets: usize) -> Self {
        let mut chance = ChaCha8Rng::seed_from_u64(seed);
        let cameras = (0..cameras).map(|index| Camera {
            angle_rad: std::f64::consts::TAU * index as f64 / cameras as f64 + chance.random_range(-0.3..0.3),
            distance_m: chance.random_range(85.0..110.0),
            height_m: chance.random_range(20.0..40.0),
            names: (0..targets as u64).collect(),
            last_name: targets as u64,
        });
        let cameras = cameras.collect();
        // They fly to the other side, past each other near the middle.
        let targets = (0..targets).map(|_| {
            let angle: f64 = chance.random_range(0.0..std::f64::consts::TAU);
            let speed = chance.random_range(1.0..3.0);
            Target {
                position: Vector3::new(30.0 * angle.cos(), 30.0 * angle.sin(), -chance.random_range(15.0..45.0)),
                velocity: Vector3::new(-speed * angle.cos(), -speed * angle.sin(), 0.0),
            }
        });
        Self {
            targets: targets.collect(),
            cameras,
            in_view: Vec::new(),
            settings: SwarmSettings {
                acceleration_m2_s3: 0.3,
                ..SwarmSettings::default()
            },
            chance,
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.chance)
    }

    /// Flies so long; the pictures of these cameras are looked at.
    pub(super) fn fly(mut self, flight_s: f64, looked_at: &[usize]) -> Judged {
        let mut tracker = SwarmTracker::new(self.settings);
        let mut result = Judged::default();
        for step in 0..(flight_s / STEP_S) as u64 {
            let now = NodeTime::from_seconds(10.0 + step as f64 * STEP_S);
            self.advance();
            self.in_view = vec![0; self.targets.len()];
            for index in 0..self.cameras.len() {
                // All chances are drawn in the same order, whoever is looked at.
                let is_looked_at = looked_at.contains(&index);
                let sightings = self.look(index, now, is_looked_at);
                if is_looked_at {
                    sightings
                        .into_iter()
                        .for_each(|sighting| tracker.take(sighting).expect("is sound"));
                }
            }
            tracker.step(now, &[]);
            if step as f64 * STEP_S > 8.0 {
                self.judge(&tracker, now, looked_at.len().min(2), &mut result);
            }
        }
        result
    }

    fn advance(&mut self) {
        let density = self.settings.acceleration_m2_s3;
        for index in 0..self.targets.len() {
            let bump = Vector3::from_fn(|_, _| self.normal() * (density * STEP_S).sqrt());
            let target = &mut self.targets[index];
            target.position += target.velocity * STEP_S + bump * (STEP_S / 2.0);
            target.velocity += bump;
            // Back to where the cameras look.
            let pull = Vector3::new(target.position.x, target.position.y, target.position.z + 30.0) * -0.004;
            target.velocity += pull * STEP_S;
        }
        for camera in &mut self.cameras {
            camera.angle_rad += 0.02 * STEP_S;
        }
    }

    fn look(&mut self, index: usize, now: NodeTime, looked_at: bool) -> Vec<Sighting> {
        let camera = &self.cameras[index];
        let origin = Vector3::new(
            camera.distance_m * camera.angle_rad.cos(),
            camera.distance_m * camera.angle_rad.sin(),
            -camera.height_m,
        );
        let axis = (Vector3::new(0.0, 0.0, -30.0) - origin).normalize();
        let mut sightings: Vec<Sighting> = Vec::new();
        for target in 0..self.targets.len() {
            let way = self.targets[target].position - origin;
            let (range_m, direction) = (way.norm(), way.normalize());
            let found = self.chance.random_bool(FOUND);
            let renamed = self.chance.random_bool(RENAMED);
            let (right, up, size) = (self.normal(), self.normal(), self.normal());
            let camera = &mut self.cameras[index];
            if renamed {
                camera.last_name += 1;
                camera.names[target] = camera.last_name;
            }
            let seen = estimate::across(&direction);
            let direction = (direction + (seen[0] * right + seen[1] * up) * ERROR_RAD).normalize();
            let hidden = sightings.iter().any(|other| match &other.observation {
                Observation::Bearing { direction: other, .. } => other.angle(&direction) < ONE_RAD,
                Observation::Position { .. } => false,
            });
            let in_view = direction.angle(&axis) < VIEW_RAD / 2.0;
            self.in_view[target] += usize::from(in_view && looked_at);
            if !in_view || !found || hidden {
                continue;
            }
            sightings.push(Sighting {
                sensor: Sensor(format!("{index}/camera")),
                name: Some(camera.names[target]),
                time: now,
                observation: Observation::Bearing {
                    origin,
                    origin_error_m: 0.1,
                    direction,
                    error_rad: ERROR_RAD,
                },
                scores: ClassScores::one("drone", 0.9),
                guess: Some(RangeGuess {
                    range_m: range_m * (0.3 * size).exp(),
                    range_factor: 1.35,
                }),
                size_rad: Some(0.5 / range_m),
            });
        }
        sightings
    }

    /// What enough cameras have in view is to be followed.
    fn judge(&self, tracker: &SwarmTracker, now: NodeTime, enough: usize, result: &mut Judged) {
        let tracks: Vec<SwarmTrack> = tracker.tracks(now).collect();
        let mut costs: Vec<(f64, usize, usize)> = Vec::new();
        for (target, truth) in self.targets.iter().enumerate() {
            for (index, track) in tracks.iter().enumerate() {
                costs.push(((track.position - truth.position).norm(), target, index));
            }
        }
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut of_target, mut used) = (BTreeMap::new(), vec![false; tracks.len()]);
        for (error_m, target, index) in costs {
            // A guessed range may be wrong by half.
            let near_m = if tracks[index].guessed_range { 100.0 } else { 5.0 };
            if error_m < near_m && !used[index] && !of_target.contains_key(&target) {
                of_target.insert(target, index);
                used[index] = true;
            }
        }
        let seen = (0..tracks.len()).filter(|index| tracks[*index].sensors.len() >= 2);
        result.strangers += seen.filter(|index| !used[*index]).count() as u32;
        // What nobody could see for a while may be new.
        result.names.retain(|target, _| self.in_view[*target] > 0);
        result.wanted += self.in_view.iter().filter(|cameras| **cameras >= enough).count() as u32;
        for (target, index) in of_target {
            if self.in_view[target] < enough {
                continue;
            }
            let (track, truth) = (&tracks[index], &self.targets[target]);
            let (off, off_speed) = (track.position - truth.position, track.velocity - truth.velocity);
            let off_all = nalgebra::Vector6::from_iterator(off.iter().chain(off_speed.iter()).copied());
            let solved = track.covariance.cholesky().expect("a covariance").solve(&off_all);
            result.samples += 1;
            result.square_m2 += off.norm_squared();
            result.squared += off_all.dot(&solved);
            let before = result.names.insert(target, track.id);
            result.switches += u32::from(before.is_some_and(|before| before != track.id));
        }
    }
}
