//! Decisions with all that they were made from.
//!
//! Must never do: name a gate or a control period that the file does not hold, except where the recorder thinned the period out.

use super::{Encoder, Said};
use skein_domain::NodeTime;
use skein_recording::decisions::{FailsafeDecision, FormationDecision, GateState, LeadershipDecision, PeersRecord};
use skein_recording::{SetpointRecord, Topic};
use skein_safety::Gate;
use skein_safety::avoidance::{Change, NeighbourId};
use skein_state::{FailsafeStep, JudgedSetpoint, LeadershipTurn, MadePlan};
use skein_view::Avoidance;
use std::sync::Arc;

/// So many control periods are known to be in the file.
const PERIODS: usize = 32;

impl Encoder {
    pub(super) fn setpoint(&mut self, said: &mut Said, judged: &JudgedSetpoint) {
        let gate = self.gate(said, judged.at, &judged.gate);
        let made = judged.peers.made;
        if judged.with_period && !self.periods.contains(&made) {
            if self.periods.len() == PERIODS {
                self.periods.remove(0);
            }
            self.periods.push(made);
            said.json(Topic::Peers, made, &PeersRecord::of(&judged.peers));
        }
        let steered = judged.answer.outcome.as_ref().ok();
        let record = SetpointRecord {
            time: judged.at,
            vehicle: judged.vehicle,
            peers: Some(made),
            gate,
            asked: judged.asked,
            flown: steered.map(|steered| steered.setpoint),
            slowed: judged.answer.slowed.clone(),
            refusal: judged.answer.outcome.as_ref().err().cloned(),
            change: steered.and_then(|steered| steered.change.as_ref()).map(avoidance),
        };
        let record = if judged.with_period { record } else { record.thinned() };
        said.json(Topic::Setpoint(judged.vehicle), judged.at, &record);
    }

    pub(super) fn failsafe(&self, said: &mut Said, step: FailsafeStep) {
        let decision = FailsafeDecision {
            time: step.at,
            vehicle: step.vehicle,
            before: step.before,
            health: step.health,
            settings: self.node.config().safety.failsafe.clone(),
            events: serde_json::to_value(&step.events).unwrap_or_default(),
        };
        said.json(Topic::Failsafe, step.at, &decision);
    }

    pub(super) fn plan(&mut self, said: &mut Said, made: &MadePlan) {
        let gate = self.gate(said, made.at, &made.input.gate);
        let decision = FormationDecision::of(made.at, gate, &made.input, &made.peers, &made.outcome);
        said.json(Topic::Formation, made.at, &decision);
    }

    pub(super) fn leadership(said: &mut Said, turn: &LeadershipTurn) {
        let decision = LeadershipDecision {
            time: turn.at,
            monitor: turn.monitor.clone(),
            leadership: turn.leadership.clone(),
            turn: turn.turn,
        };
        said.json(Topic::Leadership, turn.at, &decision);
    }

    /// The number of a gate, which is told where it is another one than before.
    fn gate(&mut self, said: &mut Said, at: NodeTime, gate: &Arc<Gate>) -> u64 {
        if let Some((number, known)) = &self.gate
            && Arc::ptr_eq(known, gate)
        {
            return *number;
        }
        let number = self.gate.as_ref().map_or(0, |(number, _)| *number) + 1;
        self.gate = Some((number, gate.clone()));
        let state = GateState {
            time: at,
            number,
            limits: *gate.limits(),
            min_height_m: gate.min_height_m(),
            fences: self.node.fence_plan(),
            frame: self.node.frame(),
        };
        said.json(Topic::Gate, at, &state);
        number
    }
}

/// What was changed of a setpoint, as screens have it.
fn avoidance(change: &Change) -> Avoidance {
    Avoidance {
        by_m_s: change.by_m_s,
        because: change.because.map(|id| match id {
            NeighbourId::Vehicle(vehicle) => format!("vehicle {vehicle}"),
            NeighbourId::Foreign(_) => "something that is not ours".to_owned(),
        }),
        distance_m: Some(change.distance_m).filter(|m| m.is_finite()),
        predicted_m: Some(change.predicted_m).filter(|m| m.is_finite()),
        feasible: change.feasible,
    }
}
