//! Pictures from files, decoded on a thread of their own and handed over one by one.
//!
//! Must never do: decode further ahead than a few pictures.

mod stills;
mod video;

use crate::feed::{Ended, Feed};
use skein_video::Mp4ReadError;
use std::path::PathBuf;
use thiserror::Error;

/// How many pictures may wait: one to give, one in the making.
const QUEUE_LEN: usize = 2;
/// Larger pictures are not believed, in pixels.
const MOST_PIXELS: u64 = 64 << 20;

/// A picture, three bytes per pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    pub(crate) rgb: Vec<u8>,
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum DecodeError {
    #[error("{} cannot be read: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    #[error("there is no picture in {}", path.display())]
    Empty { path: PathBuf },
    #[error(transparent)]
    Video(#[from] Mp4ReadError),
    #[error("{} is damaged: {reason}", path.display())]
    Damaged { path: PathBuf, reason: String },
    #[error(transparent)]
    Ended(#[from] Ended),
}

/// What is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Files {
    /// The pictures of a folder.
    Stills(PathBuf),
    /// A video, `rate_hz` pictures for each second of it.
    Video { path: PathBuf, rate_hz: f64 },
}

/// Reads pictures on its own thread.
pub(crate) type Reader = Feed<Picture, DecodeError>;
/// Where it puts them.
type Outlet = crate::feed::Outlet<Picture, DecodeError>;

/// Begins after as many pictures as were taken before.
pub(crate) fn start(files: Files, taken: u64) -> std::io::Result<Reader> {
    Feed::start("skein-decode", QUEUE_LEN, move |outlet| match &files {
        Files::Stills(folder) => stills::read(folder, taken, outlet),
        Files::Video { path, rate_hz } => video::read(path, *rate_hz, taken, outlet),
    })
}

#[cfg(test)]
mod tests;
