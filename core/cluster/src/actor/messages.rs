//! What goes to one other node: asks and their answers, events, the leadership.
//!
//! Must never do: wait for an answer.

use super::SwarmState;
use super::outbound::PART_BYTES;
use crate::asks::{Large, Piece, Sendable, answering};
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime, Refusal};
use skein_failover::Handover;
use skein_state::asks::{Answer, Ask};
use std::time::Duration;
use tokio::sync::oneshot;

/// A command of the bus.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub enum NodeMessage {
    /// Part of an ask or an answer.
    #[n(0)]
    Piece(#[n(0)] Piece),
    /// Events, packed.
    #[n(1)]
    Events(#[cbor(n(0), with = "minicbor::bytes")] Vec<u8>),
    /// The leadership is offered.
    #[n(2)]
    Handover(#[n(0)] Handover),
}

impl SwarmState {
    pub(super) fn post(&mut self, now: NodeTime, to: NodeId, message: &NodeMessage) -> Option<u64> {
        let bytes = minicbor::to_vec(message).ok()?;
        self.bus.post(now, to, bytes).ok()
    }

    /// Asks another node something.
    pub(super) fn ask(
        &mut self,
        to: NodeId,
        ask: &Ask,
        within: Duration,
        answer: oneshot::Sender<Result<Answer, Refusal>>,
    ) {
        let now = self.shared.now();
        let until = now.plus_seconds(within.as_secs_f64());
        let bytes = self.bus.body_bytes().saturating_sub(PART_BYTES);
        let Some((id, sendable)) = self.asks.begin(to, ask, until, bytes, answer) else {
            return;
        };
        if !self.post_ask(now, to, id, sendable) {
            let what = format!("the way to node {to} (too much is waiting on it)");
            self.asks.failed(id, Refusal::NotRunning { what });
        }
    }

    /// Whether it could be put on its way.
    fn post_ask(&mut self, now: NodeTime, to: NodeId, id: u64, sendable: Sendable) -> bool {
        match sendable {
            Sendable::Pieces(pieces) => pieces.into_iter().all(|piece| {
                let number = self.post(now, to, &NodeMessage::Piece(piece.clone()));
                number.is_some_and(|number| {
                    self.asks.carried(to, number, &piece);
                    true
                })
            }),
            Sendable::Large(large) => self.send_whole(now, to, large).is_some_and(|number| {
                self.asks.carried_whole(number, id);
                true
            }),
        }
    }

    fn send_whole(&mut self, now: NodeTime, to: NodeId, large: Large) -> Option<u64> {
        let bytes = minicbor::to_vec(large).ok()?;
        self.bus.send(now, to, bytes).ok()
    }

    /// Answers another node.
    pub(super) fn served(&mut self, to: NodeId, id: u64, answer: &Answer) {
        let now = self.shared.now();
        let bytes = self.bus.body_bytes().saturating_sub(PART_BYTES);
        match answering(id, answer, bytes) {
            Ok(Sendable::Pieces(pieces)) => {
                for piece in pieces {
                    self.post(now, to, &NodeMessage::Piece(piece));
                }
            }
            Ok(Sendable::Large(large)) => {
                // One that is not taken, because too much is on its way already, is an answer that does not come.
                let _ = self.send_whole(now, to, large);
            }
            Err(error) => tracing::warn!("node {to} gets no answer: {error}"),
        }
    }
}
