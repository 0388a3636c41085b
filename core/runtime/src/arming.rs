//! The preflight report of vehicles and swarm: what is known of them, put into the pure checks; what plugins add; whether a vehicle may be armed.
//!
//! Must never do: judge. What is red is `skein-safety`'s and the plugins' to say.

use skein_domain::exchange::Severity;
use skein_domain::preflight::{PreflightItem, PreflightReport};
use skein_domain::{LandedState, NodeTime, PositionNed, Refusal};
use skein_safety::preflight::{self, NamedRunning, SwarmChecks, SystemIdUse, VehicleChecks};
use skein_state::{SharedState, VehicleRecord};
use skein_view::PeerEntry;
use skein_view::{ActorStatus, EventKind};

/// Most items that one plugin may add.
const MOST_ITEMS: usize = 64;

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
/// [`Refusal::Preflight`] with the red items; [`Refusal::NotPermitted`] while the node's version is exchanged.
pub fn may_arm(shared: &SharedState, record: &VehicleRecord) -> Result<(), Refusal> {
    not_held(shared)?;
    let now = shared.now();
    let overrides = shared.operators.overrides(now);
    let reports = [vehicle_report(shared, record, now), swarm_report(shared, now)];
    for report in &reports {
        preflight::may_arm(report, &overrides, now)?;
    }
    for used in reports
        .iter()
        .flat_map(|report| preflight::used_overrides(report, &overrides, now))
    {
        let text = format!(
            "{}: armed although red: {} ({}, overridden by {})",
            record.name,
            used.items.join(", "),
            used.reason,
            used.operator
        );
        shared
            .events
            .record(now, Some(record.id), Severity::Warning, EventKind::Preflight, text);
    }
    Ok(())
}

/// Whether nothing is armed for the sake of another version of the program.
///
/// # Errors
/// [`Refusal::NotPermitted`] while it is so.
pub fn not_held(shared: &SharedState) -> Result<(), Refusal> {
    if shared.is_arming_held() {
        return Err(Refusal::not_permitted(
            "the node's version is being exchanged: nothing is armed until the new one has confirmed itself",
        ));
    }
    Ok(())
}

pub(crate) fn vehicle_report(shared: &SharedState, record: &VehicleRecord, now: NodeTime) -> PreflightReport {
    let peers = shared.peers();
    let settings = &shared.config.safety.preflight;
    let Some(entry) = peers.entry(record.id) else {
        return PreflightReport {
            vehicle: Some(record.id),
            made_at: now,
            ..PreflightReport::default()
        };
    };
    let mut report = preflight::vehicle_report(&checks(shared, record, entry, now), settings, now);
    report.items.extend(record.state().preflight.iter().cloned());
    for payload in record.payloads() {
        report.items.extend(payload.state().preflight.iter().cloned());
    }
    report.finished()
}

fn checks(shared: &SharedState, record: &VehicleRecord, entry: &PeerEntry, now: NodeTime) -> VehicleChecks {
    let gate = shared.gate();
    let fences = gate.fences();
    let position = entry.kinematics.map(|k| k.position);
    let running = |status: ActorStatus| status == ActorStatus::Running;
    let model = record.model.health().clone();
    // Each lock is let go before the next is taken: within one expression all would be held to its end, and the monitor over the vehicle
    // takes these two the other way round.
    let alarms = record.failsafe.lock().would_act(&shared.config.safety.failsafe);
    let limits_known = record.state().limits.is_some();
    VehicleChecks {
        // The ground is wherever it is: only the outline counts there.
        inside_fence: position.map(|at| fences.landing(&at).is_ok()),
        has_fence: !fences.is_empty(),
        model: Some(NamedRunning {
            running: running(model.status),
            name: model.plugin,
        }),
        payloads: record
            .payloads()
            .iter()
            .map(|payload| NamedRunning {
                name: payload.name.clone(),
                running: running(payload.life.health().status),
            })
            .collect(),
        limits_known: Some(limits_known),
        system_id: system_id_use(shared, record),
        alarms: Some(alarms),
        ..VehicleChecks::observed(record.id, &entry.telemetry, &entry.link, now)
    }
}

fn system_id_use(shared: &SharedState, record: &VehicleRecord) -> SystemIdUse {
    if record.link().is_shared() {
        return SystemIdUse::Shared;
    }
    let others = shared.vehicles.unadopted();
    if others.iter().any(|other| other.system_id == record.system_id) {
        SystemIdUse::Elsewhere
    } else {
        SystemIdUse::Alone
    }
}

pub(crate) fn swarm_report(shared: &SharedState, now: NodeTime) -> PreflightReport {
    let peers = shared.peers();
    let gate = shared.gate();
    let fences = gate.fences();
    let heard = || peers.entries.iter().filter(|e| e.link.connected);
    let standing = |e: &&PeerEntry| !e.airborne && e.telemetry.landed == LandedState::OnGround;
    let home_is_outside = |home: &PositionNed| fences.landing(home).is_err();
    let coordinator_age_s = now.seconds_since(shared.coordinator_seen());
    let capable = (shared.vehicles.records().iter())
        .filter(|record| record.state().capability.is_some_and(|c| c.capable))
        .count();
    let checks = SwarmChecks {
        frame_known: shared.frame().is_some(),
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
    preflight::swarm_report(&checks, &shared.config.safety.preflight, now).finished()
}

/// A coordinator that looked at its formation within this time runs, in seconds.
const COORDINATOR_SEEN_S: f64 = 1.0;
