//! What an archive says of itself: version, processor, and each file with its size and digest.
//!
//! Must never do: let a path through that leads anywhere but to the program or to a plugin.

use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use thiserror::Error;

/// Its name in an archive, and in the folder of an unpacked version.
pub const FILE_NAME: &str = "manifest.json";
/// The program's name.
pub const PROGRAM: &str = "skein";
/// The folder of plugins.
pub const PLUGINS: &str = "plugins";
/// The shape of archives that this program makes and reads.
const FORMAT: u32 = 1;
/// No manifest is longer, in bytes.
pub const MOST_BYTES: u64 = 64 << 10;
/// What is in an archive is no larger than this altogether, in bytes.
pub const MOST_UNPACKED_BYTES: u64 = 1 << 30;
const MOST_FILES: usize = 256;
const LONGEST_VERSION: usize = 48;
const LONGEST_NAME: usize = 90;

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedFile {
    /// `skein`, or `plugins/NAME`.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
}

/// The manifest of an archive.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// The shape of the archive.
    pub format: u32,
    /// The version, as whoever packed it calls it.
    pub version: String,
    /// For which processor, as `x86_64` or `aarch64`.
    pub architecture: String,
    /// The files, in the order in which they come.
    pub files: Vec<PackedFile>,
}

/// What is wrong with a manifest.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ManifestError {
    /// It is no manifest.
    #[error("its manifest cannot be read: {0}")]
    Unreadable(String),
    /// It is of a later program.
    #[error("its format is {is}, this program reads {FORMAT}: upgrade by the package")]
    Format {
        /// Which it is.
        is: u32,
    },
    /// The version cannot be part of a folder's name.
    #[error(
        "the version {0:?} is not made of up to {LONGEST_VERSION} letters, digits, dots, +, - and ~, a letter or digit first"
    )]
    Version(String),
    /// A path leads elsewhere.
    #[error("the path {0:?} is neither {PROGRAM} nor {PLUGINS}/NAME")]
    Path(String),
    /// A path is there twice.
    #[error("{0} is there twice")]
    Twice(String),
    /// There is no program.
    #[error("there is no program in it")]
    NoProgram,
    /// Too many files.
    #[error("{0} files are more than {MOST_FILES}")]
    TooMany(usize),
    /// Too large.
    #[error("{0} bytes are more than {MOST_UNPACKED_BYTES}")]
    TooLarge(u64),
}

impl Manifest {
    /// Of these files.
    ///
    /// # Errors
    /// When they make no archive.
    pub fn new(version: String, architecture: String, files: Vec<PackedFile>) -> Result<Self, ManifestError> {
        let manifest = Self {
            format: FORMAT,
            version,
            architecture,
            files,
        };
        manifest.checked()
    }

    /// Out of its bytes.
    ///
    /// # Errors
    /// When they are none, or a file would lie where none may.
    pub fn read(bytes: &[u8]) -> Result<Self, ManifestError> {
        let manifest: Self = serde_json::from_slice(bytes).map_err(|e| ManifestError::Unreadable(e.to_string()))?;
        manifest.checked()
    }

    fn checked(self) -> Result<Self, ManifestError> {
        if self.format != FORMAT {
            return Err(ManifestError::Format { is: self.format });
        }
        if !is_version(&self.version) {
            return Err(ManifestError::Version(self.version));
        }
        if self.files.len() > MOST_FILES {
            return Err(ManifestError::TooMany(self.files.len()));
        }
        let mut paths = BTreeSet::new();
        for file in &self.files {
            if !is_path(&file.path) {
                return Err(ManifestError::Path(file.path.clone()));
            }
            if !paths.insert(&file.path) {
                return Err(ManifestError::Twice(file.path.clone()));
            }
        }
        if !self.files.iter().any(|file| file.path == PROGRAM) {
            return Err(ManifestError::NoProgram);
        }
        let bytes = self.unpacked_bytes();
        if bytes > MOST_UNPACKED_BYTES {
            return Err(ManifestError::TooLarge(bytes));
        }
        Ok(self)
    }

    /// The size of all files.
    #[must_use]
    pub fn unpacked_bytes(&self) -> u64 {
        self.files.iter().fold(0, |sum, file| sum.saturating_add(file.bytes))
    }
}

/// Part of a folder's name, and of a sentence for a person.
fn is_version(text: &str) -> bool {
    let first = text.chars().next().is_some_and(|c| c.is_ascii_alphanumeric());
    let all = text.chars().all(|c| c.is_ascii_alphanumeric() || ".+-~".contains(c));
    first && all && text.len() <= LONGEST_VERSION
}

fn is_path(path: &str) -> bool {
    if path == PROGRAM {
        return true;
    }
    let name = path.strip_prefix(PLUGINS).and_then(|rest| rest.strip_prefix('/'));
    name.is_some_and(|name| {
        let first = name.chars().next().is_some_and(|c| c.is_ascii_alphanumeric());
        let all = name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
        first && all && name.len() <= LONGEST_NAME
    })
}

#[cfg(test)]
mod tests {
    //! Whatever a manifest names lies in the version's own folder.

    use super::*;
    use proptest::prelude::*;
    use std::path::{Component, Path};

    fn file(path: &str) -> PackedFile {
        PackedFile {
            path: path.into(),
            bytes: 1,
            sha256: String::new(),
        }
    }

    #[test]
    fn a_path_that_leads_out_is_refused() {
        for path in [
            "../skein",
            "/skein",
            "plugins/../../x",
            "plugins//x",
            "plugins/",
            "plugins/.x",
            "plugins/a/b",
            "manifest.json",
            "skein/",
            "./skein",
            "plugins/a\0b",
            "",
        ] {
            let made = Manifest::new("1".into(), "x86_64".into(), vec![file(PROGRAM), file(path)]);
            assert_eq!(made, Err(ManifestError::Path(path.into())));
        }
    }

    #[test]
    fn what_makes_no_archive_is_named() {
        let made = |version: &str, files: Vec<PackedFile>| Manifest::new(version.into(), "x86_64".into(), files);
        assert!(
            made(
                "0.2.0-rc.1+g12",
                vec![file(PROGRAM), file("plugins/libgimbal_plugin.so")]
            )
            .is_ok()
        );
        assert_eq!(made("1", vec![]), Err(ManifestError::NoProgram));
        assert!(matches!(
            made("1", vec![file(PROGRAM), file(PROGRAM)]),
            Err(ManifestError::Twice(_))
        ));
        for version in ["", "../1", ".1", "1/2", "1 2", &"1".repeat(49)] {
            assert!(
                matches!(made(version, vec![file(PROGRAM)]), Err(ManifestError::Version(_))),
                "{version}"
            );
        }
        let large = PackedFile {
            bytes: u64::MAX,
            ..file("plugins/a.so")
        };
        assert!(matches!(
            made("1", vec![file(PROGRAM), large]),
            Err(ManifestError::TooLarge(_))
        ));
        let later = br#"{"format": 2, "version": "1", "architecture": "x86_64", "files": []}"#;
        assert_eq!(Manifest::read(later), Err(ManifestError::Format { is: 2 }));
        assert!(matches!(Manifest::read(b"{"), Err(ManifestError::Unreadable(_))));
    }

    proptest! {
        #[test]
        fn whatever_is_named_stays_inside(path in "(plugins/)?[-a-zA-Z0-9._/\\\\~ ]{0,40}") {
            if let Ok(manifest) = Manifest::new("1".into(), "x86_64".into(), vec![file(PROGRAM), file(&path)]) {
                for file in manifest.files {
                    let parts: Vec<Component<'_>> = Path::new(&file.path).components().collect();
                    prop_assert!(parts.len() <= 2 && parts.iter().all(|part| matches!(part, Component::Normal(_))));
                }
            }
        }
    }
}
