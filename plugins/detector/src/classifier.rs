//! What a track is, told from its last second: windows around its box at eight moments, and what its boxes say of size, shape and motion, go into a
//! second small model, whose word is joined with that of the model that found it.
//!
//! The formulas are those of `training/classify.py`: whoever changes one changes both.
//!
//! Must never do: decide where something is, or that there is something.

mod boxes;
mod window;

use crate::fault::ModelFault;
use rten::{RunOptions, ThreadPool, ValueOrView};
use rten_tensor::NdTensor;
use rten_tensor::prelude::*;
use skein_domain::NodeTime;
use skein_vision::{Bounds, ClassScores, Gray, PictureTrack};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use window::{CELLS, Window};

const MODEL: &[u8] = include_bytes!("../models/classifier.onnx");
/// What it tells apart, in the order of its output.
const CLASSES: [&str; 4] = ["drone", "bird", "airplane", "helicopter"];
/// Moments that are looked at, and how far they are apart in seconds: four pictures of thirty in a second.
const MOMENTS: usize = 8;
const APART_S: f64 = 4.0 / 30.0;
/// Pictures are this much too late or early, in seconds.
const TOLERANCE_S: f64 = 0.005;
/// So much is kept of the model that found it where it says nothing of a class.
const DOUBT: f64 = 0.02;
/// A word of the model is no smaller than this.
const LEAST: f64 = 1e-4;

/// Which light a camera sees: sizes and shares of it mean something else in the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Light {
    Visible,
    Infrared,
}

/// A track's past.
#[derive(Debug, Default)]
struct Past {
    seen: VecDeque<(NodeTime, Window, Bounds)>,
    /// Sum of the logarithms of what the model said, and how often it did.
    said: [f64; 4],
    runs: u32,
    ran: Option<NodeTime>,
}

/// Tells tracks of one camera apart.
pub(crate) struct TrackClassifier {
    net: rten::Model,
    threads: Arc<ThreadPool>,
    light: Light,
    tracks: BTreeMap<u64, Past>,
}

impl TrackClassifier {
    /// # Errors
    ///
    /// The model that comes with the plugin cannot be read: a fault of the build.
    pub(crate) fn new(light: Light) -> Result<Self, ModelFault> {
        let net = rten::Model::load(MODEL.to_vec()).map_err(|error| ModelFault::Unreadable(error.to_string()))?;
        Ok(Self {
            net,
            threads: Arc::new(ThreadPool::with_num_threads(1)),
            light,
            tracks: BTreeMap::new(),
        })
    }

    /// Takes the tracks of a picture, and puts right what they are taken for.
    ///
    /// # Errors
    ///
    /// The model fails.
    pub(crate) fn look(
        &mut self,
        time: NodeTime,
        picture: &Gray,
        tracks: &mut [PictureTrack],
    ) -> Result<(), ModelFault> {
        self.tracks.retain(|id, _| tracks.iter().any(|track| track.id == *id));
        for track in tracks {
            let past = self.tracks.entry(track.id).or_default();
            if let Some(found) = track.found {
                past.remember(time, picture, found);
            }
            let due = past
                .ran
                .is_none_or(|ran| time.seconds_since(ran) >= APART_S - TOLERANCE_S);
            if due && let Some((windows, numbers)) = past.input(time, self.light) {
                past.ran = Some(time);
                let said = run(&self.net, &self.threads, windows, numbers)?;
                past.runs += 1;
                for (sum, said) in past.said.iter_mut().zip(said) {
                    *sum += said.max(LEAST).ln();
                }
            }
            track.scores = past.joined(&track.scores);
        }
        Ok(())
    }
}

impl Past {
    fn remember(&mut self, time: NodeTime, picture: &Gray, found: Bounds) {
        let oldest_s = APART_S * MOMENTS as f64;
        // The newest of those that are too old stays: it is the nearest to the oldest moment.
        while self
            .seen
            .get(1)
            .is_some_and(|(seen, _, _)| time.seconds_since(*seen) > oldest_s)
        {
            self.seen.pop_front();
        }
        self.seen.push_back((time, window::around(picture, &found), found));
    }

    /// Windows and numbers of the eight moments, the oldest first.
    fn input(&self, time: NodeTime, light: Light) -> Option<(Vec<f32>, [f32; boxes::NUMBERS])> {
        let oldest = self.seen.front()?;
        let moments = (0..MOMENTS).map(|moment| {
            let ago_s = APART_S * (MOMENTS - 1 - moment) as f64;
            let before = self
                .seen
                .iter()
                .rev()
                .find(|(seen, _, _)| time.seconds_since(*seen) >= ago_s - TOLERANCE_S);
            before.unwrap_or(oldest)
        });
        let moments: Vec<_> = moments.collect();
        let windows: Vec<&Window> = moments.iter().map(|(_, window, _)| window).collect();
        let bounds: Vec<Bounds> = moments.iter().map(|(_, _, bounds)| *bounds).collect();
        Some((window::normalised(&windows), boxes::numbers(&bounds, light)))
    }

    /// What both models say together; how sure it is that there is something stays the finder's word.
    fn joined(&self, finder: &ClassScores) -> ClassScores {
        let scores = CLASSES.map(|class| finder.of(class));
        let (sum, most) = (
            scores.iter().sum::<f64>(),
            scores.iter().fold(0.0, |most: f64, score| most.max(*score)),
        );
        if self.runs == 0 || sum <= 0.0 {
            return finder.clone();
        }
        // The first runs see less than a second, and count less.
        let trust = (f64::from(self.runs + 1) / 4.0).min(1.0);
        let mut odds = [0.0; 4];
        for (odds, (said, score)) in odds.iter_mut().zip(self.said.iter().zip(scores)) {
            *odds = 2.0 * trust * said / f64::from(self.runs) + (score / sum + DOUBT).ln();
        }
        let highest = odds.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares = odds.map(|odds| (odds - highest).exp());
        let whole: f64 = shares.iter().sum();
        let told = CLASSES
            .iter()
            .zip(shares)
            .map(|(class, share)| ((*class).to_owned(), most * share / whole));
        let others = finder.iter().filter(|(class, _)| !CLASSES.contains(class));
        ClassScores::all(told.chain(others.map(|(class, score)| (class.to_owned(), score))))
    }
}

fn run(
    net: &rten::Model,
    threads: &Arc<ThreadPool>,
    windows: Vec<f32>,
    numbers: [f32; boxes::NUMBERS],
) -> Result<[f64; 4], ModelFault> {
    let failed = |why: String| ModelFault::Failed(format!("the classifier of tracks: {why}"));
    let id = |name: &str| net.node_id(name).map_err(|error| failed(error.to_string()));
    let windows = NdTensor::from_data([1, MOMENTS, CELLS, CELLS], windows);
    let numbers = NdTensor::from_data([1, boxes::NUMBERS], numbers.to_vec());
    let inputs: Vec<(_, ValueOrView)> = vec![(id("windows")?, windows.into()), (id("numbers")?, numbers.into())];
    let options = RunOptions::default().with_thread_pool(Some(threads.clone()));
    let [said] = net
        .run_n(inputs, [id("probabilities")?], Some(options))
        .map_err(|error| failed(error.to_string()))?;
    let said: NdTensor<f32, 2> = said.try_into().map_err(|error| failed(format!("{error}")))?;
    let mut out = [0.0; 4];
    for (index, out) in out.iter_mut().enumerate() {
        *out = said.get([0, index]).map_or(f64::NAN, |value| f64::from(*value));
        if !out.is_finite() {
            return Err(ModelFault::NotNumbers);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests;
