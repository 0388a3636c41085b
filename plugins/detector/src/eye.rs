//! One picture after another to what is in it: model, motion, the rule that joins them, and tracks.

use crate::classifier::{Light, TrackClassifier};
use crate::fault::ModelFault;
use crate::joining;
use crate::model::OnnxModel;
use crate::picture::Picture;
use crate::report::{PictureFault, Stages};
use crate::settings::{Model, Settings};
use skein_domain::NodeTime;
use skein_domain::payload::{DetectorState, Finding, FrameHeader};
use skein_vision::{Gray, Lens, MotionDetector, PictureTrack, PictureTracker, Turn, UNKNOWN_CLASS};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Instant;

/// A camera that gives the same picture for so long is frozen, in seconds. One that stands still has noise all the same.
const FROZEN_AFTER_S: f64 = 2.0;
/// A picture without a brighter pixel than this, of 255, is black.
const BLACK_BELOW: u8 = 8;

/// The class of which [`Settings::drone_score`] speaks.
const DRONE: &str = "drone";
/// A track that is older than this, in seconds, and has not moved yet is no drone but a part of the scene. The rule is for drones alone: a helicopter, or an
/// aeroplane that comes nearer, does stand still in the picture.
const STANDS_AFTER_S: f64 = 0.6;

/// What was seen in one picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Look {
    pub(crate) found: DetectorState,
    pub(crate) picture_fault: Option<PictureFault>,
    pub(crate) fault: Option<ModelFault>,
    pub(crate) last_id: u64,
    pub(crate) took_s: f64,
    pub(crate) stages: Stages,
}

/// What looks.
pub(crate) struct Eye {
    model: OnnxModel,
    motion: Option<MotionDetector>,
    tracker: PictureTracker,
    /// For our own models alone: it knows their classes, and the light that they see.
    classifier: Option<TrackClassifier>,
    doubtful_score: f64,
    drone_score: f64,
    /// How the camera looked in the last picture, if it says so.
    lens: Option<Lens>,
    /// What the last picture's bytes are like, and since when they are.
    same: Option<(u64, NodeTime)>,
}

impl Eye {
    /// Goes on with the numbers of tracks after `last_id`.
    ///
    /// # Errors
    ///
    /// A model that comes with the plugin cannot be read.
    pub(crate) fn new(settings: &Settings, model: OnnxModel, last_id: u64) -> Result<Self, ModelFault> {
        let light = settings.own_model().map(|model| match model {
            Model::Visible => Light::Visible,
            Model::Infrared => Light::Infrared,
        });
        Ok(Self {
            classifier: light.map(TrackClassifier::new).transpose()?,
            model,
            motion: settings.motion.then(MotionDetector::default),
            tracker: PictureTracker::after(settings.tracking(), last_id),
            doubtful_score: settings.doubtful_score,
            drone_score: settings.drone_score(),
            lens: None,
            same: None,
        })
    }

    /// Looks at a frame.
    pub(crate) fn look(&mut self, header: &FrameHeader, bytes: &[u8]) -> Look {
        let mut look = Look::default();
        match Picture::read(header, bytes) {
            None => look.picture_fault = Some(PictureFault::Unreadable),
            Some(picture) => {
                look.picture_fault = self.picture_fault(header.time, &picture);
                // Where the model fails nothing is told: what was followed before would stand there as if it had been found in this picture.
                let turn = self.turn(header, &picture);
                match self.follow(header.time, &picture, turn, &mut look.stages) {
                    Ok(tracks) => look.found.findings = tracks.iter().map(finding).collect(),
                    Err(fault) => look.fault = Some(fault),
                }
                look.found.width_px = picture.width as u32;
                look.found.height_px = picture.height as u32;
            }
        }
        look.found.camera.clone_from(&header.camera);
        look.found.time = header.time;
        look.found.pose = header.pose;
        look.last_id = self.tracker.last_id();
        look
    }

    /// How the camera has turned since the last picture.
    fn turn(&mut self, header: &FrameHeader, picture: &Picture) -> Turn {
        let lens = header
            .pose
            .and_then(|pose| Lens::new(pose, picture.width as u32, picture.height as u32));
        Turn::by_pose(std::mem::replace(&mut self.lens, lens), lens)
    }

    fn follow(
        &mut self,
        time: NodeTime,
        picture: &Picture,
        turn: Turn,
        stages: &mut Stages,
    ) -> Result<Vec<PictureTrack>, ModelFault> {
        let begun = Instant::now();
        let found = self.model.find(picture, self.doubtful_score)?;
        stages.model_s = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let gray = picture.gray();
        let motion = self
            .motion
            .as_mut()
            .map(|motion| motion.take(gray.clone(), turn.of_middle()))
            .unwrap_or_default();
        stages.motion_s = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let found = joining::join(found, &motion.moving);
        self.tracker.take(time, &turn.put_right(motion.shift_px), found);
        let mut tracks: Vec<PictureTrack> = self.tracker.tracks().collect();
        self.name(time, &gray, &mut tracks)?;
        stages.tracks_s = begun.elapsed().as_secs_f64();
        Ok(tracks)
    }

    /// Says what tracks are taken for.
    fn name(&mut self, time: NodeTime, gray: &Gray, tracks: &mut [PictureTrack]) -> Result<(), ModelFault> {
        // How sure the model is that there is something at all; the classifier shares that out.
        let sure = tracks
            .iter()
            .map(|track| track.scores.best().map_or(0.0, |(_, score)| score));
        let sure: Vec<f64> = sure.collect();
        if let Some(classifier) = &mut self.classifier {
            classifier.look(time, gray, tracks)?;
        }
        for (track, sure) in tracks.iter_mut().zip(sure) {
            let scene = self.classifier.is_some() && stands(track);
            if sure < self.drone_score || scene {
                track.scores = track.scores.renamed(DRONE, UNKNOWN_CLASS);
            }
        }
        Ok(())
    }

    fn picture_fault(&mut self, time: NodeTime, picture: &Picture) -> Option<PictureFault> {
        let mut hasher = DefaultHasher::new();
        picture.rgb.hash(&mut hasher);
        let hash = hasher.finish();
        let since = match self.same {
            Some((last, since)) if last == hash => since,
            _ => time,
        };
        self.same = Some((hash, since));
        if picture.rgb.iter().all(|value| *value < BLACK_BELOW) {
            return Some(PictureFault::Black);
        }
        (time.seconds_since(since) >= FROZEN_AFTER_S).then_some(PictureFault::Frozen)
    }
}

/// Whether it is more likely a part of the scene than something that flies.
pub(crate) fn stands(track: &PictureTrack) -> bool {
    !track.moved && track.age_s >= STANDS_AFTER_S
}

fn finding(track: &PictureTrack) -> Finding {
    let (class, score) = track.scores.best().map_or(("", 0.0), |best| best);
    Finding {
        class: class.to_owned(),
        score,
        center_x_px: track.bounds.center_x_px,
        center_y_px: track.bounds.center_y_px,
        width_px: track.bounds.width_px,
        height_px: track.bounds.height_px,
        id: track.id.to_string(),
        error_px: track.error_px,
        coasted_s: track.coasted_s,
        classes: track
            .scores
            .iter()
            .map(|(class, score)| (class.to_owned(), score))
            .collect::<BTreeMap<_, _>>(),
    }
}
