//! Video on its way between nodes: pictures in parts, the newest first, with what was lost on the way asked for again while there is time.
//!
//! Must never do: hold anything else up; keep more than its bounds; hand out a picture that cannot be decoded because one before it is missing,
//! without saying so.
//!
//! What the link does not carry is left out at the sender, whole groups at a time: from then on until the next key picture.

use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, VecDeque};

mod receiving;

pub use receiving::VideoReceiving;

/// A part of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct VideoPart {
    /// The receiver's number of the stream.
    #[n(0)]
    pub stream: u32,
    /// Which picture; counts all that were sent.
    #[n(1)]
    pub picture: u64,
    /// Which part of it, from 0.
    #[n(2)]
    pub index: u16,
    /// How many parts it has.
    #[n(3)]
    pub of: u16,
    /// A decoder can begin with it.
    #[n(4)]
    pub key: bool,
    /// The part.
    #[cbor(n(5), with = "minicbor::bytes")]
    pub part: Vec<u8>,
}

/// What a receiver misses.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct VideoLost {
    /// Its number of the stream.
    #[n(0)]
    pub stream: u32,
    /// Parts of pictures.
    #[n(1)]
    pub parts: Vec<(u64, u16)>,
    /// Pictures of which it has nothing.
    #[n(2)]
    pub pictures: Vec<u64>,
    /// It cannot go on without a key picture.
    #[n(3)]
    pub wants_key: bool,
}

/// A whole picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VideoPicture {
    /// The receiver's number of the stream.
    pub stream: u32,
    /// A decoder can begin with it.
    pub key: bool,
    /// Pictures before it are missing; it is a key picture then.
    pub after_gap: bool,
    /// What was sent.
    pub body: Vec<u8>,
}

/// What became of a picture that was to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pushed {
    /// It is on its way.
    Taken,
    /// The link does not carry so much: nothing is taken until the next key picture, which is wanted now.
    LeftOut,
}

/// What waits for a stream may be as much as the link carries in this time, in seconds; one picture at least.
const MOST_WAITING_S: f64 = 0.3;
/// What was sent is kept for so long, in seconds, in case it is asked for again.
const KEPT_S: f64 = 1.0;
/// So many bytes of one stream are kept for that, at most.
const MOST_KEPT_BYTES: usize = 2 << 20;
/// A part is not sent again within this time, in seconds: its receiver may have asked twice.
const AGAIN_AFTER_S: f64 = 0.04;
/// Streams of one node at once.
const MOST_STREAMS: usize = 64;

#[derive(Debug)]
struct Kept {
    at: NodeTime,
    parts: Vec<VideoPart>,
    again: BTreeMap<u16, NodeTime>,
}

#[derive(Debug, Default)]
struct Stream {
    last: u64,
    waiting: VecDeque<VideoPart>,
    waiting_bytes: usize,
    again: VecDeque<VideoPart>,
    kept: BTreeMap<u64, Kept>,
    kept_bytes: usize,
    waits_for_key: bool,
}

/// What one node sends.
#[derive(Debug, Default)]
pub struct VideoSending {
    streams: BTreeMap<(NodeId, u32), Stream>,
    /// Whose turn it was last.
    turn: Option<(NodeId, u32)>,
}

impl VideoSending {
    /// Takes a picture for a stream; `bytes_per_s` is what the link carries.
    pub fn push(
        &mut self,
        now: NodeTime,
        (to, stream): (NodeId, u32),
        (key, body): (bool, &[u8]),
        chunk_bytes: usize,
        bytes_per_s: f64,
    ) -> Pushed {
        let known = self.streams.contains_key(&(to, stream));
        if !known && self.streams.len() >= MOST_STREAMS {
            return Pushed::LeftOut;
        }
        let sent = self.streams.entry((to, stream)).or_default();
        let most = (bytes_per_s * MOST_WAITING_S) as usize;
        if sent.waiting_bytes > most {
            // A key picture makes what waits before it worth nothing.
            sent.waiting.clear();
            sent.waiting_bytes = 0;
            sent.waits_for_key = !key;
        }
        if key {
            sent.waits_for_key = false;
        }
        if sent.waits_for_key {
            return Pushed::LeftOut;
        }
        let chunks: Vec<&[u8]> = body.chunks(chunk_bytes.max(1)).collect();
        let Ok(of) = u16::try_from(chunks.len()) else {
            return Pushed::LeftOut;
        };
        sent.last += 1;
        let picture = sent.last;
        let part = |(index, part): (usize, &&[u8])| VideoPart {
            stream,
            picture,
            index: index as u16,
            of,
            key,
            part: part.to_vec(),
        };
        let parts: Vec<VideoPart> = chunks.iter().enumerate().map(part).collect();
        sent.waiting.extend(parts.iter().cloned());
        sent.waiting_bytes += body.len();
        sent.keep(now, picture, parts, body.len());
        Pushed::Taken
    }

    /// The next part to send: of each stream in turn, what was asked for again first.
    pub fn next_part(&mut self) -> Option<(NodeId, VideoPart)> {
        let after = self
            .turn
            .map_or((NodeId(0), 0), |(to, stream)| (to, stream.saturating_add(1)));
        let due = |sent: &Stream| !sent.again.is_empty() || !sent.waiting.is_empty();
        let later = self.streams.range(after..).find(|(_, sent)| due(sent));
        let (key, _) = later.or_else(|| self.streams.iter().find(|(_, sent)| due(sent)))?;
        let key = *key;
        self.turn = Some(key);
        let sent = self.streams.get_mut(&key)?;
        let part = sent.again.pop_front().or_else(|| {
            let part = sent.waiting.pop_front()?;
            sent.waiting_bytes = sent.waiting_bytes.saturating_sub(part.part.len());
            Some(part)
        })?;
        Some((key.0, part))
    }

    /// A receiver misses something: it is sent again if it is still there. Whether it wants a key picture.
    pub fn lost(&mut self, now: NodeTime, from: NodeId, lost: &VideoLost) -> bool {
        let Some(sent) = self.streams.get_mut(&(from, lost.stream)) else {
            return false;
        };
        let mut gone = false;
        for (picture, index) in &lost.parts {
            gone |= !sent.send_again(now, *picture, Some(*index));
        }
        for picture in &lost.pictures {
            gone |= !sent.send_again(now, *picture, None);
        }
        // What cannot be sent again breaks the group.
        lost.wants_key || gone
    }

    /// A stream is not wanted any more.
    pub fn end(&mut self, to: NodeId, stream: u32) {
        self.streams.remove(&(to, stream));
    }
}

impl Stream {
    fn keep(&mut self, now: NodeTime, picture: u64, parts: Vec<VideoPart>, bytes: usize) {
        let again = BTreeMap::new();
        self.kept.insert(picture, Kept { at: now, parts, again });
        self.kept_bytes += bytes;
        while let Some(first) = self.kept.first_entry() {
            let old = now.seconds_since(first.get().at) > KEPT_S;
            if !old && self.kept_bytes <= MOST_KEPT_BYTES {
                break;
            }
            let bytes: usize = first.remove().parts.iter().map(|part| part.part.len()).sum();
            self.kept_bytes = self.kept_bytes.saturating_sub(bytes);
        }
    }

    /// Sends a part, or all of a picture, again. False if it is not there any more.
    fn send_again(&mut self, now: NodeTime, picture: u64, index: Option<u16>) -> bool {
        // What still waits to be sent for the first time is not lost.
        if self.waiting.front().is_some_and(|part| part.picture <= picture) || picture > self.last {
            return true;
        }
        let Some(kept) = self.kept.get_mut(&picture) else {
            return false;
        };
        for part in &kept.parts {
            let wanted = index.is_none_or(|index| index == part.index);
            let lately = kept
                .again
                .get(&part.index)
                .is_some_and(|at| now.seconds_since(*at) < AGAIN_AFTER_S);
            if wanted && !lately {
                kept.again.insert(part.index, now);
                self.again.push_back(part.clone());
            }
        }
        true
    }
}

#[cfg(test)]
mod tests;
