//! One encoded picture.

use skein_domain::NodeTime;
use std::sync::Arc;

/// How a picture is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Coding {
    /// An H.264 access unit in Annex B's byte stream; parameter sets stand before each key picture.
    H264,
    /// A JPEG file.
    Jpeg,
}

/// One encoded picture. Cheap to clone: the bytes are shared.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedFrame {
    /// How it is encoded.
    pub coding: Coding,
    /// Counts the pictures of its source; what is missing between two was lost.
    pub sequence: u64,
    /// When it was taken, on the node's clock.
    pub taken: NodeTime,
    /// Width in pixels.
    pub width_px: u32,
    /// Height in pixels.
    pub height_px: u32,
    /// A decoder can begin with it.
    pub key: bool,
    /// The bytes.
    pub bytes: Arc<[u8]>,
}
