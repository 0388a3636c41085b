//! Which term this node obeys, kept over a restart: a node that forgot it could obey a coordinator that was replaced.
//!
//! Must never do: leave a file half written; go on with one that cannot be read, as if there were none.

use skein_failover::Term;
use skein_state::whole_file;
use std::io;
use std::path::PathBuf;
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
            let written = serde_json::to_vec(&term)
                .map_err(io::Error::from)
                .and_then(|bytes| whole_file::replace(path, &bytes));
            written.map_err(|source| StoreError::Unwritable {
                path: path.clone(),
                source,
            })?;
        }
        self.kept = term;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
