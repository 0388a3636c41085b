//! `vision_msgs`.
//!
//! Must never do: hold a message that nothing here speaks.

use super::geometry::{Pose, PoseWithCovariance, Vector3};
use super::messages;
use super::standard::Header;

messages! { "vision_msgs":
    /// What something may be.
    ObjectHypothesis { class_id: String, score: f64 }
    /// The same, and where.
    ObjectHypothesisWithPose { hypothesis: ObjectHypothesis, pose: PoseWithCovariance }
    /// A box around something.
    BoundingBox3D { center: Pose, size: Vector3 }
    /// Something that was found or is tracked.
    Detection3D { header: Header, results: Vec<ObjectHypothesisWithPose>, bbox: BoundingBox3D, id: String }
    /// Several of them.
    Detection3DArray { header: Header, detections: Vec<Detection3D> }
}
