//! Encoded video as it goes from a camera to its viewers: what an H.264 access unit holds, how long it is kept, who gets which one next, and how
//! pictures are encoded, decoded and made smaller.
//!
//! * [`EncodedFrame`]: one picture, H.264 or JPEG.
//! * [`Relay`]: the newest pictures of one stream, of which each viewer takes those it is in time for.
//! * [`Intake`]: judges what a camera gives, and makes every key picture one that a decoder can begin with.
//!
//! Must never do: keep more than its bounds; know of sockets, clocks or threads; panic at damaged pictures.
#![forbid(unsafe_code)]

mod codec;
mod frame;
pub mod h264;
mod intake;
mod jpeg;
mod meter;
mod mp4;
mod planes;
mod relay;

pub use codec::{CodecError, Encoded, H264Decoder, H264Encoder, Rgb};
pub use frame::{Coding, EncodedFrame};
pub use h264::{H264Error, StreamFormat};
pub use intake::{FrameFault, Intake};
pub use jpeg::{JpegError, jpeg};
pub use meter::{Measured, Meter};
pub use mp4::{Mp4Error, Mp4ReadError, Mp4Reader, Mp4Writer};
pub use planes::{Planes, PlanesError};
pub use relay::{Cursor, Given, MOST_KEPT_BYTES, Relay};
