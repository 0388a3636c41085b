//! `geometry_msgs` and `tf2_msgs`.
//!
//! Must never do: convert between frames.

use super::standard::Header;
use super::{Fixed, messages};

messages! { "geometry_msgs":
    /// A place, in metres.
    Point { x: f64, y: f64, z: f64 }
    /// A direction, a velocity or a rate.
    Vector3 { x: f64, y: f64, z: f64 }
    /// An orientation.
    Quaternion { x: f64, y: f64, z: f64, w: f64 }
    /// Place and orientation.
    Pose { position: Point, orientation: Quaternion }
    /// The same, at a time and in a frame.
    PoseStamped { header: Header, pose: Pose }
    /// The same, with how sure it is.
    PoseWithCovariance { pose: Pose, covariance: Fixed<36> }
    /// Velocity in metres per second and rates in radians per second.
    Twist { linear: Vector3, angular: Vector3 }
    /// The same, at a time and along the axes of a frame.
    TwistStamped { header: Header, twist: Twist }
    /// The same, with how sure it is.
    TwistWithCovariance { twist: Twist, covariance: Fixed<36> }
    /// Where a frame lies in another.
    Transform { translation: Vector3, rotation: Quaternion }
    /// The same, at a time and with their names.
    TransformStamped { header: Header, child_frame_id: String, transform: Transform }
}

messages! { "tf2_msgs":
    /// Transforms, as TF takes them.
    TFMessage { transforms: Vec<TransformStamped> }
}
