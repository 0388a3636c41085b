//! Judges what a camera gives as H.264, and makes every key picture one that a decoder can begin with.

use crate::frame::{Coding, EncodedFrame};
use crate::h264::{H264Error, StreamFormat, contents};
use skein_domain::NodeTime;
use std::sync::Arc;
use thiserror::Error;

/// A picture with more bytes is not taken: no camera's key picture is so large.
const MOST_BYTES: usize = 4 << 20;

/// Why a picture is not taken.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FrameFault {
    /// It is no picture.
    #[error(transparent)]
    NotH264(#[from] H264Error),
    /// It is too large.
    #[error("a picture of {bytes} bytes; at most {most} are taken")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The largest.
        most: usize,
    },
    /// Nothing that came so far tells the format.
    #[error("no parameter set came yet")]
    NoParameterSet,
}

/// Takes the access units of one camera.
#[derive(Debug, Default)]
pub struct Intake {
    parameter_sets: Vec<u8>,
    format: Option<StreamFormat>,
}

impl Intake {
    /// Takes one access unit in Annex B's byte stream.
    ///
    /// # Errors
    ///
    /// It is no picture, too large, or nothing tells its format yet.
    pub fn take(&mut self, sequence: u64, taken: NodeTime, bytes: &[u8]) -> Result<EncodedFrame, FrameFault> {
        if bytes.len() > MOST_BYTES {
            return Err(FrameFault::TooLarge {
                bytes: bytes.len(),
                most: MOST_BYTES,
            });
        }
        let found = contents(bytes)?;
        let has_format = found.format.is_some();
        if has_format {
            self.format = found.format;
            self.parameter_sets = found.parameter_sets;
        }
        let format = self.format.ok_or(FrameFault::NoParameterSet)?;
        // A camera may tell its parameter sets once; who begins to look later has to have them too.
        let bytes: Arc<[u8]> = if found.idr && !has_format {
            [self.parameter_sets.as_slice(), bytes].concat().into()
        } else {
            bytes.into()
        };
        Ok(EncodedFrame {
            coding: Coding::H264,
            sequence,
            taken,
            width_px: format.width_px,
            height_px: format.height_px,
            key: found.idr,
            bytes,
        })
    }

    /// The format that was told last.
    #[must_use]
    pub fn format(&self) -> Option<StreamFormat> {
        self.format
    }
}

#[cfg(test)]
mod tests;
