//! The formats of other programs that a recording is written in.
//!
//! Must never do: leave out silently what could not be read.

use crate::told::Unread;
use crate::{ExportError, Progress, rosbag, tables, tlog, tracks};
use skein_recording::{Damage, Recording};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Tables as text: a folder.
    Csv,
    /// Tables by column: a folder.
    Parquet,
    /// Tracks for maps on a globe: a file.
    Kml,
    /// Tracks for maps: a file.
    Gpx,
    /// A bag of ROS 2: a folder.
    Rosbag,
    /// MAVLink as ground stations record it, a file for each vehicle: a folder.
    Tlog,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exported {
    /// The files.
    pub files: Vec<PathBuf>,
    /// How much of each kind: rows of a table, points of a vehicle's track, messages of a topic, frames of a vehicle.
    pub counts: BTreeMap<String, u64>,
    /// Messages that are not what their topic says.
    pub unreadable: u64,
    /// Parts of the recording that could not be read.
    pub damage: Vec<Damage>,
}

impl Exported {
    pub(crate) fn count(&mut self, of: &str) {
        match self.counts.get_mut(of) {
            Some(count) => *count += 1,
            None => {
                self.counts.insert(of.to_owned(), 1);
            }
        }
    }

    pub(crate) fn without(mut self, unread: Unread) -> Self {
        self.unreadable += unread.messages;
        self.damage.extend(unread.damage);
        self
    }
}

/// Writes a recording in a format, to a file or folder that is not there yet.
///
/// # Errors
/// When it holds nothing of what the format tells, or the files cannot be written.
pub fn export(
    recording: &Recording,
    format: Format,
    out: &Path,
    progress: Progress<'_>,
) -> Result<Exported, ExportError> {
    let exported = match format {
        Format::Csv => tables::csv(recording, out, progress)?,
        Format::Parquet => tables::parquet(recording, out, progress)?,
        Format::Kml => tracks::kml(recording, out, progress)?,
        Format::Gpx => tracks::gpx(recording, out, progress)?,
        Format::Rosbag => rosbag::write(recording, out, progress)?,
        Format::Tlog => tlog::write(recording, out, progress)?,
    };
    if exported.counts.is_empty() {
        let what = match format {
            Format::Kml | Format::Gpx => "place of a vehicle on Earth",
            _ => "telemetry, setpoint or event",
        };
        let path = recording.path().to_owned();
        return Err(ExportError::Nothing { path, what });
    }
    Ok(exported)
}
