//! What a node keeps on its disk: a folder for each version, and one small file that says which is which.
//!
//! Must never do: leave the file half written; remove a version that may be started.

use crate::archive::{self, ArchiveError};
use crate::rules::{Version, Versions};
use skein_state::whole_file;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The folder under the node's state folder.
const FOLDER: &str = "versions";
/// The file in it.
const FILE: &str = "versions.json";
/// Where an archive comes in.
const INCOMING: &str = "incoming";
/// Where it is unpacked, until that is done.
const UNPACKING: &str = "unpacking";
/// So much of a digest is part of a folder's name.
const DIGEST_PART: usize = 12;

/// Why the versions are not known or not changed.
#[derive(Debug, Error)]
pub enum SlotsError {
    /// The file cannot be read.
    #[error("{path}: {source}; it holds which version this node starts", path = path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something cannot be written.
    #[error("{path} cannot be written: {source}", path = path.display())]
    Unwritable {
        /// What.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The archive is not taken.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
}

/// The versions of one node.
#[derive(Debug, Clone)]
pub struct Slots {
    folder: PathBuf,
}

impl Slots {
    /// Under this state folder.
    #[must_use]
    pub fn under(state: &Path) -> Self {
        Self {
            folder: state.join(FOLDER),
        }
    }

    /// Where archives come in.
    #[must_use]
    pub fn incoming(&self) -> PathBuf {
        self.folder.join(INCOMING)
    }

    fn file(&self) -> PathBuf {
        self.folder.join(FILE)
    }

    /// What is kept; nothing where nobody ever wanted another version than the package.
    ///
    /// # Errors
    /// When the file is there and cannot be understood.
    pub fn load(&self) -> Result<Option<Versions>, SlotsError> {
        let path = self.file();
        let read = match std::fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(io::Error::from),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => Err(error),
        };
        read.map(Some).map_err(|source| SlotsError::Unreadable { path, source })
    }

    /// Returns when it is on the disk.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, versions: &Versions) -> Result<(), SlotsError> {
        let path = self.file();
        let written = serde_json::to_vec_pretty(versions)
            .map_err(io::Error::from)
            .and_then(|bytes| {
                std::fs::create_dir_all(&self.folder)?;
                whole_file::replace(&path, &bytes)
            });
        written.map_err(|source| SlotsError::Unwritable { path, source })
    }

    /// Changes what is kept.
    ///
    /// # Errors
    /// When it cannot be read or written; nothing is changed then.
    pub fn change<T>(&self, change: impl FnOnce(&mut Versions) -> T) -> Result<T, SlotsError> {
        let mut versions = self.load()?.unwrap_or_default();
        let outcome = change(&mut versions);
        self.save(&versions)?;
        Ok(outcome)
    }

    /// The folder of an unpacked version; none for the package.
    #[must_use]
    pub fn folder_of(&self, version: &Version) -> Option<PathBuf> {
        match version {
            Version::Package => None,
            Version::Slot { version, digest } => {
                let part = digest.get(..DIGEST_PART).unwrap_or(digest);
                Some(self.folder.join(format!("{version}-{part}")))
            }
        }
    }

    /// Whether a version can be started.
    #[must_use]
    pub fn has(&self, version: &Version) -> bool {
        let program = self
            .folder_of(version)
            .map(|folder| folder.join(crate::manifest::PROGRAM));
        program.is_none_or(|program| program.is_file())
    }

    /// The unpacked version of an archive.
    #[must_use]
    pub fn find(&self, digest: &str) -> Option<Version> {
        let part = digest.get(..DIGEST_PART)?;
        let there = std::fs::read_dir(&self.folder).ok()?.flatten();
        let names = there.filter_map(|entry| entry.file_name().into_string().ok());
        let version = names.filter_map(|name| name.strip_suffix(part)?.strip_suffix('-').map(str::to_owned));
        let mut slots = version.map(|version| Version::Slot {
            version,
            digest: digest.to_owned(),
        });
        slots.find(|slot| self.has(slot))
    }

    /// Unpacks an archive, whose digest has been compared, into a folder of its own. Versions that are not to stay make room.
    ///
    /// # Errors
    /// When it is damaged, or the disk fails; nothing is left of it then.
    pub fn unpack(&self, archive: &Path, digest: &str, keep: &Versions) -> Result<Version, SlotsError> {
        self.remove_all_but(keep);
        let unpacking = self.folder.join(UNPACKING);
        let failed = |source| SlotsError::Unwritable {
            path: unpacking.clone(),
            source,
        };
        remove(&unpacking).map_err(failed)?;
        std::fs::create_dir_all(&unpacking).map_err(failed)?;
        let outcome = archive::unpack(archive, &unpacking);
        let manifest = outcome.inspect_err(|_| drop(remove(&unpacking)))?;
        let version = Version::Slot {
            version: manifest.version,
            digest: digest.to_owned(),
        };
        if let Some(folder) = self.folder_of(&version) {
            let moved = remove(&folder)
                .and_then(|()| std::fs::rename(&unpacking, &folder))
                .and_then(|()| std::fs::File::open(&self.folder)?.sync_all());
            moved.map_err(failed)?;
        }
        Ok(version)
    }

    /// Removes the folders of versions that are not to stay. What cannot be removed is tried again with the next version.
    fn remove_all_but(&self, keep: &Versions) {
        let mut stay: Vec<PathBuf> = keep.kept().filter_map(|version| self.folder_of(version)).collect();
        stay.push(self.incoming());
        let there = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for path in there.map(|entry| entry.path()) {
            if path.is_dir() && !stay.contains(&path) {
                let _ = remove(&path);
            }
        }
    }
}

fn remove(folder: &Path) -> io::Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    //! What is kept, what is removed, and what a file that cannot be read means.

    use super::*;
    use crate::archive::tests::archive;
    use crate::rules::Expectations;

    #[test]
    fn a_version_that_may_be_started_is_never_removed() {
        let state = tempfile::tempdir().unwrap();
        let slots = Slots::under(state.path());
        let mut versions = Versions::default();
        let mut unpacked = Vec::new();
        for number in 0..4 {
            let (_built, path, info) = archive("x86_64", &format!("0.{number}.0"));
            let version = slots.unpack(&path, &info.digest, &versions).unwrap();
            assert!(slots.has(&version));
            assert!(versions.kept().all(|kept| slots.has(kept)), "{versions:?}");
            assert!(versions.try_next(version.clone(), Expectations::default()));
            versions.confirm();
            slots.save(&versions).unwrap();
            assert_eq!(slots.load().unwrap(), Some(versions.clone()));
            unpacked.push(version);
        }
        // The newest, the one before; what is older went when there was something newer to unpack.
        let there: Vec<bool> = unpacked.iter().map(|version| slots.has(version)).collect();
        assert_eq!(there, [false, true, true, true]);
    }

    #[test]
    fn nothing_is_left_of_an_archive_that_is_damaged() {
        let state = tempfile::tempdir().unwrap();
        let slots = Slots::under(state.path());
        let (_built, path, info) = archive("x86_64", "1");
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() / 2);
        std::fs::write(&path, bytes).unwrap();
        assert!(slots.unpack(&path, &info.digest, &Versions::default()).is_err());
        assert_eq!(std::fs::read_dir(state.path().join(FOLDER)).unwrap().count(), 0);
    }

    #[test]
    fn a_file_that_cannot_be_read_is_no_empty_one() {
        let state = tempfile::tempdir().unwrap();
        let slots = Slots::under(state.path());
        assert_eq!(slots.load().unwrap(), None);
        slots.save(&Versions::default()).unwrap();
        std::fs::write(state.path().join(FOLDER).join(FILE), "{").unwrap();
        assert!(matches!(slots.load(), Err(SlotsError::Unreadable { .. })));
        assert!(slots.change(Versions::confirm).is_err());
    }
}
