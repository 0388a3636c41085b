//! The newest pictures of one stream, and who gets which one next.
//!
//! Must never do: keep more than its bounds; hold a viewer's place open at the cost of others; give a viewer a picture that it cannot decode.
//!
//! Kept are the group of the newest key picture and the one before it. A viewer that falls behind leaves out whole groups: it goes on with the
//! newest key picture.

use crate::frame::EncodedFrame;
use std::collections::VecDeque;
use std::sync::Arc;

/// So many bytes of one stream are kept.
pub const MOST_KEPT_BYTES: usize = 8 << 20;
/// So many pictures of one stream are kept: ten seconds at 60/s.
const MOST_KEPT_FRAMES: usize = 600;
/// A viewer that is so many pictures behind goes on with a newer key picture, if there is one.
const MOST_BEHIND: u64 = 3;

/// A stream's newest pictures.
#[derive(Debug, Default)]
pub struct Relay {
    frames: VecDeque<Arc<EncodedFrame>>,
    /// Number of the first that is kept.
    first: u64,
    bytes: usize,
}

/// A viewer's place in a stream.
#[derive(Debug, Clone, Default)]
pub struct Cursor {
    /// Number of the picture it gets next; none before its first.
    next: Option<u64>,
    /// Pictures that were left out since it began.
    pub left_out: u64,
}

/// A picture for a viewer.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The picture.
    pub frame: Arc<EncodedFrame>,
    /// Pictures before it were left out.
    pub after_gap: bool,
}

impl Relay {
    /// Takes the next picture.
    pub fn push(&mut self, frame: Arc<EncodedFrame>) {
        if frame.key {
            // Who still reads the group before may end it; older ones nobody is in time for.
            let last_key = self.frames.iter().rposition(|kept| kept.key);
            self.drop_first(last_key.unwrap_or(self.frames.len()));
        }
        self.bytes += frame.bytes.len();
        self.frames.push_back(frame);
        while self.bytes > MOST_KEPT_BYTES || self.frames.len() > MOST_KEPT_FRAMES {
            self.drop_first(1);
        }
    }

    /// Keeps none of the pictures that came so far: whoever looks from now on is not to see what was before.
    pub fn forget(&mut self) {
        self.drop_first(self.frames.len());
    }

    fn drop_first(&mut self, count: usize) {
        for dropped in self.frames.drain(..count.min(self.frames.len())) {
            self.bytes -= dropped.bytes.len();
            self.first += 1;
        }
    }

    /// The next picture for a viewer; none if it has them all, or has to wait for a key picture.
    pub fn next(&self, cursor: &mut Cursor) -> Option<Given> {
        let behind = cursor.next.map_or(u64::MAX, |next| self.end().saturating_sub(next));
        let lost = cursor.next.is_none_or(|next| next < self.first);
        let mut after_gap = false;
        if lost || behind > MOST_BEHIND {
            match self.newest_key() {
                Some(key) if cursor.next.is_none_or(|next| key > next) => {
                    if let Some(next) = cursor.next {
                        cursor.left_out += key - next;
                        after_gap = true;
                    }
                    cursor.next = Some(key);
                }
                _ if lost => return None,
                _ => {}
            }
        }
        let next = cursor.next?;
        let place = usize::try_from(next.checked_sub(self.first)?).ok()?;
        let frame = self.frames.get(place)?.clone();
        cursor.next = Some(next + 1);
        Some(Given { frame, after_gap })
    }

    /// Whether only a new key picture helps this viewer.
    #[must_use]
    pub fn waits_for_key(&self, cursor: &Cursor) -> bool {
        match cursor.next {
            None => self.newest_key().is_none(),
            Some(next) if next < self.first => self.newest_key().is_none(),
            Some(next) => {
                let key = self.newest_key();
                self.end().saturating_sub(next) > MOST_BEHIND && key.is_none_or(|key| key <= next)
            }
        }
    }

    fn end(&self) -> u64 {
        self.first + self.frames.len() as u64
    }

    fn newest_key(&self) -> Option<u64> {
        let place = self.frames.iter().rposition(|frame| frame.key)?;
        Some(self.first + place as u64)
    }
}

#[cfg(test)]
mod tests;
