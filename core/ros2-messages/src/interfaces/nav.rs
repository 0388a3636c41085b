//! `nav_msgs`.
//!
//! Must never do: convert between frames.

use super::geometry::{PoseWithCovariance, TwistWithCovariance};
use super::messages;
use super::standard::Header;

messages! { "nav_msgs":
    /// Pose in the frame of the header, velocity in that of the child.
    Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance }
}
