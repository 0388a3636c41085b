//! What arrives: opened, told apart, handed to its class.
//!
//! Must never do: act on a byte that the seal did not let through.

use super::{Bus, Event, RESTING_SHARE, Ticket, VIDEO_SHARE, push_bounded};
use crate::courier::{Inbox, Parcel};
use crate::envelope::{Boot, Opened};
use crate::latest::{Learned, News};
use crate::links::Report;
use crate::transport::To;
use crate::video::VideoLost;
use crate::wire::Frame;
use skein_domain::{NodeId, NodeTime};

impl Bus {
    /// Takes a datagram in. Gives what has happened.
    pub fn take(&mut self, now: NodeTime, bytes: &[u8]) -> Vec<Event> {
        let opened = self.seal.open(now, bytes);
        for reply in self.seal.take_replies() {
            push_bounded(&mut self.proofs, reply);
        }
        match opened {
            Opened::Nothing => Vec::new(),
            Opened::Joined { from, boot } => self.joined(from, boot),
            Opened::Content {
                from,
                boot,
                class,
                to_all,
                bytes: content,
            } => {
                if to_all {
                    self.links.count_for_all(from, boot);
                }
                self.received.entry(from).or_default().count(now, class, bytes.len());
                let Some(frame) = Frame::from_bytes(&content) else {
                    self.not_understood += 1;
                    return Vec::new();
                };
                self.frame(now, from, boot, frame)
            }
        }
    }

    /// Gives up what is past its time. Gives what has happened.
    pub fn expire(&mut self, now: NodeTime) -> Vec<Event> {
        let mut events = Vec::new();
        for (to, outbox) in &mut self.outboxes {
            events.extend(ended(*to, outbox.expire(now)));
        }
        let unanswered = self.asking.expire(now).into_iter();
        events.extend(unanswered.map(|(id, to)| Event::Unanswered { id, to }));
        events.extend(not_whole(self.sending.expire(now)));
        self.receiving.expire(now);
        let pictures = self.video_receiving.expire(now).into_iter();
        events.extend(pictures.map(|(from, picture)| Event::Video { from, picture }));
        events
    }

    fn news(&mut self, from: NodeId, boot: Boot, news: News) -> Vec<Event> {
        let Learned { values, lacking } = self.heard.take(from, boot, news);
        if !lacking.is_empty() {
            let known = self.lacking.entry(from).or_default();
            let room = crate::delta::MOST_KEYS.saturating_sub(known.len());
            known.extend(lacking.into_iter().take(room));
        }
        let values = values.into_iter();
        values.map(|(key, value)| Event::State { from, key, value }).collect()
    }

    fn report(&mut self, now: NodeTime, from: NodeId, boot: Boot, report: &Report) {
        self.links.take(now, (self.me, self.boot), from, boot, report);
        let copies = self.copies(now, To::All);
        self.links.adapt(now, self.sent.rate_bytes_per_s(now), copies);
        let rates = self.links.rates();
        self.budget.set_bytes_per_s(now, rates.all_bytes_per_s);
        self.bulk_budget.set_bytes_per_s(now, rates.bulk_bytes_per_s);
        self.video_budget
            .set_bytes_per_s(now, rates.bulk_bytes_per_s * VIDEO_SHARE);
        let resting_bytes_per_s = rates.all_bytes_per_s * RESTING_SHARE;
        self.resting_budget.set_bytes_per_s(now, resting_bytes_per_s);
    }

    fn joined(&mut self, node: NodeId, boot: Boot) -> Vec<Event> {
        let mut events = vec![Event::Joined { node, boot }];
        self.telling.owe_all();
        if let Some(outbox) = self.outboxes.get_mut(&node) {
            events.extend(ended(node, outbox.met(boot)));
        }
        events.extend(not_whole(self.sending.restarted(node)));
        events
    }

    fn video_lost(&mut self, now: NodeTime, by: NodeId, lost: &VideoLost) -> Option<Event> {
        let stream = lost.stream;
        let wants_key = self.video_sending.lost(now, by, lost);
        wants_key.then_some(Event::VideoKeyWanted { by, stream })
    }

    fn parcel(&mut self, now: NodeTime, from: NodeId, parcel: Parcel) -> Vec<Event> {
        let (settings, mine) = (self.settings.courier, self.boot);
        let inbox = self.inboxes.entry(from).or_insert_with(|| Inbox::new(settings, mine));
        let Some((bodies, receipt)) = inbox.take(now, parcel) else {
            return Vec::new();
        };
        self.receipts.insert(from, receipt);
        let commands = bodies.into_iter().map(|body| Event::Command { from, body });
        commands.collect()
    }

    fn frame(&mut self, now: NodeTime, from: NodeId, boot: Boot, frame: Frame) -> Vec<Event> {
        match frame {
            Frame::State(wholes) => {
                let news = News {
                    wholes,
                    ..News::default()
                };
                self.news(from, boot, news)
            }
            Frame::News(news) => self.news(from, boot, news),
            Frame::Lacks(keys) => {
                for key in keys {
                    self.telling.owe(key);
                }
                Vec::new()
            }
            // The seal knows the run; a parcel that names another one was put together wrongly.
            Frame::Parcel(parcel) if parcel.boot == boot => self.parcel(now, from, parcel),
            Frame::Parcel(_) => Vec::new(),
            Frame::Receipt(receipt) => {
                let outbox = self.outboxes.get_mut(&from).filter(|_| receipt.from_boot == boot);
                outbox.map_or_else(Vec::new, |outbox| ended(from, outbox.receipt(now, &receipt)).collect())
            }
            Frame::Question(question) => {
                let ticket = Ticket { from, id: question.id };
                let body = question.body;
                vec![Event::Asked { ticket, body }]
            }
            Frame::QueryAnswer(answer) => {
                let answered = self.asking.answered(now, from, answer).into_iter();
                answered.map(|(id, body)| Event::Answered { id, from, body }).collect()
            }
            Frame::Chunk(chunk) => {
                let (have, whole) = self.receiving.take(now, from, boot, chunk);
                // A newer word about the same thing replaces the one before.
                self.haves.retain(|(to, earlier)| *to != from || earlier.id != have.id);
                push_bounded(&mut self.haves, (from, have));
                whole.into_iter().map(|body| Event::Bulk { from, body }).collect()
            }
            Frame::VideoPart(part) => {
                let pictures = self.video_receiving.take(now, from, boot, part).into_iter();
                pictures.map(|picture| Event::Video { from, picture }).collect()
            }
            Frame::VideoLost(lost) => self.video_lost(now, from, &lost).into_iter().collect(),
            Frame::Report(report) => {
                self.report(now, from, boot, &report);
                Vec::new()
            }
            Frame::Have(have) => {
                let ended = self.sending.have(now, from, &have).into_iter();
                ended
                    .map(|(id, whole)| Event::BulkEnded { to: from, id, whole })
                    .collect()
            }
        }
    }
}

fn ended(to: NodeId, commands: Vec<(u64, crate::courier::Outcome)>) -> impl Iterator<Item = Event> {
    commands
        .into_iter()
        .map(move |(number, outcome)| Event::CommandEnded { to, number, outcome })
}

fn not_whole(things: Vec<(u64, NodeId)>) -> impl Iterator<Item = Event> {
    let whole = false;
    things
        .into_iter()
        .map(move |(id, to)| Event::BulkEnded { to, id, whole })
}
