//! Questions from one node to another, each with a deadline: an answer in time, or the word that there was none.
//!
//! Must never do: hand out two answers to one question, or one after its deadline. A question may reach its receiver more than once: what it
//! asks for must change nothing.

use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

/// A question on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Question {
    /// Counts from 1 per run of the asker.
    #[n(0)]
    pub id: u64,
    /// What is asked.
    #[cbor(n(1), with = "minicbor::bytes")]
    pub body: Vec<u8>,
}

/// An answer on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct QueryAnswer {
    /// Of the question.
    #[n(0)]
    pub id: u64,
    /// The answer.
    #[cbor(n(1), with = "minicbor::bytes")]
    pub body: Vec<u8>,
}

/// How questions are asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuerySettings {
    /// An unanswered one is asked again after so long, in seconds, then after twice as long, and so on up to [`Self::again_at_most_s`].
    pub again_after_s: f64,
    /// The longest time between two tries, in seconds.
    pub again_at_most_s: f64,
    /// How many may be open.
    pub most_open: usize,
}

impl Default for QuerySettings {
    fn default() -> Self {
        Self {
            again_after_s: 0.2,
            again_at_most_s: 1.0,
            most_open: 64,
        }
    }
}

/// Too many questions are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{open} questions are open already")]
pub struct TooManyOpen {
    /// How many.
    pub open: usize,
}

#[derive(Debug)]
struct Open {
    to: NodeId,
    body: Vec<u8>,
    deadline: NodeTime,
    next_try: NodeTime,
    pause_s: f64,
}

/// The questions of one node.
#[derive(Debug)]
pub struct Asking {
    settings: QuerySettings,
    last: u64,
    open: BTreeMap<u64, Open>,
}

impl Asking {
    /// None yet.
    #[must_use]
    pub fn new(settings: QuerySettings) -> Self {
        Self {
            settings,
            last: 0,
            open: BTreeMap::new(),
        }
    }

    /// Asks; gives the question's number.
    ///
    /// # Errors
    ///
    /// Too many are open.
    pub fn ask(&mut self, now: NodeTime, to: NodeId, body: Vec<u8>, within_s: f64) -> Result<u64, TooManyOpen> {
        let open = self.open.len();
        if open >= self.settings.most_open {
            return Err(TooManyOpen { open });
        }
        self.last += 1;
        let question = Open {
            to,
            body,
            deadline: now.plus_seconds(within_s),
            next_try: now,
            pause_s: self.settings.again_after_s,
        };
        self.open.insert(self.last, question);
        Ok(self.last)
    }

    /// The next question to send now.
    pub fn next(&mut self, now: NodeTime) -> Option<(NodeId, Question)> {
        let at_most_s = self.settings.again_at_most_s;
        let (id, open) = self.open.iter_mut().find(|(_, open)| open.next_try <= now)?;
        open.next_try = now.plus_seconds(open.pause_s);
        open.pause_s = (open.pause_s * 2.0).min(at_most_s);
        let body = open.body.clone();
        Some((open.to, Question { id: *id, body }))
    }

    /// Takes an answer in; none if the question is not open, or was for another node.
    pub fn answered(&mut self, now: NodeTime, from: NodeId, answer: QueryAnswer) -> Option<(u64, Vec<u8>)> {
        let open = self.open.get(&answer.id)?;
        if open.to != from || now > open.deadline {
            return None;
        }
        self.open.remove(&answer.id);
        Some((answer.id, answer.body))
    }

    /// Gives up what is past its deadline.
    pub fn expire(&mut self, now: NodeTime) -> Vec<(u64, NodeId)> {
        let mut ended = Vec::new();
        self.open.retain(|id, open| {
            let kept = now <= open.deadline;
            if !kept {
                ended.push((*id, open.to));
            }
            kept
        });
        ended
    }
}

#[cfg(test)]
mod tests;
