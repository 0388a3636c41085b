//! Samples to messages and back: plain CDR, in either order of bytes.
//!
//! Must never do: read a sample whose length is not exactly that of the message; panic, whatever the bytes are.

use crate::messages::{Message, size_bytes};
use byteorder::{BigEndian, LittleEndian};
use thiserror::Error;

/// How a sample is encoded, as its first two octets say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Plain CDR, least significant octet first: what PX4 and everything on ROS 2 sends.
    LittleEndian,
    /// Plain CDR, most significant octet first.
    BigEndian,
    /// Something else, by its number.
    Other(u16),
}

impl Encoding {
    /// Of the number in front of a sample.
    #[must_use]
    pub fn of(number: u16) -> Self {
        match number {
            0 => Self::BigEndian,
            1 => Self::LittleEndian,
            other => Self::Other(other),
        }
    }
}

/// Why a sample is not the message that it was taken for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CdrError {
    /// It is not encoded as plain CDR.
    #[error("it is encoded as 0x{0:04x}, which is not plain CDR")]
    Encoding(u16),
    /// It is shorter or longer than the message.
    #[error("it has {got} octets where {expected} are expected")]
    Size {
        /// Octets of the sample.
        got: usize,
        /// Octets of the message.
        expected: usize,
    },
    /// A field holds what its type cannot.
    #[error("a field does not fit its type: {0}")]
    Field(String),
}

/// What a message is rounded up to on the wire.
const PADDED_TO: usize = 4;

/// Whether a sample of so many octets can be a message of so many: it may be padded at its end.
#[must_use]
pub fn fits(sample_bytes: usize, message_bytes: usize) -> bool {
    sample_bytes == message_bytes || sample_bytes == message_bytes.div_ceil(PADDED_TO) * PADDED_TO
}

/// Reads a message.
///
/// # Errors
/// If it is none of this kind.
pub fn decode<M: Message>(encoding: Encoding, bytes: &[u8]) -> Result<M, CdrError> {
    let expected = size_bytes(M::FIELDS);
    if let Encoding::Other(number) = encoding {
        return Err(CdrError::Encoding(number));
    }
    if !fits(bytes.len(), expected) {
        let got = bytes.len();
        return Err(CdrError::Size { got, expected });
    }
    let read = match encoding {
        Encoding::BigEndian => cdr_encoding::from_bytes::<M, BigEndian>(bytes),
        _ => cdr_encoding::from_bytes::<M, LittleEndian>(bytes),
    };
    let (message, consumed) = read.map_err(|error| CdrError::Field(error.to_string()))?;
    if consumed == expected {
        Ok(message)
    } else {
        let got = consumed;
        Err(CdrError::Size { got, expected })
    }
}

/// Writes a message, least significant octet first.
///
/// # Errors
/// Never for a message of this crate: all their types can be written.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, CdrError> {
    let written = cdr_encoding::to_vec_with_size_hint::<M, LittleEndian>(message, size_bytes(M::FIELDS));
    written.map_err(|error| CdrError::Field(error.to_string()))
}
