//! An archive on its way to this node: a file that grows from its beginning, so that what was there goes on where it stopped.
//!
//! Must never do: grow beyond what was offered, or write anywhere but at its end.

use skein_view::{ArchiveInfo, UpgradeRefusal};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// No archive is larger, in bytes.
pub const MOST_ARCHIVE_BYTES: u64 = 512 << 20;
/// What stays free on the disk, in bytes: logs and recordings go on.
const RESERVE_BYTES: u64 = 64 << 20;

/// An archive that has been offered.
#[derive(Debug)]
pub struct Incoming {
    offered: ArchiveInfo,
    path: PathBuf,
    file: File,
    has_bytes: u64,
}

fn storage(error: &io::Error) -> UpgradeRefusal {
    UpgradeRefusal::Storage {
        detail: error.to_string(),
    }
}

impl Incoming {
    /// Begins with an archive, or goes on with it where an earlier try stopped. Others that were on their way are forgotten.
    ///
    /// # Errors
    /// When it is too large, or the disk too full.
    pub fn open(folder: &Path, offered: ArchiveInfo) -> Result<Self, UpgradeRefusal> {
        if offered.bytes > MOST_ARCHIVE_BYTES {
            let detail = format!("{} bytes are more than {MOST_ARCHIVE_BYTES}", offered.bytes);
            return Err(UpgradeRefusal::Damaged { detail });
        }
        let digest = &offered.digest;
        if digest.len() != 64 || !digest.chars().all(|c| c.is_ascii_hexdigit()) {
            let detail = "its digest is no SHA-256".into();
            return Err(UpgradeRefusal::Damaged { detail });
        }
        std::fs::create_dir_all(folder).map_err(|e| storage(&e))?;
        let path = folder.join(format!("{digest}.part"));
        for other in std::fs::read_dir(folder).map_err(|e| storage(&e))?.flatten() {
            if other.path() != path {
                // What cannot be removed takes room, which is looked at next.
                let _ = std::fs::remove_file(other.path());
            }
        }
        let opened = OpenOptions::new().append(true).create(true).open(&path);
        let file = opened.map_err(|e| storage(&e))?;
        let mut has_bytes = file.metadata().map_err(|e| storage(&e))?.len();
        if has_bytes > offered.bytes {
            file.set_len(0).map_err(|e| storage(&e))?;
            has_bytes = 0;
        }
        let missing = offered.bytes - has_bytes;
        room(folder, missing.saturating_add(offered.unpacked_bytes))?;
        Ok(Self {
            offered,
            path,
            file,
            has_bytes,
        })
    }

    /// What was offered.
    #[must_use]
    pub fn offered(&self) -> &ArchiveInfo {
        &self.offered
    }

    /// How much of it is there, in bytes.
    #[must_use]
    pub fn has_bytes(&self) -> u64 {
        self.has_bytes
    }

    /// Takes a part. One that is there already, or comes too early, changes nothing: the answer says where to go on.
    ///
    /// # Errors
    /// When it is more than was offered, or the disk fails.
    pub fn take(&mut self, at_byte: u64, bytes: &[u8]) -> Result<u64, UpgradeRefusal> {
        if at_byte != self.has_bytes {
            return Ok(self.has_bytes);
        }
        if self.has_bytes.saturating_add(bytes.len() as u64) > self.offered.bytes {
            let detail = "more of it came than was offered".into();
            return Err(UpgradeRefusal::Damaged { detail });
        }
        if let Err(error) = self.file.write_all(bytes) {
            // Half a part is as good as none.
            let _ = self.file.set_len(self.has_bytes);
            return Err(storage(&error));
        }
        self.has_bytes += bytes.len() as u64;
        Ok(self.has_bytes)
    }

    /// The file, once it is there whole.
    ///
    /// # Errors
    /// When it is not.
    pub fn whole(&self) -> Result<&Path, UpgradeRefusal> {
        if self.has_bytes == self.offered.bytes {
            return Ok(&self.path);
        }
        let detail = format!("{} of {} bytes are there", self.has_bytes, self.offered.bytes);
        Err(UpgradeRefusal::Damaged { detail })
    }

    /// It is not needed any more, or of no use.
    pub fn forget(self) {
        // The next one removes it otherwise.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Whether so much can be written.
///
/// # Errors
/// When it cannot.
pub fn room(folder: &Path, bytes: u64) -> Result<(), UpgradeRefusal> {
    let disk = rustix::fs::statvfs(folder).map_err(|e| storage(&e.into()))?;
    let free_bytes = disk.f_bavail.saturating_mul(disk.f_frsize);
    let needed_bytes = bytes.saturating_add(RESERVE_BYTES);
    if free_bytes < needed_bytes {
        return Err(UpgradeRefusal::NoRoom {
            needed_bytes,
            free_bytes,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    //! Parts that come twice, too early, or after an interruption.

    use super::*;

    fn offered(bytes: u64) -> ArchiveInfo {
        ArchiveInfo {
            digest: "a".repeat(64),
            version: "1".into(),
            architecture: "x86_64".into(),
            bytes,
            unpacked_bytes: 10,
        }
    }

    #[test]
    fn it_goes_on_where_it_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = Incoming::open(folder.path(), offered(6)).unwrap();
        assert_eq!(first.take(0, b"abc"), Ok(3));
        assert_eq!(first.take(0, b"abc"), Ok(3), "twice");
        assert_eq!(first.take(5, b"f"), Ok(3), "too early");
        assert!(first.whole().is_err());
        drop(first);
        let mut second = Incoming::open(folder.path(), offered(6)).unwrap();
        assert_eq!(second.has_bytes(), 3);
        assert!(matches!(second.take(3, b"defg"), Err(UpgradeRefusal::Damaged { .. })));
        assert_eq!(second.take(3, b"def"), Ok(6));
        assert_eq!(std::fs::read(second.whole().unwrap()).unwrap(), b"abcdef");
    }

    #[test]
    fn another_archive_takes_the_place_of_one_that_did_not_come_whole() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = Incoming::open(folder.path(), offered(6)).unwrap();
        assert_eq!(first.take(0, b"abc"), Ok(3));
        let other = ArchiveInfo {
            digest: "b".repeat(64),
            ..offered(6)
        };
        assert_eq!(Incoming::open(folder.path(), other).unwrap().has_bytes(), 0);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_too_large_or_has_no_digest_is_refused_before_a_byte_comes() {
        let folder = tempfile::tempdir().unwrap();
        let large = Incoming::open(folder.path(), offered(MOST_ARCHIVE_BYTES + 1));
        assert!(matches!(large, Err(UpgradeRefusal::Damaged { .. })));
        let unpacked = ArchiveInfo {
            unpacked_bytes: u64::MAX,
            ..offered(6)
        };
        assert!(matches!(
            Incoming::open(folder.path(), unpacked),
            Err(UpgradeRefusal::NoRoom { .. })
        ));
        let outside = ArchiveInfo {
            digest: "../../escaped".into(),
            ..offered(6)
        };
        assert!(matches!(
            Incoming::open(folder.path(), outside),
            Err(UpgradeRefusal::Damaged { .. })
        ));
    }
}
