//! How much room a disk has.
//!
//! Must never do: wait for a disk that does not answer anywhere but on the recorder's thread.

use std::path::Path;

/// A recording leaves so much of a disk to others, in bytes, or of a small one this share.
const LEFT_FREE_BYTES: u64 = 64 << 20;
const LEFT_FREE_SHARE: u64 = 20;

/// Room on a disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// Free for this program, in bytes.
    pub free_bytes: u64,
    /// How much a recording leaves, in bytes.
    pub floor_bytes: u64,
}

impl Room {
    /// On the disk that a folder is on.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn of(folder: &Path) -> std::io::Result<Self> {
        let stat = rustix::fs::statvfs(folder)?;
        let size = stat.f_blocks.saturating_mul(stat.f_frsize);
        Ok(Self {
            free_bytes: stat.f_bavail.saturating_mul(stat.f_frsize),
            floor_bytes: LEFT_FREE_BYTES.min(size / LEFT_FREE_SHARE),
        })
    }

    /// There is room for what is recorded in a while.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.free_bytes > self.floor_bytes
    }

    /// There is room for a new file, with some to spare.
    #[must_use]
    pub fn is_enough_to_begin(&self) -> bool {
        self.free_bytes > self.floor_bytes + self.floor_bytes / 4
    }
}
