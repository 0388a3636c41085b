//! The preflight reports as they are asked for, of this node and of others; who overrides what.
//!
//! Must never do: judge. What is red is `skein-safety`'s and the plugins' to say.

use super::NodeHandle;
use crate::arming::{swarm_report, vehicle_report};
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::preflight::{PreflightOverride, PreflightReport};
use skein_domain::{NodeId, Refusal};
use skein_state::asks::{Answer, Ask};
use skein_view::EventKind;
use std::collections::BTreeSet;
use std::time::Duration;

/// Longest wait for another node's reports.
const ELSEWHERE_WITHIN: Duration = Duration::from_secs(2);

/// The reports of the swarm and of all its vehicles.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct PreflightAnswer {
    /// What concerns all of them.
    pub swarm: PreflightReport,
    /// Each vehicle, by ascending id.
    pub vehicles: Vec<PreflightReport>,
    /// Overrides that hold.
    pub overrides: Vec<PreflightOverride>,
}

impl PreflightAnswer {
    /// Whether no item of any report keeps from arming.
    #[must_use]
    pub fn is_green(&self) -> bool {
        let mut reports = self.vehicles.iter().chain([&self.swarm]);
        reports.all(|report| report.blocking().next().is_none())
    }
}

impl NodeHandle {
    /// What was found before arming, item by item.
    #[must_use]
    pub fn preflight(&self) -> PreflightAnswer {
        let (shared, now) = (self.shared(), self.now());
        PreflightAnswer {
            swarm: swarm_report(shared, now),
            vehicles: (shared.vehicles.records().iter())
                .map(|record| vehicle_report(shared, record, now))
                .collect(),
            overrides: shared.operators.overrides(now),
        }
    }

    /// The same with the vehicles of the swarm's other nodes, as those nodes see them. One that does not answer is left out: its vehicles are
    /// not heard either.
    pub async fn preflight_everywhere(&self) -> PreflightAnswer {
        let mut answer = self.preflight();
        let Some(swarm) = &self.shared().swarm else {
            return answer;
        };
        let nodes: BTreeSet<NodeId> = swarm.vehicles().values().map(|v| v.node).collect();
        let asked: Vec<_> = nodes
            .into_iter()
            .map(|node| {
                let handle = self.clone();
                tokio::spawn(async move { handle.ask(node, Ask::Preflight, ELSEWHERE_WITHIN).await })
            })
            .collect();
        for reports in asked {
            if let Ok(Ok(Answer::Preflight(reports))) = reports.await {
                let now = self.now();
                answer.vehicles.extend(
                    reports
                        .into_iter()
                        .map(|report| PreflightReport { made_at: now, ..report }),
                );
            }
        }
        answer.vehicles.sort_by_key(|report| report.vehicle);
        answer
    }

    /// Takes red items upon an operator who may do so. Recorded, and again when a vehicle is armed by it. Who may is the caller's to know.
    ///
    /// # Errors
    /// For items that nobody can override, without a reason, or for a vehicle that is not there.
    pub fn override_preflight(&self, given: PreflightOverride) -> Result<PreflightOverride, Refusal> {
        let (shared, now) = (self.shared(), self.now());
        let given = PreflightOverride { given_at: now, ..given };
        given.check()?;
        if let Some(vehicle) = given.vehicle.filter(|id| !shared.vehicle_ids().contains(id)) {
            return Err(Refusal::UnknownVehicle { vehicle });
        }
        shared.operators.override_items(&given, shared.swarm.is_some(), now);
        let text = format!(
            "preflight items overridden by {} for {:.0} s: {} ({})",
            given.operator,
            given.valid_s,
            given.items.join(", "),
            given.reason
        );
        shared
            .events
            .record(now, given.vehicle, Severity::Warning, EventKind::Preflight, text);
        Ok(given)
    }
}
