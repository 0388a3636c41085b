//! The decisions of a recording with all that they were made from, and nothing else: small enough to be kept as a test.
//!
//! Must never do: leave out what a decision needs, or keep what nobody can decide again.

use crate::rewrite::Rewriter;
use crate::{ExportError, Progress, Rewritten, origin};
use skein_recording::{Message, Recording, Redecider, Select, SetpointRecord, Topic};
use std::path::Path;

/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// Writes them.
///
/// # Errors
/// When the recording was merged of several, or the file cannot be made.
pub fn decisions(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Rewritten, ExportError> {
    if origin::is_merged(recording) {
        let path = recording.path().to_owned();
        return Err(ExportError::Merged { path });
    }
    let name = recording.path().file_name().unwrap_or_default();
    let how = [("file", name.to_string_lossy().into_owned())];
    let mut writer = Rewriter::create(out, recording.header(), "skein.decisions", how)?;
    let (first, last) = recording.span();
    let length_s = last.seconds_since(first).max(1e-6);
    let mut damage = Vec::new();
    for (count, message) in (0_u64..).zip(recording.messages(Select::only(Redecider::wants))) {
        match message {
            Ok(message) => {
                if count.is_multiple_of(REPORT_EVERY) {
                    progress(message.recorded.seconds_since(first) / length_s);
                }
                if can_be_made_again(&message) {
                    writer.write(&message.name, message.recorded, message.at, &message.bytes)?;
                }
            }
            Err(damaged) => damage.push(damaged),
        }
    }
    let messages = writer.finish()?;
    progress(1.0);
    Ok(Rewritten { messages, damage })
}

/// A setpoint whose control period was thinned out is none.
fn can_be_made_again(message: &Message) -> bool {
    if !matches!(message.topic, Some(Topic::Setpoint(_))) {
        return true;
    }
    let setpoint = message.json::<SetpointRecord>();
    setpoint.is_ok_and(|setpoint| setpoint.peers.is_some())
}
