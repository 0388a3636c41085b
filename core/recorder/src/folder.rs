//! The folder of recordings: how files are called, and which go when there are too many.
//!
//! Must never do: delete a file that is being written, or one of the flight under way.

use jiff::Timestamp;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// How files of recordings end.
const ENDING: &str = "mcap";
/// How logs of autopilots end, which lie beside them and go as they go.
pub const LOG_ENDING: &str = "ulg";
/// How a part of one ends, which a program that was killed leaves.
pub const PART_ENDING: &str = "part";
/// In the name of a file in which nobody was armed.
const GROUND: &str = "_ground";

/// How much is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keep {
    /// In bytes.
    pub bytes: u64,
    /// How old, at most.
    pub age: Duration,
}

/// A name for a file that begins now: by time of day, so that they sort, and by node, so that those of several can lie in one folder.
#[must_use]
pub fn name(unix_ns: u64, node: &str) -> String {
    let seconds = i64::try_from(unix_ns / 1_000_000_000).unwrap_or_default();
    let at = Timestamp::from_second(seconds).unwrap_or_default();
    format!("{}_{}", at.strftime("%Y-%m-%dT%H-%M-%SZ"), plain(node))
}

/// A name of something as a part of a file's.
#[must_use]
pub fn plain(name: &str) -> String {
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' })
        .take(40)
        .collect()
}

/// A path of that name that is not there yet.
#[must_use]
pub fn free_path(folder: &Path, name: &str) -> PathBuf {
    let path = |number: u32| match number {
        1 => folder.join(format!("{name}.{ENDING}")),
        number => folder.join(format!("{name}-{number}.{ENDING}")),
    };
    let mut numbers = 1..;
    let free = numbers.find(|number| !path(*number).exists());
    path(free.unwrap_or(1))
}

/// Names a file as one in which nobody was armed. These go first.
pub fn mark_as_ground(path: &Path) -> io::Result<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let marked = path.with_file_name(format!("{stem}{GROUND}.{ENDING}"));
    fs::rename(path, &marked)?;
    Ok(marked)
}

/// A recording in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Kept {
    path: PathBuf,
    bytes: u64,
    changed: SystemTime,
    is_ground: bool,
}

fn recordings(folder: &Path, endings: &[&str]) -> io::Result<Vec<Kept>> {
    let mut kept = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        let metadata = entry.metadata()?;
        let wanted = path
            .extension()
            .is_some_and(|is| endings.iter().any(|ending| is == *ending));
        if metadata.is_file() && wanted {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            kept.push(Kept {
                is_ground: stem.ends_with(GROUND),
                bytes: metadata.len(),
                changed: metadata.modified()?,
                path,
            });
        }
    }
    Ok(kept)
}

/// All recordings of the folder.
///
/// # Errors
/// When it cannot be read.
pub fn all(folder: &Path) -> io::Result<Vec<PathBuf>> {
    Ok(recordings(folder, &[ENDING])?
        .into_iter()
        .map(|kept| kept.path)
        .collect())
}

/// Whether another program, or this one, writes a file at this moment.
#[must_use]
pub fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// Deletes what is too old, then of the rest the oldest until it fits, with `more_bytes` free beside: first files in which nobody flew. Returns what
/// went.
///
/// # Errors
/// When the folder cannot be read. A file that cannot be deleted stays.
pub fn prune(folder: &Path, keep: Keep, more_bytes: u64, spared: &[PathBuf]) -> io::Result<Vec<PathBuf>> {
    let mut kept = recordings(folder, &[ENDING, LOG_ENDING, PART_ENDING])?;
    kept.sort_by_key(|kept| (!kept.is_ground, kept.changed));
    let now = SystemTime::now();
    let mut bytes: u64 = kept.iter().map(|kept| kept.bytes).sum();
    let (mut freed, mut gone) = (0, Vec::new());
    for kept in kept {
        let is_old = now.duration_since(kept.changed).is_ok_and(|age| age > keep.age);
        if !(is_old || bytes > keep.bytes || freed < more_bytes) {
            continue;
        }
        if spared.contains(&kept.path) || is_being_written(&kept.path) {
            continue;
        }
        if fs::remove_file(&kept.path).is_ok() {
            bytes = bytes.saturating_sub(kept.bytes);
            freed += kept.bytes;
            gone.push(kept.path);
        }
    }
    Ok(gone)
}
