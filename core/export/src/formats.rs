//! The formats of other programs that a recording is written in.
//!
//! Must never do: count a format as written that holds nothing.

use crate::{ExportError, Exported, Progress, rosbag, tables, tlog, tracks};
use skein_recording::Recording;
use std::path::Path;

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
