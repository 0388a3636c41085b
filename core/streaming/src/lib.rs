//! Live video of the swarm's cameras on its way to whoever looks: made where a camera gives pixels alone, fetched from and sent to other nodes, sent as RTP,
//! recorded.
//!
//! * [`CameraStreams`]: all of it, for whoever looks at, records or lists cameras.
//! * [`RtpOut`]: the actor that sends cameras to fixed addresses.
//! * [`CameraVideo`]: how the video of one camera is.
//!
//! Bound: one task for each rendition that is looked at, with one picture in work; what comes meanwhile is left out but for the newest. Must never
//! do: encode what nobody looks at, compute on a thread that others wait for, or command a vehicle.
#![forbid(unsafe_code)]

mod between;
mod making;
mod recording;
mod rtp;
mod streams;
mod watching;

pub use recording::RecordedVideo;
pub use rtp::{RtpEnded, RtpOut, Sending};
pub use streams::{CameraStreams, CameraVideo};
