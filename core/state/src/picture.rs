//! A vehicle of this node as screens see it, here and at other nodes.
//!
//! Must never do: wait for the vehicle's actor.

use crate::payload::PayloadRecord;
use crate::shared::SharedState;
use crate::vehicle::VehicleRecord;
use skein_domain::{NodeTime, PositionNed, VehicleId};
use skein_view::{ActorStatus, PayloadSnapshot, PeerSnapshot, PluginHealth, VehicleSnapshot};

/// A vehicle of this node as screens see it; nothing before its first control period.
#[must_use]
pub fn vehicle(
    shared: &SharedState,
    record: &VehicleRecord,
    peers: &PeerSnapshot,
    leader: Option<VehicleId>,
    now: NodeTime,
) -> Option<VehicleSnapshot> {
    let entry = peers.entry(record.id)?;
    let telemetry = &entry.telemetry;
    let state = record.state().clone();
    let model = record.model.health().clone();
    let payloads: Vec<PayloadSnapshot> = record.payloads().iter().map(|record| payload(record)).collect();
    let slot: Option<PositionNed> = state
        .setpoint
        .filter(|_| state.flight_state.is_available_in_air())
        .and_then(|s| s.position);
    Some(VehicleSnapshot {
        id: record.id,
        node: None,
        name: record.name.clone(),
        simulated: telemetry.simulated || shared.config.node.simulated,
        system_id: record.system_id,
        plugin: model.plugin.clone(),
        plugin_version: model.version.clone(),
        flight_state: state.flight_state,
        state_detail: state.detail,
        mode: telemetry.mode,
        armed: telemetry.armed,
        landed: telemetry.landed,
        ready_to_arm: telemetry.ready_to_arm,
        global: telemetry.global,
        kinematics: entry.kinematics,
        roll_rad: telemetry.roll_rad,
        pitch_rad: telemetry.pitch_rad,
        home: telemetry.home,
        battery: telemetry.battery,
        gnss: telemetry.gnss,
        link: entry.link,
        ways: record.link().ways(now),
        age_s: now.seconds_since(entry.link.last_heard).max(0.0),
        tracking_error_m: state.tracking_error_m.filter(|_| slot.is_some()),
        slot,
        is_leader: leader == Some(record.id),
        actor: state.actor,
        degraded: degraded(&model, &payloads),
        model,
        model_state: state.model_state,
        avoiding: state.avoiding,
        failsafe: state.failsafe,
        energy: entry.energy,
        stopped: record.is_stopped(),
        limits: state.limits,
        capability: state.capability,
        payloads,
    })
}

fn payload(record: &PayloadRecord) -> PayloadSnapshot {
    let published = record.state().clone();
    PayloadSnapshot {
        name: record.name.clone(),
        kind: record.kind,
        actor: published.actor,
        plugin: record.life.health().clone(),
        state: published.report.map(|report| report.value.as_ref().clone()),
        transport_fault: published.transport_fault,
        frame: record.frame().as_ref().map(|frame| frame.header.clone()),
    }
}

/// What a vehicle lacks of what it was built for.
fn degraded(model: &PluginHealth, payloads: &[PayloadSnapshot]) -> Vec<String> {
    let mut why = Vec::new();
    if model.status == ActorStatus::GivenUp {
        why.push(format!("model failed too often: {}", model.last_error));
    }
    for payload in payloads {
        if payload.plugin.status == ActorStatus::GivenUp || payload.actor.status == ActorStatus::GivenUp {
            why.push(format!(
                "{} failed too often: {}",
                payload.name, payload.plugin.last_error
            ));
        }
    }
    why
}
