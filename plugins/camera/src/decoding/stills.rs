//! The pictures of a folder, in the order of their names, again and again.

use super::{DecodeError, MOST_PIXELS, Outlet, Picture};
use image::{ImageReader, Limits};
use std::path::{Path, PathBuf};

/// How many pictures are listed at most.
const MOST_PICTURES: usize = 100_000;

pub(super) fn read(folder: &Path, taken: u64, outlet: &Outlet) -> Result<(), DecodeError> {
    let paths = list(folder)?;
    let count = u64::try_from(paths.len()).unwrap_or(u64::MAX);
    let mut at = usize::try_from(taken % count.max(1)).unwrap_or(0);
    let mut failed = 0;
    while outlet.is_wanted() {
        let Some(path) = paths.get(at) else {
            return Err(DecodeError::Empty {
                path: folder.to_owned(),
            });
        };
        at = (at + 1) % paths.len();
        let picture = decode(path);
        // One that is damaged is told and passed over; a folder full of them is no source.
        failed = if picture.is_err() { failed + 1 } else { 0 };
        if !outlet.give(picture) || failed >= paths.len() {
            break;
        }
    }
    Ok(())
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, DecodeError> {
    let unreadable = |error: std::io::Error| DecodeError::Unreadable {
        path: folder.to_owned(),
        reason: error.to_string(),
    };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)?.take(MOST_PICTURES) {
        let path = entry.map_err(unreadable)?.path();
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
        if matches!(extension.as_deref(), Some("jpg" | "jpeg" | "png")) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

fn decode(path: &Path) -> Result<Picture, DecodeError> {
    let damaged = |reason: String| DecodeError::Damaged {
        path: path.to_owned(),
        reason,
    };
    let mut reader = ImageReader::open(path).map_err(|error| DecodeError::Unreadable {
        path: path.to_owned(),
        reason: error.to_string(),
    })?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_PIXELS * 4);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| damaged(error.to_string()))?.into_rgb8();
    let (width_px, height_px) = image.dimensions();
    Ok(Picture {
        width_px,
        height_px,
        rgb: image.into_raw(),
    })
}
