//! Records of an MCAP file, one after the other, from bytes that may be anything.
//!
//! Must never do: trust a length that a file gives before it is held against what is there.

use crate::damage::Damage;
use mcap::records::{ChunkHeader, Record};
use std::borrow::Cow;

/// A chunk is never larger than this when it is unpacked, in bytes; ours are a thousandth of it.
const LARGEST_CHUNK: usize = 256 << 20;
/// Opcode and length before each record.
pub const HEAD: usize = 9;

/// The opcode and the length of the record that begins here.
#[must_use]
pub fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let (head, _) = bytes.split_first_chunk::<HEAD>()?;
    let [opcode, length @ ..] = *head;
    Some((opcode, u64::from_le_bytes(length)))
}

/// What is in a chunk, unpacked and checked.
///
/// # Errors
/// What is wrong with it.
pub fn unpacked<'a>(header: &ChunkHeader, packed: &'a [u8]) -> Result<Cow<'a, [u8]>, Damage> {
    let size = usize::try_from(header.uncompressed_size).unwrap_or(usize::MAX);
    if size > LARGEST_CHUNK {
        return Err(Damage::TooLarge {
            bytes: header.uncompressed_size,
        });
    }
    let unpacked = match header.compression.as_str() {
        "" => Cow::Borrowed(packed),
        "zstd" => Cow::Owned(zstd::bulk::decompress(packed, size).map_err(|_| Damage::Unpackable)?),
        other => {
            return Err(Damage::Compression {
                name: other.chars().take(32).collect(),
            });
        }
    };
    let is_checked = header.uncompressed_crc != 0;
    if unpacked.len() != size || is_checked && crc32fast::hash(&unpacked) != header.uncompressed_crc {
        return Err(Damage::Checksum);
    }
    Ok(unpacked)
}

/// The records in these bytes.
pub struct Records<'a> {
    rest: &'a [u8],
}

impl<'a> Records<'a> {
    #[must_use]
    pub fn of(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let record = head(self.rest).and_then(|(opcode, length)| {
            let end = HEAD.checked_add(usize::try_from(length).ok()?)?;
            let body = self.rest.get(HEAD..end)?;
            self.rest = self.rest.get(end..)?;
            crate::lengths::fit(opcode, body).then(|| mcap::parse_record(opcode, body).ok())?
        });
        if record.is_none() {
            self.rest = &[];
        }
        Some(record.ok_or(Damage::Record))
    }
}
