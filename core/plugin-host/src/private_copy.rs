//! The private copy a library is loaded from. A library that was loaded stays as it was when it was judged, whatever happens to its
//! file; and the same file, exchanged for a newer version, can be loaded beside it: the loader sees another file.
//!
//! Must never do: judge one file and copy another. It is opened once; what was read of it is judged, copied and loaded.

use crate::LoadError;
use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Permission bit: others may write.
const OTHERS_MAY_WRITE: u32 = 0o002;

/// A copy that only this user can read, in a directory that goes when this value does. A loaded library outlives its file.
pub(crate) struct PrivateCopy {
    path: PathBuf,
    _directory: TempDir,
}

impl PrivateCopy {
    /// Copies what was read of the library that was at `path`.
    pub(crate) fn of(bytes: &[u8], path: &Path) -> Result<Self, LoadError> {
        Self::write(bytes, path).map_err(|source| LoadError::NotCopied { source })
    }

    fn write(bytes: &[u8], path: &Path) -> std::io::Result<Self> {
        let owner_only = std::fs::Permissions::from_mode(0o700);
        let directory = tempfile::Builder::new()
            .prefix("skein-plugin-")
            .permissions(owner_only)
            .tempdir()?;
        let copy = directory.path().join(path.file_name().unwrap_or_default());
        let mut file = std::fs::OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o700)
            .open(&copy)?;
        file.write_all(bytes)?;
        Ok(Self {
            path: copy,
            _directory: directory,
        })
    }

    /// Where the copy is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// Reads a library that nobody else can have written.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    let mut file = File::open(path)?;
    let real_path = path.canonicalize()?;
    refuse_if_others_may_write(&real_path, &file.metadata()?)?;
    if let Some(directory) = real_path.parent() {
        refuse_if_others_may_write(directory, &directory.metadata()?)?;
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Refuses what anyone on this machine could change.
pub(crate) fn refuse_if_others_may_write(path: &Path, metadata: &std::fs::Metadata) -> Result<(), LoadError> {
    let mode = metadata.permissions().mode() & 0o777;
    if mode & OTHERS_MAY_WRITE == 0 {
        return Ok(());
    }
    Err(LoadError::WritableByOthers {
        path: path.to_owned(),
        mode,
    })
}

#[cfg(test)]
mod tests;
