//! Finishes recordings that were cut off when the program ended: what is whole of them is written anew, with the summary by which readers find
//! their way at once.
//!
//! Must never do: replace a file before the new one is on the disk, or touch one that somebody writes.

use crate::folder;
use skein_recording::{Encoded, ReadError, Recording, Select, WriteError, Writer};
use std::fs;
use std::path::Path;

/// A chunk holds so much, in seconds: larger ones are packed better.
const CHUNK_S: f64 = 2.0;

/// Finishes all recordings of a folder that need it. What cannot be read or written stays as it is: readers take it as it is too.
pub fn finish_all(folder: &Path) {
    for path in folder::all(folder).unwrap_or_default() {
        if folder::is_being_written(&path) {
            continue;
        }
        match Recording::open(&path) {
            Ok(recording) if !recording.is_finished() => match finish(&recording) {
                Ok(messages) => tracing::info!("{}: finished, {messages} messages", path.display()),
                Err(error) => tracing::warn!("{}: left as it was cut off: {error}", path.display()),
            },
            // The program ended before it had recorded anything.
            Err(ReadError::Empty { .. }) => drop(fs::remove_file(&path)),
            _ => {}
        }
    }
}

fn finish(recording: &Recording) -> Result<u64, WriteError> {
    let path = recording.path();
    let beside = path.with_extension("finishing");
    let _ = fs::remove_file(&beside);
    let times = fs::metadata(path).and_then(|metadata| metadata.modified());
    let written = copied(recording, &beside);
    if written.is_err() {
        let _ = fs::remove_file(&beside);
        return written;
    }
    fs::rename(&beside, path)?;
    // It is as old as what it tells of.
    if let (Ok(file), Ok(changed)) = (fs::File::options().append(true).open(path), times) {
        let _ = file.set_modified(changed);
    }
    written
}

fn copied(recording: &Recording, to: &Path) -> Result<u64, WriteError> {
    let mut writer = Writer::create(to, recording.header().clone())?;
    let (mut messages, mut chunk_from) = (0, recording.span().0);
    // A chunk that is damaged is left out: its checksum says that nothing in it is to be believed.
    for message in recording.messages(Select::default()).filter_map(Result::ok) {
        let Some(topic) = message.topic else { continue };
        if message.recorded.seconds_since(chunk_from) >= CHUNK_S {
            writer.flush()?;
            chunk_from = message.recorded;
        }
        let (at, bytes) = (message.at, message.bytes);
        writer.write(&Encoded { topic, at, bytes }, message.recorded)?;
        messages += 1;
    }
    writer.finish()?;
    Ok(messages)
}
