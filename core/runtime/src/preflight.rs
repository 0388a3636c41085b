//! The preflight report of vehicles and swarm: what is on the board, put into the pure checks; what plugins add; who overrode what.
//!
//! Must never do: judge. What is red is `skein-safety`'s and the plugins' to say.

use crate::board::{Board, PeerEntry, VehicleCell};
use crate::handle::NodeHandle;
use crate::snapshot::{ActorStatus, EventKind};
use crate::swarm::asks::{Answer, Ask};
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::preflight::{PreflightItem, PreflightOverride, PreflightReport};
use skein_domain::{LandedState, NodeId, NodeTime, PositionNed, Refusal};
use skein_safety::preflight::{self, NamedRunning, SwarmChecks, SystemIdUse, VehicleChecks};
use std::collections::BTreeSet;
use std::time::Duration;

/// Longest wait for another node's reports.
const ELSEWHERE_WITHIN: Duration = Duration::from_secs(2);
/// Most items that one plugin may add.
const MOST_ITEMS: usize = 64;

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

/// A plugin's items under its own name, so that none passes for one of ours or of another plugin.
pub fn own_items(plugin: &str, items: Vec<PreflightItem>) -> Vec<PreflightItem> {
    let prefix = format!("{plugin}/");
    items
        .into_iter()
        .take(MOST_ITEMS)
        .map(|mut item| {
            if !item.id.starts_with(&prefix) {
                item.id = format!("{prefix}{}", item.id);
            }
            item
        })
        .collect()
}

/// Whether the vehicle may be armed as things stand. What somebody took upon himself is recorded when it is made use of.
///
/// # Errors
/// [`Refusal::Preflight`] with the red items.
pub fn may_arm(board: &Board, cell: &VehicleCell) -> Result<(), Refusal> {
    let now = board.now();
    let overrides = board.overrides.lock().clone();
    let reports = [vehicle_report(board, cell, now), swarm_report(board, now)];
    for report in &reports {
        preflight::may_arm(report, &overrides, now)?;
    }
    for used in reports
        .iter()
        .flat_map(|report| preflight::used_overrides(report, &overrides, now))
    {
        let text = format!(
            "{}: armed although red: {} ({}, overridden by {})",
            cell.name,
            used.items.join(", "),
            used.reason,
            used.operator
        );
        board
            .events
            .record(now, Some(cell.id), Severity::Warning, EventKind::Preflight, text);
    }
    Ok(())
}

fn vehicle_report(board: &Board, cell: &VehicleCell, now: NodeTime) -> PreflightReport {
    let peers = board.peers.load();
    let settings = &board.config.safety.preflight;
    let Some(entry) = peers.entry(cell.id) else {
        return PreflightReport {
            vehicle: Some(cell.id),
            made_at: now,
            ..PreflightReport::default()
        };
    };
    let mut report = preflight::vehicle_report(&checks(board, cell, entry, now), settings, now);
    report.items.extend(cell.state.lock().preflight.iter().cloned());
    for payload in cell.payloads() {
        report.items.extend(payload.state.lock().preflight.iter().cloned());
    }
    report.finished()
}

fn checks(board: &Board, cell: &VehicleCell, entry: &PeerEntry, now: NodeTime) -> VehicleChecks {
    let gate = board.gate();
    let fences = gate.fences();
    let position = entry.kinematics.map(|k| k.position);
    let running = |status: ActorStatus| status == ActorStatus::Running;
    let model = cell.model.health.lock().clone();
    // Each lock is let go before the next is taken: within one expression all would be held to its end, and the watch over the vehicle
    // takes these two the other way round.
    let alarms = cell.watch.lock().would_act(&board.config.safety.ladder);
    let limits_known = cell.state.lock().limits.is_some();
    VehicleChecks {
        // The ground is wherever it is: only the outline counts there.
        inside_fence: position.map(|at| fences.landing(&at).is_ok()),
        has_fence: !fences.is_empty(),
        model: Some(NamedRunning {
            running: running(model.status),
            name: model.plugin,
        }),
        payloads: cell
            .payloads()
            .iter()
            .map(|payload| NamedRunning {
                name: payload.name.clone(),
                running: running(payload.life.health.lock().status),
            })
            .collect(),
        limits_known: Some(limits_known),
        system_id: system_id_use(board, cell),
        alarms: Some(alarms),
        ..VehicleChecks::observed(cell.id, &entry.telemetry, &entry.link, now)
    }
}

fn system_id_use(board: &Board, cell: &VehicleCell) -> SystemIdUse {
    if cell.link.load().0.is_shared() {
        return SystemIdUse::Shared;
    }
    let others = board.unadopted.lock();
    if others.iter().any(|other| other.system_id == cell.system_id) {
        SystemIdUse::Elsewhere
    } else {
        SystemIdUse::Alone
    }
}

fn swarm_report(board: &Board, now: NodeTime) -> PreflightReport {
    let peers = board.peers.load();
    let gate = board.gate();
    let fences = gate.fences();
    let heard = || peers.entries.iter().filter(|e| e.link.connected);
    let standing = |e: &&PeerEntry| !e.airborne && e.telemetry.landed == LandedState::OnGround;
    let home_is_outside = |home: &PositionNed| fences.landing(home).is_err();
    let coordinator_age_s = now.seconds_since(board.coordinator_seen());
    let capable = board
        .cells()
        .iter()
        .filter(|cell| cell.state.lock().capability.is_some_and(|c| c.capable))
        .count();
    let checks = SwarmChecks {
        frame_known: board.frame().is_some(),
        on_ground: heard()
            .filter(standing)
            .filter_map(|e| Some((e.id, e.kinematics?.position)))
            .collect(),
        clock_offsets_s: heard()
            // Half the way there and back is what a measured offset can be wrong by.
            .filter_map(|e| Some((e.id, 0.5 * f64::from(e.link.round_trip_s?))))
            .collect(),
        coordinator_running: coordinator_age_s < COORDINATOR_SEEN_S,
        coordinator_capable: u32::try_from(capable).unwrap_or(u32::MAX),
        fences: Some(u32::try_from(fences.zones().len()).unwrap_or(u32::MAX)),
        homes_outside: heard()
            .filter(|e| e.home.as_ref().is_some_and(home_is_outside))
            .map(|e| e.id)
            .collect(),
        homes_unknown: heard().filter(|e| e.home.is_none()).map(|e| e.id).collect(),
    };
    preflight::swarm_report(&checks, &board.config.safety.preflight, now).finished()
}

/// A coordinator that looked at its formation within this time runs, in seconds.
const COORDINATOR_SEEN_S: f64 = 1.0;

impl NodeHandle {
    /// What was found before arming, item by item.
    #[must_use]
    pub fn preflight(&self) -> PreflightAnswer {
        let (board, now) = (self.board(), self.now());
        PreflightAnswer {
            swarm: swarm_report(board, now),
            vehicles: board
                .cells()
                .iter()
                .map(|cell| vehicle_report(board, cell, now))
                .collect(),
            overrides: holding(board, now),
        }
    }

    /// The same with the vehicles of the swarm's other nodes, as those nodes see them. One that does not answer is left out: its vehicles are
    /// not heard either.
    pub async fn preflight_everywhere(&self) -> PreflightAnswer {
        let mut answer = self.preflight();
        let Some(swarm) = &self.board().swarm else {
            return answer;
        };
        let nodes: BTreeSet<NodeId> = swarm.vehicles.read().values().map(|v| v.node).collect();
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
        let (board, now) = (self.board(), self.now());
        let given = PreflightOverride { given_at: now, ..given };
        given.check()?;
        if let Some(vehicle) = given.vehicle.filter(|id| !board.vehicle_ids().contains(id)) {
            return Err(Refusal::UnknownVehicle { vehicle });
        }
        let mut holding = holding(board, now);
        holding.push(given.clone());
        *board.overrides.lock() = holding;
        if board.swarm.is_some() {
            board.overrides_here.lock().push(given.clone());
        }
        let text = format!(
            "preflight items overridden by {} for {:.0} s: {} ({})",
            given.operator,
            given.valid_s,
            given.items.join(", "),
            given.reason
        );
        board
            .events
            .record(now, given.vehicle, Severity::Warning, EventKind::Preflight, text);
        Ok(given)
    }
}

fn holding(board: &Board, now: NodeTime) -> Vec<PreflightOverride> {
    let all = board.overrides.lock();
    let holds = |o: &&PreflightOverride| now.seconds_since(o.given_at) <= o.valid_s;
    all.iter().filter(holds).cloned().collect()
}
