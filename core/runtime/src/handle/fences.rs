//! Fences while the node runs: what they are, and others in their place.
//!
//! Must never do: leave the node without the fences it had because new ones are wrong.

use super::NodeHandle;
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::fence::FencePlan;
use skein_domain::{Refusal, VehicleId};
use skein_state::asks::Ask;
use skein_state::cluster::share::first_version;
use skein_view::EventKind;

/// The fences in force.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FenceAnswer {
    /// As they were described.
    pub plan: FencePlan,
    /// Vehicles in the air that are outside of them now, and what they do about it stands with each fence.
    pub outside: Vec<VehicleId>,
}

impl NodeHandle {
    /// The fences in force.
    #[must_use]
    pub fn fences(&self) -> FenceAnswer {
        let shared = self.shared();
        let gate = shared.gate();
        let peers = shared.peers();
        let outside = |e: &&skein_view::PeerEntry| {
            let place = e.kinematics.map(|k| k.position);
            e.airborne && place.is_some_and(|at| gate.fences().breach(&at).is_some())
        };
        FenceAnswer {
            plan: shared.fence_plan(),
            outside: peers.entries.iter().filter(outside).map(|e| e.id).collect(),
        }
    }

    /// Other fences from now on, for every setpoint and goal. Vehicles that are outside then do what the fence says.
    ///
    /// # Errors
    /// When a zone cannot be one, or cannot be placed because the swarm's origin is not known yet. The former ones stay.
    pub async fn set_fences(&self, plan: FencePlan) -> Result<FenceAnswer, Refusal> {
        match self.coordinator_elsewhere()? {
            None => self.set_fences_here(plan)?,
            Some(node) => {
                self.done(node, Ask::Fences(Box::new(plan.clone()))).await?;
                // They come over the swarm as well, when they come.
                let _ = self.shared().set_fences(plan);
            }
        }
        Ok(self.fences())
    }

    /// Puts fences in force as the coordinator's node does it: for the whole swarm.
    pub(crate) fn set_fences_here(&self, plan: FencePlan) -> Result<(), Refusal> {
        let count = plan.zones.len();
        self.shared()
            .set_fences(plan)
            .map_err(|e| Refusal::invalid(e.to_string()))?;
        if let Some(swarm) = &self.shared().swarm {
            let term = swarm.role().acting;
            let mut revision = swarm.fence_revision();
            *revision = (*revision + 1).max(term.map_or(0, first_version) + 1);
        }
        let text = format!("{count} fence zones are in force");
        self.shared()
            .events
            .record(self.now(), None, Severity::Advisory, EventKind::Fences, text);
        Ok(())
    }
}
