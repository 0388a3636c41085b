//! From what a detector found in a picture to bearings in the swarm frame: pure, but for reading which states are new.
//!
//! Must never do: believe a state that cannot be true, or the same one twice.

use serde::Deserialize;
use skein_domain::payload::{DetectorState, Finding, PayloadKind};
use skein_domain::{NodeTime, Telemetry, VehicleId};
use skein_state::{SharedState, VehicleRecord};
use skein_vision::{ClassScores, Lens, Observation, RangeGuess, Sensor, Sighting};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Of one picture no more findings are taken.
const MOST_FINDINGS: usize = 64;
/// Of one finding no more classes are taken, and none with a longer name.
const MOST_CLASSES: usize = 16;
const LONGEST_CLASS: usize = 64;
/// A picture older than this says nothing any more, in seconds; one later than now by this was taken by a clock that is wrong.
const OLDEST_S: f64 = 2.0;
const SOONEST_S: f64 = 0.1;
/// How well it is known where a camera points: gimbal, attitude and how it is mounted together, in radians. Half a degree: what a calm vehicle with a small
/// gimbal has.
const POINTING_ERROR_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// How well a vehicle knows its place relative to the others of its swarm if it does not say, along each axis in metres: a good satellite fix.
const ORIGIN_ERROR_M: f64 = 0.5;
/// What a vehicle says of it is believed within these bounds, in metres.
const ORIGIN_ERRORS_M: std::ops::RangeInclusive<f64> = 0.05..=20.0;
/// The middle of a box is off by this share of its size, if the detector does not say, and by a pixel at least.
const BOX_ERROR_SHARE: f64 = 0.1;
const BOX_ERROR_PX: f64 = 1.0;
/// Smaller boxes say nothing of a size, in pixels; and no larger size is told, in radians.
const SMALLEST_PX: f64 = 4.0;
const MOST_SIZE_RAD: f64 = 3.0;
/// Things of a class are larger or smaller than typical, and seen from the side or the front: one standard deviation of the range, as a factor.
const RANGE_FACTOR: f64 = 2.0;

/// Which states of detectors have been looked at.
#[derive(Debug, Default)]
pub(crate) struct DetectorsSeen {
    last: BTreeMap<(VehicleId, String), (u64, NodeTime)>,
}

impl DetectorsSeen {
    /// What detectors of this node's vehicles have found since the last look.
    pub(crate) fn look(&mut self, shared: &SharedState, now: NodeTime) -> Vec<Sighting> {
        let mut sightings = Vec::new();
        let mut there = BTreeMap::new();
        let peers = shared.peers();
        for record in shared.vehicles.records() {
            let origin_error_m = peers
                .entry(record.id)
                .map_or(ORIGIN_ERROR_M, |entry| origin_error_m(&entry.telemetry));
            for payload in record.payloads().iter().filter(|p| p.kind == PayloadKind::Detector) {
                let key = (record.id, payload.name.clone());
                let before = self.last.get(&key).copied().unwrap_or_default();
                let (revision, report) = {
                    let published = payload.state();
                    (published.revision, published.report.clone())
                };
                there.insert(key.clone(), before);
                let Some(report) = report.filter(|_| revision != before.0) else {
                    continue;
                };
                let Ok(state) = DetectorState::deserialize(report.value.as_ref()) else {
                    continue;
                };
                there.insert(key, (revision, state.time));
                let age_s = now.seconds_since(state.time);
                if state.time == before.1 || !(-SOONEST_S..=OLDEST_S).contains(&age_s) {
                    continue;
                }
                let sensor = sensor(&record, &state, &payload.name);
                sightings.extend(located(
                    &sensor,
                    &state,
                    origin_error_m,
                    &shared.config.tracking.width_m,
                ));
            }
        }
        self.last = there;
        sightings
    }
}

/// `VEHICLE/CAMERA`: the camera that the detector names, or the only one.
fn sensor(record: &VehicleRecord, state: &DetectorState, detector: &str) -> Sensor {
    let payloads = record.payloads();
    let only = || {
        payloads
            .iter()
            .find(|p| p.kind == PayloadKind::Camera)
            .map(|p| p.name.as_str())
    };
    let camera = match state.camera.as_str() {
        "" => only().unwrap_or(detector),
        named => named,
    };
    Sensor(format!("{}/{camera}", record.id))
}

/// How well a vehicle knows its place, one standard deviation in metres.
fn origin_error_m(telemetry: &Telemetry) -> f64 {
    let said = telemetry
        .estimator
        .and_then(|estimator| estimator.horizontal_accuracy_m);
    said.map(f64::from)
        .filter(|error_m| ORIGIN_ERRORS_M.contains(error_m))
        .unwrap_or(ORIGIN_ERROR_M)
}

/// What was found in one picture, as bearings. Nothing without the picture's size and where the camera was; what is only thought to be there is no sighting.
pub(crate) fn located(
    sensor: &Sensor,
    state: &DetectorState,
    origin_error_m: f64,
    width_m: &BTreeMap<String, f64>,
) -> Vec<Sighting> {
    let lens = state
        .pose
        .and_then(|pose| Some((pose, Lens::new(pose, state.width_px, state.height_px)?)));
    let Some((pose, lens)) = lens else { return Vec::new() };
    let sound = state
        .findings
        .iter()
        .filter(|finding| finding.is_sound() && finding.coasted_s == 0.0);
    sound
        .take(MOST_FINDINGS)
        .map(|finding| Sighting {
            sensor: sensor.clone(),
            name: name(&finding.id),
            time: state.time,
            observation: Observation::Bearing {
                origin: pose.position.vector(),
                origin_error_m,
                direction: lens.direction(finding.center_x_px, finding.center_y_px),
                error_rad: (error_px(finding) / lens.focal_px()).hypot(POINTING_ERROR_RAD).min(1.0),
            },
            scores: scores(finding),
            guess: guess(finding, &lens, width_m),
            size_rad: size_rad(finding, &lens),
        })
        .filter(|sighting| sighting.check().is_ok())
        .collect()
}

/// What a detector calls a thing, as a number.
fn name(id: &str) -> Option<u64> {
    if id.is_empty() {
        return None;
    }
    Some(id.parse().unwrap_or_else(|_| {
        let mut hasher = DefaultHasher::new();
        id.hash(&mut hasher);
        hasher.finish()
    }))
}

/// How far the middle of its box may be off, in pixels.
fn error_px(finding: &Finding) -> f64 {
    if finding.error_px > 0.0 {
        return finding.error_px;
    }
    (BOX_ERROR_SHARE * finding.width_px.max(finding.height_px)).max(BOX_ERROR_PX)
}

fn scores(finding: &Finding) -> ClassScores {
    let short = |class: &str| !class.is_empty() && class.len() <= LONGEST_CLASS;
    let mut all: Vec<(String, f64)> = finding
        .classes
        .iter()
        .map(|(class, score)| (class.clone(), *score))
        .collect();
    if !finding.classes.contains_key(&finding.class) {
        all.push((finding.class.clone(), finding.score));
    }
    all.retain(|(class, _)| short(class));
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.truncate(MOST_CLASSES);
    ClassScores::all(all)
}

/// How large it looks. Of a pixel or two nobody knows.
fn size_rad(finding: &Finding, lens: &Lens) -> Option<f64> {
    let size_px = finding.width_px.max(finding.height_px);
    (size_px >= SMALLEST_PX).then(|| (size_px / lens.focal_px()).min(MOST_SIZE_RAD))
}

/// How far it is, if it is as wide as things of its class typically are.
fn guess(finding: &Finding, lens: &Lens, width_m: &BTreeMap<String, f64>) -> Option<RangeGuess> {
    let width_m = width_m.get(&finding.class)?;
    let width_px = finding.width_px.max(finding.height_px);
    // Smaller than a pixel it has no size.
    (width_px >= 1.0).then(|| RangeGuess {
        range_m: width_m * lens.focal_px() / width_px,
        range_factor: RANGE_FACTOR,
    })
}

#[cfg(test)]
mod tests;
