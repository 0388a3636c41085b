//! What detectors found in pictures, as `vision_msgs`.
//!
//! Must never do: trust a plugin: what cannot be true is left out, and of very much only the beginning is said.

use crate::frames;
use crate::interfaces::geometry::{Pose, PoseWithCovariance};
use crate::interfaces::standard::Header;
use crate::interfaces::vision::{
    BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesis, ObjectHypothesisWithPose, Point2D, Pose2D,
};
use skein_domain::payload::{DetectorState, Finding, PayloadKind};
use skein_view::{PayloadSnapshot, VehicleSnapshot};

/// More than these are not told of one picture.
const MOST: usize = 256;

/// The state of a detector, if what the payload reports is one.
#[must_use]
pub fn state(payload: &PayloadSnapshot) -> Option<DetectorState> {
    serde_json::from_value(payload.state.clone()?).ok()
}

/// The camera of this vehicle that a detector speaks of: the one it names, or the only one.
#[must_use]
pub fn camera<'a>(vehicle: &'a VehicleSnapshot, state: &DetectorState) -> Option<&'a str> {
    let cameras = vehicle.payloads.iter().filter(|p| p.kind == PayloadKind::Camera);
    let mut meant = cameras.filter(|payload| state.camera.is_empty() || payload.name == state.camera);
    let camera = meant.next()?;
    meant.next().is_none().then_some(camera.name.as_str())
}

/// All that was found in one picture, whose header this is.
#[must_use]
pub fn array(header: &Header, state: &DetectorState) -> Detection2DArray {
    let sound = state.findings.iter().filter(|finding| finding.is_sound());
    Detection2DArray {
        header: header.clone(),
        detections: sound.take(MOST).map(|finding| detection(header, finding)).collect(),
    }
}

fn detection(header: &Header, finding: &Finding) -> Detection2D {
    Detection2D {
        header: header.clone(),
        results: hypotheses(finding).map(hypothesis).collect(),
        bbox: BoundingBox2D {
            center: Pose2D {
                position: Point2D {
                    x: finding.center_x_px,
                    y: finding.center_y_px,
                },
                theta: 0.0,
            },
            size_x: finding.width_px,
            size_y: finding.height_px,
        },
        id: finding.id.clone(),
    }
}

/// What a thing may be with which score, the likeliest first.
fn hypotheses(finding: &Finding) -> impl Iterator<Item = (String, f64)> {
    let others = finding.classes.iter().filter(|(class, _)| **class != finding.class);
    let mut all: Vec<(String, f64)> = others.map(|(class, score)| (class.clone(), *score)).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    std::iter::once((finding.class.clone(), finding.score)).chain(all)
}

fn hypothesis((class_id, score): (String, f64)) -> ObjectHypothesisWithPose {
    ObjectHypothesisWithPose {
        hypothesis: ObjectHypothesis { class_id, score },
        pose: PoseWithCovariance {
            pose: Pose {
                orientation: frames::unrotated(),
                ..Pose::default()
            },
            ..PoseWithCovariance::default()
        },
    }
}

#[cfg(test)]
mod tests;
