//! One value of a node, and its name.
//!
//! Must never do: say what a value means.

use minicbor::{Decode, Encode};

/// Names one value of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode)]
#[cbor(transparent)]
pub struct Key(#[n(0)] pub u32);

/// One value on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Entry {
    /// Which.
    #[n(0)]
    pub key: Key,
    /// Counts from 1 per run of the sender, over all keys: one that is told again after it was given up is newer than before.
    #[n(1)]
    pub version: u64,
    /// The value.
    #[cbor(n(2), with = "minicbor::bytes")]
    pub value: Vec<u8>,
}
