//! What is to be sent: the most urgent first, within the budget.
//!
//! Must never do: hold a class back because of a less urgent one.

use super::{Bus, Outgoing};
use crate::envelope::ENVELOPE_BYTES;
use crate::links::Link;
use crate::transport::{CLASSES, Class, To};
use crate::wire::Frame;
use skein_domain::NodeTime;

/// A node of which nothing was learned for longer is not sent to any more, in seconds.
const THERE_S: f64 = 5.0;

impl Bus {
    /// The next datagram to send now; none if nothing is due or the budget is used up.
    pub fn next(&mut self, now: NodeTime) -> Option<Outgoing> {
        CLASSES.into_iter().find_map(|class| self.next_of(now, class))
    }

    fn next_of(&mut self, now: NodeTime, class: Class) -> Option<Outgoing> {
        // The budget must have room for a whole datagram before one is made: what is made is as new as it can be.
        let most = self.settings.datagram_bytes;
        let bulk_waits = class == Class::Bulk && !self.bulk_budget.allows(now, Class::Query, most);
        let video_waits = class == Class::Video && !self.video_budget.allows(now, Class::Query, most);
        let allowed = !bulk_waits && !video_waits && self.budget.allows(now, class, most);
        // What is small, signs of life above all, may overdraw the budget as commands may, and is not held up by what was sent before.
        let only_small = !allowed && class == Class::State && self.budget.allows(now, Class::Command, most);
        if !allowed && !only_small {
            return None;
        }
        let outgoing = if only_small {
            self.small(now)?
        } else {
            self.made(now, class)?
        };
        let bytes = outgoing.bytes.len() * self.copies(now, outgoing.to);
        self.budget.spend(now, bytes);
        match class {
            Class::Bulk => self.bulk_budget.spend(now, bytes),
            Class::Video => self.video_budget.spend(now, bytes),
            Class::Command | Class::State | Class::Query => {}
        }
        self.sent.count(now, class, bytes);
        Some(outgoing)
    }

    /// How often the transport sends a datagram.
    pub(super) fn copies(&self, now: NodeTime, to: To) -> usize {
        if to != To::All || !self.settings.sends_to_each {
            return 1;
        }
        let there = |(_, link): &(_, Link)| now.seconds_since(link.at) <= THERE_S;
        self.links.known().filter(there).count().max(1)
    }

    fn made(&mut self, now: NodeTime, class: Class) -> Option<Outgoing> {
        if class == Class::Command
            && let Some((to, bytes)) = self.proofs.pop_front()
        {
            let to = To::One(to);
            return Some(Outgoing { to, class, bytes });
        }
        let (to, frame) = match class {
            Class::Command => self.command(now)?,
            Class::State => {
                let room_bytes = self.settings.datagram_bytes.saturating_sub(ENVELOPE_BYTES + 8);
                let report = self.links.report(now, room_bytes, self.seal.sent_to_all());
                let frame = report.map(Frame::Report).or_else(|| {
                    let most = self.settings.datagram_bytes;
                    let resting = self.resting_budget.allows(now, Class::Query, most);
                    let news = self.telling.next(now, room_bytes, resting);
                    let copies = self.copies(now, To::All);
                    self.resting_budget.spend(now, news.resting_bytes * copies);
                    let whole = news.bases.is_empty() && news.changes.is_empty();
                    let frame = if whole {
                        Frame::State(news.wholes)
                    } else {
                        Frame::News(news)
                    };
                    (frame != Frame::State(Vec::new())).then_some(frame)
                });
                (To::All, frame?)
            }
            Class::Query => self.query(now)?,
            Class::Video => {
                let (to, part) = self.video_sending.next_part()?;
                (To::One(to), Frame::VideoPart(part))
            }
            Class::Bulk => {
                let (to, chunk) = self.sending.next(now)?;
                (To::One(to), Frame::Chunk(chunk))
            }
        };
        let bytes = self.seal.seal(to, class, &frame.to_bytes());
        Some(Outgoing { to, class, bytes })
    }

    /// Small values that have changed, if some are due.
    fn small(&mut self, now: NodeTime) -> Option<Outgoing> {
        let room_bytes = self.settings.datagram_bytes.saturating_sub(ENVELOPE_BYTES + 8);
        let news = self.telling.next_small(now, room_bytes);
        if news.wholes.is_empty() {
            return None;
        }
        let (to, class) = (To::All, Class::State);
        let bytes = self.seal.seal(to, class, &Frame::State(news.wholes).to_bytes());
        Some(Outgoing { to, class, bytes })
    }

    fn command(&mut self, now: NodeTime) -> Option<(To, Frame)> {
        if let Some((to, receipt)) = self.receipts.pop_first() {
            return Some((To::One(to), Frame::Receipt(receipt)));
        }
        let mut outboxes = self.outboxes.iter_mut();
        let (to, parcel) = outboxes.find_map(|(to, outbox)| Some((*to, outbox.next(now)?)))?;
        Some((To::One(to), Frame::Parcel(parcel)))
    }

    fn query(&mut self, now: NodeTime) -> Option<(To, Frame)> {
        if let Some((to, answer)) = self.answers.pop_front() {
            return Some((To::One(to), Frame::QueryAnswer(answer)));
        }
        if let Some((to, have)) = self.haves.pop_front() {
            return Some((To::One(to), Frame::Have(have)));
        }
        if let Some((to, keys)) = self.lacking.pop_first() {
            return Some((To::One(to), Frame::Lacks(keys.into_iter().collect())));
        }
        if let Some((to, lost)) = self.video_receiving.next_lost(now) {
            return Some((To::One(to), Frame::VideoLost(lost)));
        }
        let (to, question) = self.asking.next(now)?;
        Some((To::One(to), Frame::Question(question)))
    }
}
