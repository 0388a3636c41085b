//! Small files that are replaced as a whole: whoever reads finds the old one or the new one.
//!
//! Must never do: run where something waits for it in flight; it returns when the disk has written.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Writes beside the old file, then puts it in that one's place.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = path.with_extension("new");
    let mut file = File::create(&beside)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(&beside, path)?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}
