//! Why something could not be made of a recording.
//!
//! Must never do: leave out which file it is about.

use skein_recording::ReadError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why something could not be made of a recording.
#[derive(Debug, Error)]
pub enum ExportError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A folder cannot be read.
    #[error("cannot read {path}: {reason}")]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// What was to be made is there.
    #[error("{path} is there already: nothing is written over it")]
    Exists {
        /// What.
        path: PathBuf,
    },
    /// It cannot be written.
    #[error("cannot write {path}: {reason}")]
    Write {
        /// What.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// There is nothing to be cut out.
    #[error("{from_s} s to {until_s} s is no part of it: it is {length_s:.1} s long")]
    NoPart {
        /// From where, in seconds from its beginning.
        from_s: f64,
        /// To where.
        until_s: f64,
        /// How long the recording is.
        length_s: f64,
    },
    /// Several nodes are in one file.
    #[error("{path} was merged of several nodes' recordings; this is for the recording of one node")]
    Merged {
        /// Which file.
        path: PathBuf,
    },
    /// Nothing of this is in it.
    #[error("{path} holds no {what}")]
    Nothing {
        /// Which file.
        path: PathBuf,
        /// What was looked for.
        what: &'static str,
    },
    /// Nothing was given.
    #[error("no recording was named")]
    NoFile,
}

impl ExportError {
    pub(crate) fn write(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::Write {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }
}
