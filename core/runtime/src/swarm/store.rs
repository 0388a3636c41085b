//! Which term this node obeys, kept over a restart: a node that forgot it could obey a coordinator that was replaced.
//!
//! Must never do: leave a file half written; go on with one that cannot be read, as if there were none.

use skein_failover::Term;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why the term is not known or not kept.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The file cannot be read.
    #[error("{path}: {source}; it holds which coordinator this node obeys", path = path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("{path} cannot be written: {source}; it holds which coordinator this node obeys", path = path.display())]
    Unwritable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// The file, and what is in it.
#[derive(Debug)]
pub struct TermStore {
    path: Option<PathBuf>,
    kept: Option<Term>,
}

impl TermStore {
    /// In this file; without one nothing is kept.
    #[must_use]
    pub fn open(path: Option<PathBuf>) -> Self {
        Self { path, kept: None }
    }

    /// What was kept.
    ///
    /// # Errors
    /// When there is a file that cannot be read or understood.
    pub fn load(&self) -> Result<Option<Term>, StoreError> {
        let Some(path) = &self.path else { return Ok(None) };
        let unreadable = |source| StoreError::Unreadable {
            path: path.clone(),
            source,
        };
        match std::fs::read(path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(|e| unreadable(e.into())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(unreadable(error)),
        }
    }

    /// Keeps a term, if it is another than before. Returns when it is on the disk.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&mut self, term: Option<Term>) -> Result<(), StoreError> {
        if term == self.kept {
            return Ok(());
        }
        if let (Some(path), Some(term)) = (&self.path, term) {
            write(path, term).map_err(|source| StoreError::Unwritable {
                path: path.clone(),
                source,
            })?;
        }
        self.kept = term;
        Ok(())
    }
}

/// Beside the old one, then in its place: whoever reads finds one or the other.
fn write(path: &Path, term: Term) -> io::Result<()> {
    let beside = path.with_extension("new");
    let mut file = File::create(&beside)?;
    file.write_all(&serde_json::to_vec(&term)?)?;
    file.sync_all()?;
    std::fs::rename(&beside, path)?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
