//! What an evaluation came to: by camera, and by class within it.

use super::clips::Clip;
use super::eye::Names;
use serde::Serialize;
use skein_vision::{Scorer, Scores, ToldBox, TrueBox};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Of each picture of a clip what is there, and what was told.
pub(super) type Pictures = Vec<(Vec<TrueBox>, Vec<ToldBox>)>;

/// A clip that was shown to a detector.
pub(super) struct Watched {
    pub(super) camera: String,
    pub(super) label: String,
    name: String,
    renumbered: bool,
    pub(super) pictures: Pictures,
    pub(super) names: Names,
    pub(super) decoding_s: f64,
    pub(super) looking_s: f64,
    pub(super) stages_s: BTreeMap<String, f64>,
    /// Pictures of the file that could not be decoded.
    pub(super) undecoded: u64,
}

impl Watched {
    pub(super) fn new(clip: &Clip, renumbered: bool) -> Self {
        Self {
            camera: clip.camera.clone(),
            label: clip.label.clone(),
            name: clip.name.clone(),
            renumbered,
            pictures: Vec::new(),
            names: Names::default(),
            decoding_s: 0.0,
            looking_s: 0.0,
            stages_s: BTreeMap::new(),
            undecoded: 0,
        }
    }

    /// One line of progress.
    pub(super) fn summary(&self) -> String {
        let mut scorer = Scorer::new(&self.label);
        scorer.clip(&self.pictures);
        let Scores { f1, .. } = scorer.scores();
        let called = self
            .called()
            .map_or_else(String::new, |class| format!(", called {class}"));
        format!(
            "{:<22} {:>4} pictures  F1 {f1:.3}{called}",
            self.name,
            self.pictures.len()
        )
    }

    /// What the labelled thing was called most often, where it was found at all.
    fn called(&self) -> Option<&str> {
        let mut votes: BTreeMap<&str, u32> = BTreeMap::new();
        for (truths, told) in &self.pictures {
            let Some(truth) = truths.first() else { continue };
            let best = told.iter().max_by(|a, b| {
                let shared = |told: &ToldBox| told.bounds.overlap(&truth.bounds);
                shared(a).total_cmp(&shared(b))
            });
            if let Some(best) = best.filter(|best| best.bounds.overlap(&truth.bounds) > 0.1) {
                *votes.entry(&best.class).or_default() += 1;
            }
        }
        votes
            .into_iter()
            .max_by_key(|(_, count)| *count)
            .map(|(class, _)| class)
    }
}

#[derive(Debug, Default)]
struct OfCamera {
    clips: u64,
    renumbered: u64,
    pictures: u64,
    undecoded: u64,
    decoding_s: f64,
    looking_s: f64,
    stages_s: BTreeMap<String, f64>,
    classes: BTreeMap<String, Scorer>,
    /// For each label, what its clips were called: how many.
    called: BTreeMap<String, BTreeMap<String, u64>>,
}

/// Takes clips, one after the other.
#[derive(Default)]
pub(super) struct Report {
    cameras: BTreeMap<String, OfCamera>,
    /// By camera: which classes there are is known when all are seen, and what is told of one is false in the clips of another.
    kept: BTreeMap<String, Vec<Pictures>>,
}

impl Report {
    pub(super) fn take(&mut self, watched: Watched) {
        let of = self.cameras.entry(watched.camera.clone()).or_default();
        of.clips += 1;
        of.renumbered += u64::from(watched.renumbered);
        of.pictures += watched.pictures.len() as u64;
        of.undecoded += watched.undecoded;
        of.decoding_s += watched.decoding_s;
        of.looking_s += watched.looking_s;
        for (stage, took_s) in &watched.stages_s {
            *of.stages_s.entry(stage.clone()).or_default() += took_s;
        }
        let called = watched.called().unwrap_or("nothing").to_owned();
        let votes = of.called.entry(watched.label.clone()).or_default();
        *votes.entry(called).or_default() += 1;
        self.kept
            .entry(watched.camera.clone())
            .or_default()
            .push(watched.pictures.clone());
    }

    pub(super) fn clips(&self) -> u64 {
        self.cameras.values().map(|of| of.clips).sum()
    }

    /// All figures.
    pub(super) fn figures(mut self) -> Figures {
        for (camera, clips) in &self.kept {
            let Some(of) = self.cameras.get_mut(camera) else {
                continue;
            };
            let truths = clips
                .iter()
                .flatten()
                .flat_map(|(truths, _)| truths.iter().map(|truth| &truth.class));
            let classes: BTreeSet<&String> = truths.collect();
            for class in classes {
                let mut scorer = Scorer::new(class);
                for pictures in clips {
                    scorer.clip(pictures);
                }
                of.classes.insert(class.clone(), scorer);
            }
        }
        Figures {
            iou: 0.5,
            cameras: self
                .cameras
                .iter()
                .map(|(camera, of)| (camera.clone(), of.figures()))
                .collect(),
        }
    }
}

impl OfCamera {
    fn figures(&self) -> CameraFigures {
        let rate = |seconds: f64| {
            if seconds > 0.0 {
                self.pictures as f64 / seconds
            } else {
                0.0
            }
        };
        CameraFigures {
            clips: self.clips,
            clips_numbered_from_one: self.renumbered,
            pictures: self.pictures,
            pictures_not_decoded: self.undecoded,
            frames_per_s: rate(self.looking_s),
            decoded_per_s: rate(self.decoding_s),
            stages_s: self
                .stages_s
                .iter()
                .map(|(stage, took_s)| (stage.clone(), took_s / self.pictures.max(1) as f64))
                .collect(),
            classes: self
                .classes
                .iter()
                .map(|(class, scorer)| (class.clone(), scorer.scores().into()))
                .collect(),
            clips_called: self.called.clone(),
        }
    }
}

/// What is printed.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    /// Boxes share this much of the area that both cover, or are not of the same thing.
    iou: f64,
    cameras: BTreeMap<String, CameraFigures>,
}

#[derive(Debug, Serialize)]
struct CameraFigures {
    clips: u64,
    /// Clips whose labels number pictures from 1; they are taken as that.
    clips_numbered_from_one: u64,
    pictures: u64,
    /// Pictures that could not be decoded: they are left out.
    pictures_not_decoded: u64,
    /// Pictures that one instance looks at in a second, one at a time.
    frames_per_s: f64,
    /// Pictures that are decoded in a second, one at a time.
    decoded_per_s: f64,
    /// What each part of looking at a picture takes, as the detector says itself, in seconds.
    stages_s: BTreeMap<String, f64>,
    classes: BTreeMap<String, ClassFigures>,
    /// For each label, as what its clips were seen most of the time: how many clips.
    clips_called: BTreeMap<String, BTreeMap<String, u64>>,
}

#[derive(Debug, Serialize)]
struct ClassFigures {
    objects: u64,
    told: u64,
    precision: f64,
    recall: f64,
    f1: f64,
    ap50: f64,
    mota: f64,
    idf1: f64,
    identity_switches: u64,
}

impl From<Scores> for ClassFigures {
    fn from(scores: Scores) -> Self {
        let rounded = |value: f64| (value * 1e4).round() / 1e4;
        Self {
            objects: scores.truths,
            told: scores.told,
            precision: rounded(scores.precision),
            recall: rounded(scores.recall),
            f1: rounded(scores.f1),
            ap50: rounded(scores.ap50),
            mota: rounded(scores.mota),
            idf1: rounded(scores.idf1),
            identity_switches: scores.identity_switches,
        }
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (camera, of) in &self.cameras {
            writeln!(
                f,
                "{camera}: {} clips, {} pictures, {:.0} pictures/s ({:.0}/s decoded)",
                of.clips, of.pictures, of.frames_per_s, of.decoded_per_s
            )?;
            if of.clips_numbered_from_one > 0 {
                writeln!(f, "  {} clips number their labels from 1", of.clips_numbered_from_one)?;
            }
            writeln!(
                f,
                "  {:<12} {:>7} {:>9} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8}  clips called",
                "class", "objects", "precision", "recall", "F1", "AP50", "MOTA", "IDF1", "switches"
            )?;
            for (class, scores) in &of.classes {
                let called = of.clips_called.get(class).into_iter().flatten();
                let called: Vec<String> = called.map(|(as_what, count)| format!("{as_what} {count}")).collect();
                writeln!(
                    f,
                    "  {class:<12} {:>7} {:>9.3} {:>7.3} {:>7.3} {:>7.3} {:>7.3} {:>7.3} {:>8}  {}",
                    scores.objects,
                    scores.precision,
                    scores.recall,
                    scores.f1,
                    scores.ap50,
                    scores.mota,
                    scores.idf1,
                    scores.identity_switches,
                    called.join(", ")
                )?;
            }
        }
        Ok(())
    }
}
