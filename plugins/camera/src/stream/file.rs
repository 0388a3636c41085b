//! A video file as a stream: its pictures as they are encoded, each when its time has come.

use super::{Coded, Outlet, StreamFault};
use crate::decoding::{DecodeError, Video};
use std::path::Path;

/// Reads the file again and again.
pub(super) fn read(path: &Path, outlet: &Outlet) -> Result<(), StreamFault> {
    let mut video = Video::open(path)?;
    let mut round_began_s = 0.0;
    loop {
        for index in 0..video.len() {
            let bytes = video.coded(index).map_err(|error| DecodeError::Unreadable {
                path: path.to_owned(),
                reason: error.to_string(),
            })?;
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
