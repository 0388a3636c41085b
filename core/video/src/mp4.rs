//! A recording as a fragmented MP4 file (ISO/IEC 14496-12): what is written is whole after every second, however it ends.

mod reader;

pub use reader::{Mp4ReadError, Mp4Reader};

use crate::frame::EncodedFrame;
use crate::h264::{self, H264Error, UnitKind};
use muxide::fragmented::{FragmentConfig, FragmentedError, FragmentedMuxer};
use skein_domain::NodeTime;
use thiserror::Error;

/// Ticks per second of the file's clock.
const TIMESCALE: u32 = 90_000;
/// What is lost at most when the program is killed, in milliseconds.
const FRAGMENT_MS: u32 = 1_000;

/// Why there is no file.
#[derive(Debug, Error)]
pub enum Mp4Error {
    /// It does not begin with a key picture.
    #[error("a recording begins with a key picture")]
    NoKeyPicture,
    /// A picture is none.
    #[error(transparent)]
    H264(#[from] H264Error),
    /// The writer does not take it.
    #[error("{0}")]
    Writer(#[from] FragmentedError),
}

/// Makes the bytes of one file.
#[derive(Debug)]
pub struct Mp4Writer {
    muxer: FragmentedMuxer,
    size_px: (u32, u32),
    began: NodeTime,
    last_ticks: Option<u64>,
}

impl Mp4Writer {
    /// For a stream that begins with this key picture; gives what the file begins with.
    ///
    /// # Errors
    ///
    /// It is no key picture with its parameter sets.
    pub fn new(first: &EncodedFrame) -> Result<(Self, Vec<u8>), Mp4Error> {
        let set = |kind| h264::units(&first.bytes).into_iter().find(|unit| unit.kind == kind);
        let (Some(sps), Some(pps), true) = (
            set(UnitKind::SequenceParameterSet),
            set(UnitKind::PictureParameterSet),
            first.key,
        ) else {
            return Err(Mp4Error::NoKeyPicture);
        };
        let mut config =
            FragmentConfig::new(first.width_px, first.height_px, TIMESCALE).with_fragment_duration_ms(FRAGMENT_MS);
        (config.sps, config.pps) = (sps.bytes, pps.bytes);
        let mut muxer = FragmentedMuxer::new(config)?;
        let head = muxer.init_segment();
        let writer = Self {
            muxer,
            size_px: (first.width_px, first.height_px),
            began: first.taken,
            last_ticks: None,
        };
        Ok((writer, head))
    }

    /// Whether a picture belongs into this file: one of another size needs one of its own.
    #[must_use]
    pub fn fits(&self, frame: &EncodedFrame) -> bool {
        (frame.width_px, frame.height_px) == self.size_px
    }

    /// Takes the next picture; gives what is to be written now.
    ///
    /// # Errors
    ///
    /// The writer does not take it.
    pub fn push(&mut self, frame: &EncodedFrame) -> Result<Option<Vec<u8>>, Mp4Error> {
        let written = if self.muxer.ready_to_flush() {
            self.muxer.flush_segment()
        } else {
            None
        };
        let since_s = frame.taken.seconds_since(self.began).max(0.0);
        let ticks = (since_s * f64::from(TIMESCALE)).round() as u64;
        // A camera's clock may stand; a player's must not.
        let ticks = self.last_ticks.map_or(ticks, |last| ticks.max(last + 1));
        self.last_ticks = Some(ticks);
        let sample = h264::length_prefixed(&frame.bytes);
        self.muxer.write_video(ticks, ticks, &sample, frame.key)?;
        Ok(written)
    }

    /// What is still to be written.
    #[must_use]
    pub fn finish(mut self) -> Option<Vec<u8>> {
        self.muxer.flush_segment()
    }
}

#[cfg(test)]
mod tests;
