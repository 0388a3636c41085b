//! Decisions of a recording, made again.
//!
//! Must never do: mix what several nodes decided: gates and periods are numbered by each node.

use crate::{ExportError, Progress, origin};
use skein_recording::{Damage, Recording, Redecided, Redecider, Select};

/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// What came of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Again {
    /// How decisions compare.
    pub decided: Redecided,
    /// What could not be read.
    pub damage: Vec<Damage>,
}

/// Makes all decisions of a recording again.
///
/// # Errors
/// When it was merged of several.
pub fn redecide(recording: &Recording, progress: Progress<'_>) -> Result<Again, ExportError> {
    if origin::is_merged(recording) {
        let path = recording.path().to_owned();
        return Err(ExportError::Merged { path });
    }
    let (first, last) = recording.span();
    let length_s = last.seconds_since(first).max(1e-6);
    let mut redecider = Redecider::default();
    let (mut damage, mut count) = (Vec::new(), 0_u64);
    for message in recording.messages(Select::only(Redecider::wants)) {
        match message {
            Ok(message) => {
                if count.is_multiple_of(REPORT_EVERY) {
                    progress(message.recorded.seconds_since(first) / length_s);
                }
                redecider.take(&message);
                count += 1;
            }
            Err(damaged) => damage.push(damaged),
        }
    }
    progress(1.0);
    Ok(Again {
        decided: redecider.finish(),
        damage,
    })
}
