//! What a coordinator tells everybody: its intent, and what its successor needs to go on. One value, so that both are always of the same
//! moment.
//!
//! Must never do: judge whether it is obeyed; that is the office's.

use crate::board::Board;
use crate::coordination::Coordination;
use serde::{Deserialize, Serialize};
use skein_domain::{Intent, SwarmFrame, VehicleId};
use skein_failover::Term;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Orders of a term. Moments are by the coordinator's clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Orders {
    /// In which term.
    pub term: Term,
    /// What is wanted.
    pub intent: Intent,
    /// What a successor needs.
    pub coordination: Coordination,
    /// Withdrawals of vehicles that are called back: which one of each.
    pub recalled: BTreeMap<VehicleId, u32>,
    /// The swarm's frame.
    pub frame: Option<SwarmFrame>,
}

/// Versions of intents of a term are greater than all of earlier terms, whatever was published in those and not heard by everybody.
#[must_use]
pub fn first_version(term: Term) -> u64 {
    (term.number & 0xFFFF_FFFF) << 32
}

impl Orders {
    /// As they stand on the board of the node that coordinates.
    #[must_use]
    pub fn of(board: &Board, term: Term, recalled: &BTreeMap<VehicleId, u32>) -> Self {
        Self {
            term,
            intent: board.intent.load().as_ref().clone(),
            coordination: board.coordination.lock().clone(),
            recalled: recalled.clone(),
            frame: board.frame(),
        }
    }

    /// Puts them on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.intent.put_on_clock_ahead_by(ahead_us);
        self.coordination.put_on_clock_ahead_by(ahead_us);
    }

    /// Takes them up on a node that obeys them.
    pub fn take_up(self, board: &Board) {
        let Self {
            mut intent,
            coordination,
            recalled,
            ..
        } = self;
        let former = board.intent.load().leader;
        let cells = board.cells();
        {
            let mut withdrawn = board.withdrawn.lock();
            for cell in &cells {
                if recalled.get(&cell.id) == Some(&cell.withdrawals()) {
                    withdrawn.remove(&cell.id);
                }
                // Decided before it was known that an operator had taken the vehicle out.
                if withdrawn.contains(&cell.id) {
                    intent.tasks.remove(&cell.id);
                }
            }
        }
        if former != intent.leader {
            // The anchor of a former leader must not be followed.
            for cell in cells.iter().filter(|cell| Some(cell.id) != intent.leader) {
                cell.state.lock().anchor = None;
            }
        }
        *board.coordination.lock() = coordination;
        board.intent.store(Arc::new(intent));
    }
}
