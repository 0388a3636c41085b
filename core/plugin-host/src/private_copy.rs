//! The private copy a library is loaded from. A library that was loaded stays as it was when it was judged, whatever happens to its
//! file; and the same file, exchanged for a newer version, can be loaded beside it: the loader sees another file.
//!
//! Must never do: judge one file and copy another. It is opened once; what was read of it is judged, copied and loaded.

use crate::LoadError;
use crate::trust::refuse_file_of_others;
use rustix::fs::{MemfdFlags, SealFlags};
use rustix::io::Errno;
use std::fs::{File, Metadata};
use std::io::{Read, Seek, Write};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// No library is longer, in bytes.
const MAX_LIBRARY_BYTES: u64 = 1 << 30;
/// How often sealing is tried again, and after what pause.
const SEAL_ATTEMPTS: u32 = 20;
const SEAL_PAUSE: Duration = Duration::from_millis(10);
/// A file that was written to within this time is read twice.
const RECENT: Duration = Duration::from_millis(100);

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

/// The bytes of a library in memory that nobody can change any more, to be handed to child processes.
pub(crate) fn sealed(bytes: &[u8]) -> Result<OwnedFd, LoadError> {
    let make = || -> std::io::Result<OwnedFd> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        // Kernels before 6.3 do not know that a file in memory may be forbidden to be run.
        let file = rustix::fs::memfd_create("skein-plugin", flags | MemfdFlags::EXEC)
            .or_else(|_| rustix::fs::memfd_create("skein-plugin", flags))?;
        let mut file = File::from(file);
        file.write_all(bytes)?;
        let seals = SealFlags::WRITE | SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL;
        seal(&file, seals)?;
        Ok(file.into())
    };
    make().map_err(|source| LoadError::NotCopied { source })
}

/// Seals a file in memory. The kernel refuses it as busy while anything of its own (moving or watching pages) holds one of its pages,
/// after a wait of its own; that passes.
fn seal(file: &File, seals: SealFlags) -> std::io::Result<()> {
    let mut attempts = 0;
    loop {
        match rustix::fs::fcntl_add_seals(file, seals) {
            Err(Errno::BUSY) if attempts < SEAL_ATTEMPTS => {
                attempts += 1;
                std::thread::sleep(SEAL_PAUSE);
            }
            sealed => return Ok(sealed?),
        }
    }
}

/// What tells one state of a file from another. The time of its last change is set by the system with every write, rename and change of
/// its rights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileState {
    device: u64,
    inode: u64,
    len: u64,
    modified_ns: (i64, i64),
    changed_ns: (i64, i64),
}

impl FileState {
    pub(crate) fn of(metadata: &Metadata) -> Self {
        Self {
            device: metadata.dev(),
            inode: metadata.ino(),
            len: metadata.len(),
            modified_ns: (metadata.mtime(), metadata.mtime_nsec()),
            changed_ns: (metadata.ctime(), metadata.ctime_nsec()),
        }
    }
}

/// Reads a library that nobody else can have written, whole: one that is written to meanwhile is refused.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    let real_path = path.canonicalize()?;
    let mut file = File::open(&real_path)?;
    let before = file.metadata()?;
    refuse_file_of_others(&real_path, &before)?;
    if before.len() > MAX_LIBRARY_BYTES {
        return Err(LoadError::NotLoadable {
            detail: format!("it has {} bytes, the limit is {MAX_LIBRARY_BYTES}", before.len()),
        });
    }
    let bytes = read_whole(&mut file, before.len())?;
    // The system's time stamps are some milliseconds coarse: what was written just now is compared with a second look.
    let recent = before
        .modified()
        .is_ok_and(|at| at.elapsed().is_ok_and(|age| age < RECENT));
    if recent {
        file.rewind()?;
        if read_whole(&mut file, before.len())? != bytes {
            return Err(LoadError::ChangedWhileRead);
        }
    }
    if FileState::of(&file.metadata()?) != FileState::of(&before) || bytes.len() as u64 != before.len() {
        return Err(LoadError::ChangedWhileRead);
    }
    Ok(bytes)
}

fn read_whole(file: &mut File, len: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(usize::try_from(len).unwrap_or(0));
    // One byte more would show that it has grown.
    file.take(len.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
