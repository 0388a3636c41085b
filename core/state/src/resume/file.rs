//! The file that holds what is flown: one line that says what it is, then the rest as JSON. Anything that is not exactly what this program
//! wrote is told and not used.
//!
//! Must never do: panic on, or half believe, what it reads.

use super::Kept;
use std::io::Read;
use std::path::Path;
use thiserror::Error;

/// Of the file. Changes when an older one would be misunderstood.
const VERSION: u32 = 1;
const NAME: &str = "skein-resume";
/// A larger one is not written, and not read, in bytes.
const LARGEST_BYTES: usize = 1 << 20;

/// Why a file is of no use.
#[derive(Debug, Error)]
pub enum FileFault {
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// It, or what is to be written, is larger than it may be.
    #[error("more than {LARGEST_BYTES} bytes")]
    TooLarge,
    /// It is something else.
    #[error("it is no file of this kind")]
    Foreign,
    /// Another version of the program wrote it.
    #[error("it is of version {0}, and {VERSION} is understood here")]
    Version(u32),
    /// It is damaged.
    #[error("it is damaged: its checksum is wrong")]
    Damaged,
    /// What it says cannot be understood.
    #[error("it cannot be understood: {0}")]
    Meaningless(#[from] serde_json::Error),
}

/// The whole file.
pub fn encode(kept: &Kept) -> Result<Vec<u8>, FileFault> {
    let body = serde_json::to_vec(kept)?;
    let mut bytes = format!("{NAME} {VERSION} {:08x}\n", crc32fast::hash(&body)).into_bytes();
    bytes.extend(body);
    (bytes.len() <= LARGEST_BYTES)
        .then_some(bytes)
        .ok_or(FileFault::TooLarge)
}

/// What a file says.
pub fn decode(bytes: &[u8]) -> Result<Kept, FileFault> {
    let end = bytes
        .iter()
        .take(64)
        .position(|b| *b == b'\n')
        .ok_or(FileFault::Foreign)?;
    let (head, body) = bytes.split_at(end);
    let body = body.get(1..).unwrap_or_default();
    let head = std::str::from_utf8(head).map_err(|_| FileFault::Foreign)?;
    let mut words = head.split(' ');
    if words.next() != Some(NAME) {
        return Err(FileFault::Foreign);
    }
    let version: u32 = words.next().and_then(|w| w.parse().ok()).ok_or(FileFault::Foreign)?;
    if version != VERSION {
        return Err(FileFault::Version(version));
    }
    let checksum = words.next().and_then(|word| u32::from_str_radix(word, 16).ok());
    if checksum != Some(crc32fast::hash(body)) {
        return Err(FileFault::Damaged);
    }
    Ok(serde_json::from_slice(body)?)
}

/// Reads it; nothing if there is none.
pub fn read(path: &Path) -> Result<Option<Kept>, FileFault> {
    let file = match std::fs::File::open(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        other => other?,
    };
    let mut bytes = Vec::new();
    file.take(LARGEST_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > LARGEST_BYTES {
        return Err(FileFault::TooLarge);
    }
    decode(&bytes).map(Some)
}

#[cfg(test)]
mod tests;
