//! What the messages between this process and a child mean.

use super::wire::{Head, kind};
use crate::PluginError;
use minicbor::{Decode, Encode};

/// What a child needs to know before it makes its instance.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Settings {
    /// Address space in bytes beyond what the bare process has.
    #[n(0)]
    pub(crate) memory_bytes: u64,
    /// Open files.
    #[n(1)]
    pub(crate) open_files: u64,
    /// Longest answer in bytes.
    #[n(2)]
    pub(crate) max_answer_bytes: u64,
    /// Longest snapshot in bytes.
    #[n(3)]
    pub(crate) max_snapshot_bytes: u64,
    /// Whether the memory for frames is among the files.
    #[n(4)]
    pub(crate) lends_frames: bool,
}

/// Where a frame can be found that is to be read during a call; its file goes with the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FramePlace {
    pub(crate) id: u64,
    pub(crate) offset: u64,
    pub(crate) len: u64,
}

impl FramePlace {
    /// Length of its encoding in bytes.
    pub(crate) const BYTES: usize = 24;

    pub(crate) fn encode(self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        for (to, number) in bytes.chunks_exact_mut(8).zip([self.id, self.offset, self.len]) {
            to.copy_from_slice(&number.to_ne_bytes());
        }
        bytes
    }

    pub(crate) fn decode(bytes: &[u8; Self::BYTES]) -> Self {
        let mut numbers = bytes
            .chunks_exact(8)
            .map(|eight| eight.try_into().map_or(0, u64::from_ne_bytes));
        let mut number = || numbers.next().unwrap_or(0);
        Self {
            id: number(),
            offset: number(),
            len: number(),
        }
    }
}

/// Codes of errors in [`kind::FAILED`].
mod code {
    pub(super) const PANICKED: u32 = 1;
    pub(super) const REFUSED: u32 = 2;
    pub(super) const NOT_UNDERSTOOD: u32 = 3;
    pub(super) const UNDECODABLE: u32 = 4;
    pub(super) const TOO_LARGE: u32 = 5;
    pub(super) const NOT_STARTED: u32 = 6;
}

/// Longest text of an error in bytes.
pub(crate) const MAX_ERROR_BYTES: usize = 4_000;

/// An error as it crosses.
pub(crate) fn encode_error(error: &PluginError) -> (Head, Vec<u8>) {
    let (code, text, lens) = match error {
        PluginError::Panicked { message } => (code::PANICKED, message.clone(), (0, 0)),
        PluginError::Refused { detail } => (code::REFUSED, detail.clone(), (0, 0)),
        PluginError::NotUnderstood { detail } => (code::NOT_UNDERSTOOD, detail.clone(), (0, 0)),
        PluginError::Undecodable { detail } => (code::UNDECODABLE, detail.clone(), (0, 0)),
        PluginError::TooLarge { len, limit } => (code::TOO_LARGE, String::new(), (*len, *limit)),
        other => (code::NOT_STARTED, other.to_string(), (0, 0)),
    };
    let mut body = text.into_bytes();
    body.truncate(MAX_ERROR_BYTES);
    let number = |len: usize| u32::try_from(len).unwrap_or(u32::MAX);
    let head = Head {
        kind: kind::FAILED,
        numbers: [code, number(lens.0), number(lens.1), 0],
    };
    (head, body)
}

/// The error that a child tells of.
pub(crate) fn decode_error(head: Head, body: &[u8]) -> PluginError {
    let [code, len, limit, _] = head.numbers;
    let detail = String::from_utf8_lossy(body).into_owned();
    match code {
        code::PANICKED => PluginError::Panicked { message: detail },
        code::REFUSED => PluginError::Refused { detail },
        code::NOT_UNDERSTOOD => PluginError::NotUnderstood { detail },
        code::UNDECODABLE => PluginError::Undecodable { detail },
        code::TOO_LARGE => PluginError::TooLarge {
            len: len as usize,
            limit: limit as usize,
        },
        code::NOT_STARTED => PluginError::NotStarted { detail },
        other => PluginError::Protocol {
            detail: format!("an error with the code {other}"),
        },
    }
}

#[cfg(test)]
mod tests;
