//! Values larger than a datagram: packed, in numbered parts at one side, put together at the other.
//!
//! Must never do: hand out a value of which a part is missing or of another revision; grow beyond its bounds.

use minicbor::{Decode, Encode};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::Read;
use thiserror::Error;

/// A value has no more parts than this.
pub const MOST_PARTS: usize = 64;
/// No value is larger than this when it is unpacked: the largest answers of the API, and what stands around them.
pub const LARGEST_BYTES: usize = 9 << 20;

/// One part.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Part {
    /// Of which revision of the value.
    #[n(0)]
    pub revision: u64,
    /// Which part, from 0.
    #[n(1)]
    pub index: u8,
    /// How many there are.
    #[n(2)]
    pub count: u8,
    /// Its bytes.
    #[cbor(n(3), with = "minicbor::bytes")]
    pub bytes: Vec<u8>,
}

/// Why a value can't be told, or not be understood.
#[derive(Debug, Error)]
pub enum PartsError {
    /// It can't be written.
    #[error("cannot be written: {0}")]
    Write(String),
    /// It is too large.
    #[error("{bytes} bytes are more than fit into {MOST_PARTS} parts")]
    TooLarge {
        /// Its size.
        bytes: usize,
    },
    /// Nobody would unpack it.
    #[error("too large: {bytes} bytes, {LARGEST_BYTES} at most")]
    Refused {
        /// Its size.
        bytes: usize,
    },
    /// It is not what it should be.
    #[error("cannot be read: {0}")]
    Read(String),
}

/// A value as bytes, packed.
///
/// # Errors
/// When it can't be written, or is larger than anybody unpacks.
pub fn pack<T: Serialize>(value: &T) -> Result<Vec<u8>, PartsError> {
    let mut plain = Vec::new();
    ciborium::into_writer(value, &mut plain).map_err(|e| PartsError::Write(e.to_string()))?;
    if plain.len() > LARGEST_BYTES {
        return Err(PartsError::Refused { bytes: plain.len() });
    }
    deflated(&plain)
}

fn deflated(plain: &[u8]) -> Result<Vec<u8>, PartsError> {
    let mut packed = Vec::new();
    let mut reader = flate2::read::DeflateEncoder::new(plain, flate2::Compression::fast());
    reader
        .read_to_end(&mut packed)
        .map_err(|e| PartsError::Write(e.to_string()))?;
    Ok(packed)
}

/// A value out of its bytes.
///
/// # Errors
/// When it is not of that type, or larger than any is.
pub fn unpack<T: DeserializeOwned>(packed: &[u8]) -> Result<T, PartsError> {
    let bounded = flate2::read::DeflateDecoder::new(packed).take(LARGEST_BYTES as u64);
    ciborium::from_reader(bounded).map_err(|e| PartsError::Read(e.to_string()))
}

/// Splits a value into parts of so many bytes.
///
/// # Errors
/// When they would be too many.
pub fn split(packed: &[u8], revision: u64, part_bytes: usize) -> Result<Vec<Part>, PartsError> {
    let chunks: Vec<&[u8]> = if packed.is_empty() {
        vec![packed]
    } else {
        packed.chunks(part_bytes.max(1)).collect()
    };
    if chunks.len() > MOST_PARTS {
        return Err(PartsError::TooLarge { bytes: packed.len() });
    }
    let count = chunks.len() as u8;
    let part = |(index, bytes): (usize, &[u8])| Part {
        revision,
        index: index as u8,
        count,
        bytes: bytes.to_vec(),
    };
    Ok(chunks.into_iter().enumerate().map(part).collect())
}

/// Puts the parts of one value together.
#[derive(Debug, Default)]
pub struct Assembly {
    revision: Option<u64>,
    parts: Vec<Option<Vec<u8>>>,
    done: bool,
}

impl Assembly {
    /// Takes a part in; the whole value when it was the last one missing. A part of an older revision is ignored.
    pub fn take(&mut self, part: Part) -> Option<Vec<u8>> {
        let (count, index) = (usize::from(part.count), usize::from(part.index));
        if count == 0 || count > MOST_PARTS || index >= count {
            return None;
        }
        if self.revision.is_some_and(|revision| revision > part.revision) {
            return None;
        }
        if self.revision != Some(part.revision) || self.parts.len() != count {
            self.revision = Some(part.revision);
            self.parts = vec![None; count];
            self.done = false;
        }
        if let Some(place) = self.parts.get_mut(index) {
            *place = Some(part.bytes);
        }
        if self.done || self.parts.iter().any(Option::is_none) {
            return None;
        }
        self.done = true;
        Some(self.parts.iter().flatten().flatten().copied().collect())
    }
}

#[cfg(test)]
mod tests;
