//! Status texts: chunks joined, the tab at the end taken off, and the last few kept so that a refusal can be told with the
//! words that came beside it.

use mavlink::dialects::common::STATUSTEXT_DATA;
use skein_domain::NodeTime;
use std::collections::VecDeque;

/// Length of one chunk; a chunk that is full and numbered is followed by another.
const CHUNK_BYTES: usize = 50;
/// A text that is not complete after this time is given out as it is, in seconds.
const INCOMPLETE_S: f64 = 0.5;
/// Texts kept for refusals.
const RECENT_MAX: usize = 16;
/// Texts being joined at once.
const PARTS_MAX: usize = 8;
/// Most chunks of one text.
const CHUNKS_MAX: u8 = 16;
/// `MAV_SEVERITY_WARNING`: a text of this or a graver severity may be the reason of a refusal.
const WARNING: u8 = 4;

/// A whole text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatusText {
    /// When it was complete.
    pub time: NodeTime,
    /// 0 emergency .. 7 debug.
    pub severity: u8,
    /// The text.
    pub text: String,
}

#[derive(Debug)]
struct Part {
    id: u16,
    severity: u8,
    started: NodeTime,
    chunks: Vec<(u8, Vec<u8>)>,
}

impl Part {
    /// Whether every chunk up to one that is not full is here.
    fn complete(&self) -> bool {
        self.chunks
            .iter()
            .enumerate()
            .all(|(i, (sequence, _))| usize::from(*sequence) == i)
            && self.chunks.last().is_some_and(|(_, bytes)| bytes.len() < CHUNK_BYTES)
    }

    fn join(&self) -> Vec<u8> {
        let mut joined = Vec::new();
        let mut next = 0;
        for (sequence, bytes) in &self.chunks {
            if *sequence != next {
                joined.extend_from_slice("…".as_bytes());
            }
            joined.extend_from_slice(bytes);
            next = sequence.saturating_add(1);
        }
        joined
    }
}

/// Joins and keeps the texts of one vehicle.
#[derive(Debug, Default)]
pub struct StatusTexts {
    parts: Vec<Part>,
    recent: VecDeque<StatusText>,
}

impl StatusTexts {
    /// Takes in a message; gives the text if it is complete with it.
    pub fn on_message(&mut self, now: NodeTime, message: &STATUSTEXT_DATA) -> Option<StatusText> {
        let bytes: Vec<u8> = message.text.iter().copied().take_while(|&b| b != 0).collect();
        let severity = message.severity as u8;
        if message.id == 0 && message.chunk_seq == 0 {
            // PX4 numbers its first text 0 too: whether it goes on is then told by its chunk being full.
            if bytes.len() < CHUNK_BYTES {
                return Some(self.finish(now, severity, &bytes));
            }
        }
        if message.chunk_seq >= CHUNKS_MAX {
            return None;
        }
        let part = match self.parts.iter_mut().find(|part| part.id == message.id) {
            Some(part) if part.severity == severity => part,
            _ => {
                self.parts.retain(|part| part.id != message.id);
                if self.parts.len() >= PARTS_MAX {
                    self.parts.remove(0);
                }
                self.parts.push(Part {
                    id: message.id,
                    severity,
                    started: now,
                    chunks: Vec::new(),
                });
                self.parts.last_mut()?
            }
        };
        match part
            .chunks
            .binary_search_by_key(&message.chunk_seq, |(sequence, _)| *sequence)
        {
            Ok(_) => return None,
            Err(place) => part.chunks.insert(place, (message.chunk_seq, bytes)),
        }
        if !part.complete() {
            return None;
        }
        let joined = part.join();
        self.parts.retain(|part| part.id != message.id);
        Some(self.finish(now, severity, &joined))
    }

    /// Gives out texts of which a chunk was lost.
    pub fn poll(&mut self, now: NodeTime) -> Option<StatusText> {
        let stale = self
            .parts
            .iter()
            .position(|part| now.seconds_since(part.started) > INCOMPLETE_S)?;
        let part = self.parts.remove(stale);
        let joined = part.join();
        Some(self.finish(now, part.severity, &joined))
    }

    /// The warnings and errors between two moments, joined; empty if there were none.
    #[must_use]
    pub fn between(&self, from: NodeTime, to: NodeTime) -> String {
        let mut texts: Vec<&str> = Vec::new();
        for text in &self.recent {
            if text.time >= from && text.time <= to && text.severity <= WARNING && !texts.contains(&text.text.as_str())
            {
                texts.push(&text.text);
            }
        }
        texts.join("; ")
    }

    fn finish(&mut self, now: NodeTime, severity: u8, bytes: &[u8]) -> StatusText {
        let text = String::from_utf8_lossy(bytes)
            .trim_end_matches(['\t', ' ', '\n'])
            .to_owned();
        let text = StatusText {
            time: now,
            severity,
            text,
        };
        if self.recent.len() >= RECENT_MAX {
            self.recent.pop_front();
        }
        self.recent.push_back(text.clone());
        text
    }
}

#[cfg(test)]
mod tests {
    //! Chunks in order, out of order, lost and repeated.

    use super::*;
    use mavlink::dialects::common::MavSeverity;

    fn chunk(id: u16, chunk_seq: u8, text: &str) -> STATUSTEXT_DATA {
        STATUSTEXT_DATA {
            severity: MavSeverity::MAV_SEVERITY_CRITICAL,
            text: text.into(),
            id,
            chunk_seq,
        }
    }

    fn at(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    const LONG: &str = "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 u";

    #[test]
    fn chunks_are_joined_in_any_order_and_repeats_do_no_harm() {
        let mut texts = StatusTexts::default();
        assert_eq!(texts.on_message(at(1.0), &chunk(15, 0, LONG)), None);
        assert_eq!(texts.on_message(at(1.0), &chunk(15, 0, LONG)), None);
        let whole = texts.on_message(at(1.0), &chunk(15, 1, "nsupported\t")).unwrap();
        assert_eq!(
            whole.text,
            "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported"
        );
        assert_eq!(texts.on_message(at(2.0), &chunk(16, 1, "nsupported\t")), None);
        let whole = texts.on_message(at(2.0), &chunk(16, 0, LONG)).unwrap();
        assert_eq!(
            whole.text,
            "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported"
        );
    }

    #[test]
    fn a_text_with_a_lost_chunk_comes_late_and_shows_the_hole() {
        let mut texts = StatusTexts::default();
        assert_eq!(texts.on_message(at(1.0), &chunk(3, 0, LONG)), None);
        assert_eq!(texts.on_message(at(1.0), &chunk(3, 2, "end\t")), None);
        assert_eq!(texts.poll(at(1.2)), None);
        assert_eq!(texts.poll(at(1.6)).unwrap().text, format!("{LONG}…end"));
        assert_eq!(texts.poll(at(9.0)), None);
    }

    #[test]
    fn short_texts_come_at_once_and_only_warnings_explain_a_refusal() {
        let mut texts = StatusTexts::default();
        assert_eq!(
            texts.on_message(at(1.0), &chunk(0, 0, "Arming denied\t")).unwrap().text,
            "Arming denied"
        );
        let info = STATUSTEXT_DATA {
            severity: MavSeverity::MAV_SEVERITY_INFO,
            ..chunk(4, 0, "Takeoff detected\t")
        };
        assert_eq!(texts.on_message(at(1.1), &info).unwrap().text, "Takeoff detected");
        texts.on_message(at(1.2), &chunk(5, 0, "Arming denied\t"));
        texts.on_message(at(1.3), &chunk(6, 0, "not level\t"));
        assert_eq!(texts.between(at(0.9), at(1.25)), "Arming denied");
        assert_eq!(texts.between(at(0.9), at(2.0)), "Arming denied; not level");
        assert_eq!(texts.between(at(1.5), at(2.0)), "");
    }
}
