//! What a plugin keeps over a restart, with a version in front: how it becomes bytes, and how it comes back.
//!
//! Must never do: give back half of a state. What cannot be read whole is an error that says why, and the plugin starts anew.

use minicbor::{Decode, Decoder, Encode, Encoder};
use thiserror::Error;

/// Why saved bytes are of no use.
#[derive(Debug, Error)]
pub enum Unreadable {
    /// They were saved by a version whose states mean something else.
    #[error("version {found}, not {wanted}")]
    Version {
        /// The version they are of.
        found: u32,
        /// The version that was asked for.
        wanted: u32,
    },
    /// They are no saved state, or are cut off.
    #[error("not decodable: {0}")]
    Damaged(#[from] minicbor::decode::Error),
}

/// The bytes of `state`. `version` changes when an older state would be misunderstood; fields that are only added keep it.
pub fn encode<T: Encode<()>>(version: u32, state: &T) -> Vec<u8> {
    let mut encoder = Encoder::new(Vec::new());
    let encoded = encoder
        .array(2)
        .and_then(|e| e.u32(version))
        .and_then(|e| e.encode(state))
        .is_ok();
    // Writing into a vector does not fail; if it did, no snapshot would be better than half of one.
    if encoded { encoder.into_writer() } else { Vec::new() }
}

/// The state in these bytes.
///
/// # Errors
///
/// They are of another version than `wanted`, or no saved state.
pub fn decode<T: for<'b> Decode<'b, ()>>(wanted: u32, bytes: &[u8]) -> Result<T, Unreadable> {
    let mut decoder = Decoder::new(bytes);
    decoder.array()?;
    let found = decoder.u32()?;
    if found != wanted {
        return Err(Unreadable::Version { found, wanted });
    }
    Ok(decoder.decode()?)
}

/// The state of the incarnation before, if there was one and it can be read. One that cannot is told in the log.
pub fn restored<T: for<'b> Decode<'b, ()>>(wanted: u32, snapshot: Option<&[u8]>) -> Option<T> {
    let restored = decode(wanted, snapshot?);
    restored
        .inspect_err(|error| crate::log::warn!("starts anew, the snapshot cannot be read: {error}"))
        .ok()
}

#[cfg(test)]
mod tests;
