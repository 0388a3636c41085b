//! What participants say of themselves on the wire (RTPS 2.3: a message of submessages, the discovery protocol's DATA with a list of parameters):
//! as little of it as the announcer needs.
//!
//! Must never do: read beyond what has arrived, or take what one participant says for another's.

use std::net::SocketAddrV4;

/// What the names of all that belongs to one participant begin with.
pub(crate) type Prefix = [u8; 12];

const MAGIC: &[u8; 4] = b"RTPS";
const HEADER_BYTES: usize = 20;
/// Submessages, by their numbers.
const PAD: u8 = 0x01;
const INFO_TS: u8 = 0x09;
const INFO_SRC: u8 = 0x0c;
const DATA: u8 = 0x15;
/// Flags of a submessage: its numbers begin with their lowest octet; it has data; it has a key alone.
const LITTLE: u8 = 0x01;
const HAS_DATA: u8 = 0x04;
const HAS_KEY: u8 = 0x08;
/// Of each participant, who announces it, who hears of others, and itself.
const ANNOUNCER: [u8; 4] = [0x00, 0x01, 0x00, 0xc2];
const DETECTOR: [u8; 4] = [0x00, 0x01, 0x00, 0xc7];
const PARTICIPANT: [u8; 4] = [0x00, 0x00, 0x01, 0xc1];
/// The one endpoint of a caller: it hears of others.
const ONLY_DETECTOR: u32 = 0x0000_0002;
/// For so long a caller is there after its last word, in seconds.
const LEASE_S: u32 = 60;

/// What a datagram says of a participant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Said {
    /// It is there; in words that may be repeated to anybody.
    Here(Vec<u8>),
    /// It is no more.
    Gone,
}

/// A submessage and where it stands.
struct Submessage<'a> {
    kind: u8,
    flags: u8,
    /// With its header.
    whole: &'a [u8],
    body: &'a [u8],
}

/// The first submessage of these bytes, and the rest.
fn first(bytes: &[u8]) -> Option<(Submessage<'_>, &[u8])> {
    let [kind, flags, low, high, after @ ..] = bytes else {
        return None;
    };
    let length = match flags & LITTLE {
        0 => u16::from_be_bytes([*low, *high]),
        _ => u16::from_le_bytes([*low, *high]),
    };
    // Of length zero, the last one goes on to the end; the two that may have no body are just short.
    let to_the_end = length == 0 && *kind != PAD && *kind != INFO_TS;
    let length = if to_the_end { after.len() } else { usize::from(length) };
    let body = after.get(..length)?;
    let whole = bytes.get(..length + 4)?;
    let submessage = Submessage {
        kind: *kind,
        flags: *flags,
        whole,
        body,
    };
    Some((submessage, after.get(length..)?))
}

/// What this datagram says of the participant of this name. Nothing, if it is another's or of something else.
///
/// Whom it was for and what else it says is left out.
pub(crate) fn said(datagram: &[u8], of: &Prefix) -> Option<Said> {
    let (header, mut rest) = datagram.split_at_checked(HEADER_BYTES)?;
    if !header.starts_with(MAGIC) || !header.ends_with(of) {
        return None;
    }
    let (mut words, mut is_here) = (header.to_vec(), false);
    while !rest.is_empty() {
        let (submessage, after) = first(rest)?;
        rest = after;
        match submessage.kind {
            INFO_TS => words.extend_from_slice(submessage.whole),
            // From here on somebody else speaks.
            INFO_SRC => return None,
            DATA if submessage.body.get(8..12) == Some(&ANNOUNCER) => {
                if submessage.flags & HAS_KEY != 0 {
                    return Some(Said::Gone);
                }
                is_here |= submessage.flags & HAS_DATA != 0;
                words.extend_from_slice(submessage.whole);
            }
            _ => {}
        }
    }
    is_here.then_some(Said::Here(words))
}

/// The announcement of a caller: a participant that has nothing and only wants to be told, at this address, of others.
pub(crate) fn caller(name: &Prefix, at: SocketAddrV4, number: u32) -> Vec<u8> {
    let mut list = Vec::new();
    let mut parameter = |id: u16, value: &[u8]| {
        list.extend(id.to_le_bytes());
        list.extend(u16::try_from(value.len()).unwrap_or(0).to_le_bytes());
        list.extend(value);
    };
    let guid = [&name[..], &PARTICIPANT[..]].concat();
    let lease = [LEASE_S.to_le_bytes(), [0; 4]].concat();
    let mut locator = [1_u32.to_le_bytes(), u32::from(at.port()).to_le_bytes()].concat();
    locator.extend([0; 12]);
    locator.extend(at.ip().octets());
    parameter(0x0015, &[2, 3, 0, 0]); // version of the protocol
    parameter(0x0016, &[0; 4]); // vendor: none
    parameter(0x0050, &guid);
    parameter(0x0032, &locator); // where discovery is heard
    parameter(0x0031, &locator); // where everything else is
    parameter(0x0058, &ONLY_DETECTOR.to_le_bytes());
    parameter(0x0002, &lease);
    parameter(0x0001, &[]); // end
    let mut data = vec![0, 0, 16, 0];
    data.extend(DETECTOR);
    data.extend(ANNOUNCER);
    data.extend([0; 4]);
    data.extend(number.to_le_bytes());
    data.extend([0, 3, 0, 0]); // a list of parameters, lowest octet first
    data.extend(list);
    let mut message = MAGIC.to_vec();
    message.extend([2, 3, 0, 0]);
    message.extend(name);
    message.extend([DATA, LITTLE | HAS_DATA]);
    message.extend(u16::try_from(data.len()).unwrap_or(0).to_le_bytes());
    message.extend(data);
    message
}

#[cfg(test)]
mod tests;
