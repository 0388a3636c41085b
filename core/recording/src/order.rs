//! Recordings of several nodes as one, on the clock of the first.
//!
//! Must never do: order two nodes' messages by clocks whose offset nobody measured without saying so.

use crate::damage::Damage;
use crate::messages::{Message, Messages, Select};
use crate::reader::Recording;
use crate::telemetry::ClockRecord;
use crate::topic::Topic;
use skein_domain::{NodeId, NodeTime};
use std::iter::Peekable;

/// Messages of several recordings in their order.
pub struct Merged<'a> {
    parts: Vec<(Peekable<Messages<'a>>, i64)>,
}

/// How far a node's clock is ahead of another's, in microseconds, as one of the two measured it best.
fn ahead_us(of: &Recording, against: &Recording) -> Option<i64> {
    let measured = |by: &Recording, node: NodeId| {
        let clocks = by.messages(Select::only(|topic| *topic == Topic::Clock));
        let offsets = clocks.filter_map(|message| message.ok()?.json::<ClockRecord>().ok());
        let offsets = offsets.filter_map(|clock| clock.others.into_iter().find(|other| other.node == node));
        offsets.min_by(|a, b| {
            let error_s = |of: Option<f64>| of.unwrap_or(f64::INFINITY);
            error_s(a.error_s).total_cmp(&error_s(b.error_s))
        })
    };
    let micros = |seconds: f64| (seconds * 1e6).round() as i64;
    let (own, other) = (of.header().node?, against.header().node?);
    measured(against, own)
        .map(|offset| micros(offset.ahead_s))
        .or_else(|| measured(of, other).map(|offset| -micros(offset.ahead_s)))
}

/// The same from the time of day that both were begun at, where neither measured the other.
fn ahead_by_time_of_day_us(of: &Recording, against: &Recording) -> i64 {
    let (of, against) = (of.header().base, against.header().base);
    let at = against.unix_ns(of.node);
    let ahead_ns = i128::from(at) - i128::from(of.unix_ns);
    i64::try_from(ahead_ns / 1_000).unwrap_or_default()
}

impl<'a> Merged<'a> {
    /// Of these recordings, on the clock of the first, and the nodes whose clock was only known by its time of day.
    #[must_use]
    pub fn of(recordings: &'a [Recording], select: &Select) -> (Self, Vec<String>) {
        let mut unmeasured = Vec::new();
        let Some(first) = recordings.first() else {
            return (Self { parts: Vec::new() }, unmeasured);
        };
        let parts = recordings
            .iter()
            .map(|recording| {
                let same = recording.header().node == first.header().node && recording.header().node.is_some();
                let ahead_us = if std::ptr::eq(recording, first) {
                    Some(0)
                } else if same {
                    Some(ahead_by_time_of_day_us(recording, first))
                } else {
                    ahead_us(recording, first)
                };
                let ahead_us = ahead_us.unwrap_or_else(|| {
                    unmeasured.push(recording.header().name.clone());
                    ahead_by_time_of_day_us(recording, first)
                });
                (recording.messages(select.clone()).peekable(), ahead_us)
            })
            .collect();
        (Self { parts }, unmeasured)
    }
}

fn on_first(at: NodeTime, ahead_us: i64) -> NodeTime {
    at.on_clock_ahead_by(ahead_us.saturating_neg())
}

impl Iterator for Merged<'_> {
    /// The message, with its times on the clock of the first recording, and which recording it is from.
    type Item = Result<(usize, Message), Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut next: Option<(usize, NodeTime)> = None;
        for (index, (messages, ahead_us)) in self.parts.iter_mut().enumerate() {
            match messages.peek() {
                None => {}
                // Told at once: there is no time to order it by.
                Some(Err(_)) => {
                    next = Some((index, NodeTime(0)));
                    break;
                }
                Some(Ok(message)) => {
                    let at = on_first(message.recorded, *ahead_us);
                    if next.is_none_or(|(_, earliest)| at < earliest) {
                        next = Some((index, at));
                    }
                }
            }
        }
        let (index, _) = next?;
        let (messages, ahead_us) = self.parts.get_mut(index)?;
        Some(messages.next()?.map(|message| {
            let moved = Message {
                recorded: on_first(message.recorded, *ahead_us),
                at: on_first(message.at, *ahead_us),
                ..message
            };
            (index, moved)
        }))
    }
}
