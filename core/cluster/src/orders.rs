//! What a coordinator tells everybody: its intent, and what its successor needs to go on. One value, so that both are always of the same
//! moment.
//!
//! Must never do: judge whether it is obeyed; that is the leadership's.

use serde::{Deserialize, Serialize};
use skein_coordination::Coordination;
use skein_domain::{Intent, SwarmFrame, VehicleId};
use skein_failover::Term;
use skein_state::SharedState;
use std::collections::BTreeMap;

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

impl Orders {
    /// As they are in the shared state of the node that coordinates.
    #[must_use]
    pub fn of(shared: &SharedState, term: Term, recalled: &BTreeMap<VehicleId, u32>) -> Self {
        Self {
            term,
            intent: shared.coordination.intent().as_ref().clone(),
            coordination: shared.coordination.read().clone(),
            recalled: recalled.clone(),
            frame: shared.frame(),
        }
    }

    /// Puts them on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.intent.put_on_clock_ahead_by(ahead_us);
        self.coordination.put_on_clock_ahead_by(ahead_us);
    }

    /// Takes them up on a node that obeys them.
    pub fn take_up(self, shared: &SharedState) {
        let Self {
            mut intent,
            coordination,
            recalled,
            ..
        } = self;
        let former = shared.coordination.intent().leader;
        let records = shared.vehicles.records();
        // What it decided before it knew that an operator had taken a vehicle out.
        for withdrawn in shared.vehicles.obey_recalls(&recalled) {
            intent.tasks.remove(&withdrawn);
        }
        if former != intent.leader {
            // The anchor of a former leader must not be followed.
            for record in records.iter().filter(|record| Some(record.id) != intent.leader) {
                record.forget_anchor();
            }
        }
        shared.coordination.obey(intent, coordination);
    }
}
