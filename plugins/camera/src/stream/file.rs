//! A video file as a stream: its pictures as they are encoded, each when its time has come.

use super::{Coded, Outlet, StreamFault};
use crate::decoding::DecodeError;
use skein_video::Mp4Reader;
use std::path::Path;

/// Reads the file again and again.
pub(super) fn read(path: &Path, outlet: &Outlet) -> Result<(), StreamFault> {
    let mut video = Mp4Reader::open(path).map_err(DecodeError::Video)?;
    let mut round_began_s = 0.0;
    loop {
        for index in 0..video.len() {
            let bytes = video.coded(index).map_err(DecodeError::Video)?;
            let coded = Coded {
                due_s: Some(round_began_s + video.decoded_at_s(index)),
                ..Coded::at_once(bytes)
            };
            if !outlet.give(Ok(coded)) {
                return Ok(());
            }
        }
        round_began_s += video.duration_s();
    }
}
