//! Frames of SIYI's gimbal protocol: making them, and finding them in a stream of bytes.
//!
//! `55 66`, control (1: asks for an answer, 2: is one), length of the data, sequence, command, data, CRC-16/XMODEM; numbers little-endian.

use crc::{CRC_16_XMODEM, Crc};

const START: [u8; 2] = [0x55, 0x66];
/// Bytes before the data.
const HEAD_LEN: usize = 8;
const CRC_LEN: usize = 2;
/// Longest data that is believed. The protocol's longest message for a gimbal has under 50 bytes.
const LONGEST_DATA: usize = 256;
const ASKS_FOR_AN_ANSWER: u8 = 1;
const CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_XMODEM);

/// Command numbers.
pub(crate) mod command {
    pub(crate) const FIRMWARE: u8 = 0x01;
    pub(crate) const HARDWARE: u8 = 0x02;
    pub(crate) const RATES: u8 = 0x07;
    pub(crate) const CENTRE: u8 = 0x08;
    pub(crate) const CONFIGURATION: u8 = 0x0a;
    /// Pictures, recording and the gimbal's own modes.
    pub(crate) const FUNCTION: u8 = 0x0c;
    pub(crate) const ATTITUDE: u8 = 0x0d;
    pub(crate) const ANGLES: u8 = 0x0e;
    pub(crate) const STREAM: u8 = 0x25;
}

/// What a frame carries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Frame {
    pub(crate) command: u8,
    pub(crate) data: Vec<u8>,
}

/// The bytes of a frame that asks for an answer.
pub(crate) fn encode(sequence: u16, command: u8, data: &[u8]) -> Vec<u8> {
    let len = u16::try_from(data.len()).unwrap_or(u16::MAX);
    let mut bytes = Vec::with_capacity(HEAD_LEN + data.len() + CRC_LEN);
    bytes.extend(START);
    bytes.push(ASKS_FOR_AN_ANSWER);
    bytes.extend(len.to_le_bytes());
    bytes.extend(sequence.to_le_bytes());
    bytes.push(command);
    bytes.extend(data.iter().take(usize::from(len)));
    let checksum = CHECKSUM.checksum(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// Finds frames in bytes that come in pieces, with other bytes between them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Parser {
    rest: Vec<u8>,
}

/// What stands at the beginning of some bytes.
enum Found {
    Frame(Frame, usize),
    /// The beginning of a frame, so far as there is.
    Incomplete,
    Nothing,
}

impl Parser {
    /// Every frame that is complete with these bytes.
    pub(crate) fn feed(&mut self, bytes: &[u8]) -> Vec<Frame> {
        self.rest.extend_from_slice(bytes);
        let mut frames = Vec::new();
        let mut at = 0;
        while let Some(rest) = self.rest.get(at..).filter(|rest| !rest.is_empty()) {
            match look(rest) {
                Found::Frame(frame, len) => {
                    frames.push(frame);
                    at += len;
                }
                Found::Incomplete => break,
                Found::Nothing => at += 1,
            }
        }
        self.rest.drain(..at.min(self.rest.len()));
        frames
    }
}

fn look(bytes: &[u8]) -> Found {
    let begins = bytes.iter().zip(START).all(|(byte, start)| *byte == start);
    if !begins {
        return Found::Nothing;
    }
    let Some(&[_, _, _, len_low, len_high, _, _, command]) = bytes.first_chunk::<HEAD_LEN>() else {
        return Found::Incomplete;
    };
    let len = usize::from(u16::from_le_bytes([len_low, len_high]));
    if len > LONGEST_DATA {
        return Found::Nothing;
    }
    let end = HEAD_LEN + len;
    let (Some(before), Some(&[low, high])) = (bytes.get(..end), bytes.get(end..end + CRC_LEN)) else {
        return Found::Incomplete;
    };
    if CHECKSUM.checksum(before) != u16::from_le_bytes([low, high]) {
        return Found::Nothing;
    }
    let data = before.get(HEAD_LEN..).unwrap_or_default().to_vec();
    Found::Frame(Frame { command, data }, end + CRC_LEN)
}
