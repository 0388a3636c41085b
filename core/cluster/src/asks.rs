//! What one node asks of another: commands for the vehicles it flies, what only the coordinator can do, requests that came in at another
//! node's gateway. Each is carried in parts over the bus's commands, which deliver once and in order, and answered once.
//!
//! Must never do: carry anything out twice; wait without an end.

use crate::parts::{self, Assembly, Part, PartsError};
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime, Refusal};
use skein_state::asks::{Answer, Ask};
use std::collections::BTreeMap;
use tokio::sync::oneshot;

/// One piece of an ask or an answer, as a command of the bus carries it.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct Piece {
    /// The asker's number of it.
    #[n(0)]
    pub id: u64,
    /// It is of the answer.
    #[n(1)]
    pub is_answer: bool,
    /// Which part.
    #[n(2)]
    pub part: Part,
}

/// An ask or an answer too large for pieces, as the bus carries large things.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct Large {
    /// The asker's number of it.
    #[n(0)]
    pub id: u64,
    /// It is the answer.
    #[n(1)]
    pub is_answer: bool,
    /// It, packed.
    #[cbor(n(2), with = "minicbor::bytes")]
    pub packed: Vec<u8>,
}

/// What has come together of pieces.
pub enum Whole {
    /// Another node asks something.
    Asked {
        /// Who.
        from: NodeId,
        /// Its number.
        id: u64,
        /// What.
        ask: Box<Ask>,
    },
    /// Something this node asked was answered.
    Answered,
}

struct Open {
    to: NodeId,
    until: NodeTime,
    answer: oneshot::Sender<Result<Answer, Refusal>>,
}

/// What is open between this node and others.
#[derive(Default)]
pub struct Asks {
    last: u64,
    open: BTreeMap<u64, Open>,
    coming: BTreeMap<(NodeId, u64, bool), (NodeTime, Assembly)>,
    /// Commands of the bus by their numbers, and what they are part of.
    carried: BTreeMap<(NodeId, u64), u64>,
    /// The same for what is carried as something large.
    carried_whole: BTreeMap<u64, u64>,
}

/// Pieces of something that does not become whole are forgotten after so long, in seconds.
const COMING_S: f64 = 10.0;
/// What was not receipted is waited for no longer than this, in seconds: as long as its answer may take where much is lost.
const NO_RECEIPT_S: f64 = 2.0;
/// More things do not come in at once from all nodes together.
const MOST_COMING: usize = 256;

fn not_heard(node: NodeId) -> Refusal {
    Refusal::NotRunning {
        what: format!("node {node} (it does not answer)"),
    }
}

impl Asks {
    /// Begins to ask; gives what is to be sent. What cannot be sent is answered at once, with the reason.
    pub fn begin(
        &mut self,
        to: NodeId,
        ask: &Ask,
        until: NodeTime,
        piece_bytes: usize,
        answer: oneshot::Sender<Result<Answer, Refusal>>,
    ) -> Option<(u64, Sendable)> {
        self.last += 1;
        let id = self.last;
        let packed = parts::pack(ask).and_then(|packed| sendable(id, false, packed, piece_bytes));
        match packed {
            Ok(sendable) => {
                self.open.insert(id, Open { to, until, answer });
                Some((id, sendable))
            }
            Err(error) => {
                let detail = format!("what is asked of node {to} cannot be told to it: {error}");
                let _ = answer.send(Err(Refusal::NotPermitted { detail }));
                None
            }
        }
    }

    /// A piece was posted under this number of the bus.
    pub fn carried(&mut self, to: NodeId, number: u64, piece: &Piece) {
        if !piece.is_answer {
            self.carried.insert((to, number), piece.id);
        }
    }

    /// It is carried as something large, under this number of the bus.
    pub fn carried_whole(&mut self, number: u64, id: u64) {
        self.carried_whole.insert(number, id);
    }

    /// Something large is there, or will not come; if it will not, it ends what it was.
    pub fn whole_ended(&mut self, to: NodeId, number: u64, delivered: bool) {
        let id = self.carried_whole.remove(&number);
        if let Some(id) = id.filter(|_| !delivered) {
            self.failed(id, not_heard(to));
        }
    }

    /// A command of the bus has ended. One without a receipt has mostly arrived all the same, where much is lost: what it is part of is waited
    /// for a while longer.
    pub fn command_ended(&mut self, now: NodeTime, to: NodeId, number: u64, delivered: bool) {
        let id = self.carried.remove(&(to, number));
        if let Some(open) = id.filter(|_| !delivered).and_then(|id| self.open.get_mut(&id)) {
            open.until = open.until.min(now.plus_seconds(NO_RECEIPT_S));
        }
    }

    /// What this node asked cannot be sent at all.
    pub fn failed(&mut self, id: u64, refusal: Refusal) {
        if let Some(open) = self.open.remove(&id) {
            let _ = open.answer.send(Err(refusal));
        }
    }

    /// Takes a piece in.
    ///
    /// # Errors
    /// When it is whole and cannot be understood.
    pub fn take(&mut self, now: NodeTime, from: NodeId, piece: Piece) -> Result<Option<Whole>, PartsError> {
        let at = (from, piece.id, piece.is_answer);
        if self.coming.len() >= MOST_COMING && !self.coming.contains_key(&at) {
            return Ok(None);
        }
        let coming = self.coming.entry(at).or_insert_with(|| (now, Assembly::default()));
        let Some(bytes) = coming.1.take(piece.part) else {
            return Ok(None);
        };
        self.coming.remove(&at);
        let (_, id, is_answer) = at;
        self.whole(from, id, is_answer, &bytes).map(Some)
    }

    /// Takes in what came whole.
    ///
    /// # Errors
    /// When it cannot be understood.
    pub fn whole(&mut self, from: NodeId, id: u64, is_answer: bool, bytes: &[u8]) -> Result<Whole, PartsError> {
        if !is_answer {
            let ask = Box::new(parts::unpack(bytes)?);
            return Ok(Whole::Asked { from, id, ask });
        }
        // An answer of somebody else, or one that comes too late, is nobody's.
        if self.open.get(&id).is_some_and(|open| open.to == from)
            && let Some(open) = self.open.remove(&id)
        {
            let answer = parts::unpack(bytes).map_err(|e| Refusal::NotRunning {
                what: format!("node {from} (its answer {e})"),
            });
            let _ = open.answer.send(answer);
        }
        Ok(Whole::Answered)
    }

    /// Ends what has waited for too long.
    pub fn expire(&mut self, now: NodeTime) {
        self.coming.retain(|_, (since, _)| now.seconds_since(*since) < COMING_S);
        let late: Vec<u64> = self
            .open
            .iter()
            .filter(|(_, open)| open.until < now)
            .map(|(id, _)| *id)
            .collect();
        for id in late {
            if let Some(open) = self.open.remove(&id) {
                let _ = open.answer.send(Err(not_heard(open.to)));
            }
        }
        let open = &self.open;
        self.carried.retain(|_, id| open.contains_key(id));
        self.carried_whole.retain(|_, id| open.contains_key(id));
    }
}

/// An ask or an answer on its way.
pub enum Sendable {
    /// In pieces.
    Pieces(Vec<Piece>),
    /// As one large thing.
    Large(Large),
}

/// More pieces than this are not posted at once: they would keep other commands waiting.
const MOST_PIECES: usize = 16;

/// An answer as it is to be sent.
///
/// # Errors
/// When it cannot be written.
pub fn answering(id: u64, answer: &Answer, piece_bytes: usize) -> Result<Sendable, PartsError> {
    sendable(id, true, parts::pack(answer)?, piece_bytes)
}

fn sendable(id: u64, is_answer: bool, packed: Vec<u8>, piece_bytes: usize) -> Result<Sendable, PartsError> {
    if packed.len() > MOST_PIECES * piece_bytes {
        return Ok(Sendable::Large(Large { id, is_answer, packed }));
    }
    pieces(id, is_answer, &packed, piece_bytes).map(Sendable::Pieces)
}

fn pieces(id: u64, is_answer: bool, packed: &[u8], piece_bytes: usize) -> Result<Vec<Piece>, PartsError> {
    let parts = parts::split(packed, id, piece_bytes)?;
    Ok(parts.into_iter().map(|part| Piece { id, is_answer, part }).collect())
}

#[cfg(test)]
mod tests;
