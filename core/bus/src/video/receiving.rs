//! The receiver of video.

use super::{VideoLost, VideoPart, VideoPicture};
use crate::envelope::Boot;
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, BTreeSet};

/// What is missing is waited for so long, in seconds, before the stream goes on with a later key picture.
const GIVE_UP_S: f64 = 0.35;
/// Parts that were overtaken are waited for so long, in seconds, before they are asked for.
const OVERTAKEN_S: f64 = 0.01;
/// What is still missing is asked for again after so long, in seconds, and then after [`RARER`] times as long each time. On a link with a
/// longer way something comes twice by this; on one that loses both a picture and what it was asked for with there is time for a third try.
const ASK_AGAIN_S: f64 = 0.06;
const RARER: f64 = 1.5;
/// A key picture is asked for again after so long, in seconds.
const KEY_AGAIN_S: f64 = 0.5;
/// Pictures of one stream that may be incomplete or wait for one before them.
const MOST_PICTURES: usize = 64;
/// Bytes of these.
const MOST_BYTES: usize = 4 << 20;
/// Parts asked for at once.
const MOST_ASKED: usize = 64;

#[derive(Debug)]
struct Partial {
    key: bool,
    of: u16,
    parts: BTreeMap<u16, Vec<u8>>,
}

impl Partial {
    fn is_whole(&self) -> bool {
        self.parts.len() == usize::from(self.of)
    }
}

/// When something was asked for, and how long that is waited for.
#[derive(Debug, Clone, Copy)]
struct Asked {
    at: NodeTime,
    patience_s: f64,
}

#[derive(Debug, Default)]
struct Stream {
    /// The run of the sender that it comes from.
    boot: Option<Boot>,
    /// The picture to hand out next; none until a key picture came.
    next: Option<u64>,
    /// What was handed out last does not go on: too much waited, and it was dropped.
    broken_off: bool,
    coming: BTreeMap<u64, Partial>,
    bytes: usize,
    /// Since when the next one is missing.
    missing_since: Option<NodeTime>,
    /// What was asked for.
    asked: BTreeMap<(u64, Option<u16>), Asked>,
    asked_key: Option<NodeTime>,
    wants_key: bool,
}

/// What one node receives.
#[derive(Debug, Default)]
pub struct VideoReceiving {
    streams: BTreeMap<(NodeId, u32), Stream>,
}

impl VideoReceiving {
    /// A stream of a node is wanted from now on. Others are not taken in.
    pub fn expect(&mut self, from: NodeId, stream: u32) {
        self.streams.entry((from, stream)).or_default();
    }

    /// It is not wanted any more.
    pub fn forget(&mut self, from: NodeId, stream: u32) {
        self.streams.remove(&(from, stream));
    }

    /// A decoder of the stream needs a key picture.
    pub fn want_key(&mut self, from: NodeId, stream: u32) {
        if let Some(coming) = self.streams.get_mut(&(from, stream)) {
            coming.wants_key = true;
        }
    }

    /// Takes a part in. Gives the pictures that can be handed out now, in order.
    pub fn take(&mut self, now: NodeTime, from: NodeId, boot: Boot, part: VideoPart) -> Vec<VideoPicture> {
        let stream = part.stream;
        let Some(coming) = self.streams.get_mut(&(from, stream)) else {
            return Vec::new();
        };
        if coming.boot != Some(boot) {
            *coming = Stream {
                boot: Some(boot),
                ..Stream::default()
            };
        }
        coming.put(part);
        coming.hand_out(now, stream)
    }

    /// Goes on where what is missing was waited for long enough.
    pub fn expire(&mut self, now: NodeTime) -> Vec<(NodeId, VideoPicture)> {
        let mut pictures = Vec::new();
        for ((from, stream), coming) in &mut self.streams {
            let handed = coming.hand_out(now, *stream);
            pictures.extend(handed.into_iter().map(|picture| (*from, picture)));
        }
        pictures
    }

    /// What to ask a sender for now.
    pub fn next_lost(&mut self, now: NodeTime) -> Option<(NodeId, VideoLost)> {
        let streams = self.streams.iter_mut();
        let mut lost = streams.filter_map(|((from, stream), coming)| Some((*from, coming.lost(now, *stream)?)));
        lost.next()
    }
}

impl Stream {
    fn put(&mut self, part: VideoPart) {
        let before = self.next.is_some_and(|next| part.picture < next);
        if before || part.of == 0 || part.index >= part.of {
            return;
        }
        let partial = self.coming.entry(part.picture).or_insert_with(|| Partial {
            key: part.key,
            of: part.of,
            parts: BTreeMap::new(),
        });
        if partial.of != part.of {
            return;
        }
        let len = part.part.len();
        if partial.parts.insert(part.index, part.part).is_none() {
            self.bytes += len;
        }
        self.asked.remove(&(part.picture, Some(part.index)));
        if self.coming.len() > MOST_PICTURES || self.bytes > MOST_BYTES {
            self.make_room();
        }
    }

    /// Too much waits: what is before the newest key picture goes, or all if there is none.
    fn make_room(&mut self) {
        let newest = self.coming.iter().rev().find(|(_, partial)| partial.key);
        let kept = newest.map_or(u64::MAX, |(picture, _)| *picture);
        let first = self.coming.keys().next().copied().unwrap_or_default();
        // That it is the first already, and still too much, leaves nothing to keep.
        let kept = if kept == first { u64::MAX } else { kept };
        self.drop_before(kept);
        let next = self.next.filter(|next| *next >= kept);
        self.broken_off |= next.is_none() && self.next.is_some();
        self.next = next;
        self.wants_key |= kept == u64::MAX;
    }

    fn drop_before(&mut self, picture: u64) {
        self.coming = self.coming.split_off(&picture);
        self.asked = self.asked.split_off(&(picture, None));
        let parts = self.coming.values().flat_map(|partial| partial.parts.values());
        self.bytes = parts.map(Vec::len).sum();
    }

    fn hand_out(&mut self, now: NodeTime, stream: u32) -> Vec<VideoPicture> {
        let mut handed = Vec::new();
        loop {
            let whole = |partial: &Partial| partial.is_whole();
            let in_order = self.next.filter(|next| self.coming.get(next).is_some_and(whole));
            let chosen = in_order.or_else(|| self.later_key(now));
            let Some(picture) = chosen else { break };
            let after_gap = std::mem::take(&mut self.broken_off) || self.next.is_some_and(|next| picture > next);
            let Some(partial) = self.coming.remove(&picture) else {
                break;
            };
            self.drop_before(picture);
            self.next = Some(picture + 1);
            self.missing_since = None;
            handed.push(VideoPicture {
                stream,
                key: partial.key,
                after_gap,
                body: partial.parts.into_values().flatten().collect(),
            });
        }
        let waits = !self.coming.is_empty();
        self.missing_since = if waits { self.missing_since.or(Some(now)) } else { None };
        handed
    }

    /// The key picture to go on with: at the beginning at once, later when what is missing was waited for long enough.
    fn later_key(&mut self, now: NodeTime) -> Option<u64> {
        let waited = |since: NodeTime| now.seconds_since(since) >= GIVE_UP_S;
        if self.next.is_some() && !self.missing_since.is_some_and(waited) {
            return None;
        }
        let keys = self.coming.iter().rev();
        let key = keys
            .filter(|(_, partial)| partial.key && partial.is_whole())
            .map(|(picture, _)| *picture);
        let key = key.max();
        self.wants_key |= key.is_none() && self.next.is_some();
        key
    }

    /// What to ask for now, if anything.
    fn lost(&mut self, now: NodeTime, stream: u32) -> Option<VideoLost> {
        let key_due = self.asked_key.is_none_or(|at| now.seconds_since(at) >= KEY_AGAIN_S);
        let wants_key = key_due && std::mem::take(&mut self.wants_key);
        if wants_key {
            self.asked_key = Some(now);
        }
        let mut lost = VideoLost {
            stream,
            parts: Vec::new(),
            pictures: Vec::new(),
            wants_key,
        };
        let overtaken = self
            .missing_since
            .is_some_and(|since| now.seconds_since(since) >= OVERTAKEN_S);
        if let Some(next) = self.next.filter(|_| overtaken) {
            self.gather(now, next, &mut lost);
        } else if overtaken {
            // At the beginning only a key picture is of use.
            let key = self
                .coming
                .iter()
                .find(|(_, partial)| partial.key)
                .map(|(picture, _)| *picture);
            if let Some(key) = key {
                self.gather(now, key, &mut lost);
            }
        }
        let nothing = lost.parts.is_empty() && lost.pictures.is_empty() && !lost.wants_key;
        (!nothing).then_some(lost)
    }

    fn gather(&mut self, now: NodeTime, from: u64, lost: &mut VideoLost) {
        let Some((newest, _)) = self.coming.last_key_value() else {
            return;
        };
        let newest = *newest;
        let asked = &mut self.asked;
        let mut due = |what: (u64, Option<u16>)| {
            let before = asked.get(&what).copied();
            let again = before.is_none_or(|Asked { at, patience_s }| now.seconds_since(at) >= patience_s);
            if again {
                let patience_s = before.map_or(ASK_AGAIN_S, |before| before.patience_s * RARER);
                asked.insert(what, Asked { at: now, patience_s });
            }
            again
        };
        for picture in from..=newest {
            if lost.parts.len() + lost.pictures.len() >= MOST_ASKED {
                return;
            }
            let Some(partial) = self.coming.get(&picture) else {
                if due((picture, None)) {
                    lost.pictures.push(picture);
                }
                continue;
            };
            let have: BTreeSet<u16> = partial.parts.keys().copied().collect();
            // Of the newest one what is behind the last part may still be on its way.
            let until = if picture == newest {
                have.last().copied().unwrap_or(0)
            } else {
                partial.of
            };
            let missing = (0..until).filter(|index| !have.contains(index));
            for index in missing.take(MOST_ASKED - lost.parts.len()) {
                if due((picture, Some(index))) {
                    lost.parts.push((picture, index));
                }
            }
        }
    }
}
