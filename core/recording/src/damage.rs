//! What may be wrong with a file: why it cannot be opened at all, and what of it cannot be read.
//!
//! Must never do: leave the reader of a message without what to do, where something can be done.

use std::path::PathBuf;
use thiserror::Error;

/// Why a file is no recording that can be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// It cannot be read at all.
    #[error("cannot read {path}: {why}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why. Not called its source: who prints an error with all its causes would say it twice.
        why: std::io::Error,
    },
    /// It is something else.
    #[error("{path} is no MCAP file: it begins otherwise")]
    NotMcap {
        /// Which file.
        path: PathBuf,
    },
    /// It ends before anything was recorded.
    #[error("{path} is an MCAP file that ends before its first message")]
    Empty {
        /// Which file.
        path: PathBuf,
    },
    /// It has no metadata of ours.
    #[error("{path} is an MCAP file of another program ({library})")]
    NotOurs {
        /// Which file.
        path: PathBuf,
        /// Who wrote it, as it says.
        library: String,
    },
    /// It was written by a later version.
    #[error(
        "{path} has version {format} of the format of recordings, this program reads up to {}: use a newer one",
        crate::FORMAT
    )]
    Later {
        /// Which file.
        path: PathBuf,
        /// Its version.
        format: u32,
    },
}

/// What is wrong with a part of a file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Damage {
    /// It ends in the middle of a record, as when the program was killed while it wrote.
    #[error("it ends in the middle of a record: the program ended while it was written")]
    Cut,
    /// A chunk is not what its checksum says.
    #[error("a chunk is not what its checksum says")]
    Checksum,
    /// A chunk cannot be unpacked.
    #[error("a chunk cannot be unpacked")]
    Unpackable,
    /// A chunk would be larger than anything that is recorded.
    #[error("a chunk would be {bytes} bytes when it is unpacked")]
    TooLarge {
        /// How large.
        bytes: u64,
    },
    /// It is packed in a way that is not known here.
    #[error("a chunk is packed with {name}, which is not read here: `mcap compress --compression zstd` packs it anew")]
    Compression {
        /// How.
        name: String,
    },
    /// A record is none.
    #[error("a record is damaged")]
    Record,
    /// The disk.
    #[error("it cannot be read: {0}")]
    Io(String),
}
