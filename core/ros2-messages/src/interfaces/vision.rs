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
    /// A place in a picture, in pixels.
    Point2D { x: f64, y: f64 }
    /// The same, turned.
    Pose2D { position: Point2D, theta: f64 }
    /// A box in a picture.
    BoundingBox2D { center: Pose2D, size_x: f64, size_y: f64 }
    /// Something that was found in a picture.
    Detection2D { header: Header, results: Vec<ObjectHypothesisWithPose>, bbox: BoundingBox2D, id: String }
    /// All that was found in a picture.
    Detection2DArray { header: Header, detections: Vec<Detection2D> }
    /// A box around something.
    BoundingBox3D { center: Pose, size: Vector3 }
    /// Something that was found or is tracked.
    Detection3D { header: Header, results: Vec<ObjectHypothesisWithPose>, bbox: BoundingBox3D, id: String }
    /// Several of them.
    Detection3DArray { header: Header, detections: Vec<Detection3D> }
}
