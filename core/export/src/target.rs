//! Files and folders that are made.
//!
//! Must never do: open a file that is there.

use crate::ExportError;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

fn failed(path: &Path, error: &std::io::Error) -> ExportError {
    if error.kind() == ErrorKind::AlreadyExists {
        ExportError::Exists { path: path.to_owned() }
    } else {
        ExportError::write(path, error)
    }
}

/// Makes a file.
pub(crate) fn file(path: &Path) -> Result<BufWriter<File>, ExportError> {
    let made = File::options().read(true).write(true).create_new(true).open(path);
    made.map(BufWriter::new).map_err(|error| failed(path, &error))
}

/// Makes a folder, in which files of these names are to be made.
pub(crate) fn folder(path: &Path) -> Result<PathBuf, ExportError> {
    fs::create_dir(path).map_err(|error| failed(path, &error))?;
    Ok(path.to_owned())
}

/// Makes sure that a file that was written is on its way to the disk.
pub(crate) fn finish(path: &Path, file: BufWriter<File>) -> Result<(), ExportError> {
    let file = file
        .into_inner()
        .map_err(|error| ExportError::write(path, error.error()))?;
    file.sync_data().map_err(|error| ExportError::write(path, error))
}
