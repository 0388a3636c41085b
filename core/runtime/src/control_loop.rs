//! The control loop's actor: the one clock of the control path. Once per period it reads all links, publishes one immutable picture of all
//! vehicles, and wakes each vehicle actor once.
//!
//! Bound: a period that comes late is skipped, never caught up; a vehicle that has not taken up its last tick gets no second one.
//! Must never do: wait for a vehicle.

use crate::surroundings;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::exchange::Severity;
use skein_domain::{NodeTime, VehicleId};
use skein_state::{SharedState, VehicleMessage};
use skein_view::EventKind;
use skein_view::{PeerEntry, PeerSnapshot, airborne, kinematics};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::MissedTickBehavior;

/// The actor.
pub struct ControlLoop;

/// One tick of the clock.
pub struct ControlTick;

/// State: the shared state and the task that ticks.
pub struct ControlLoopState {
    shared: Arc<SharedState>,
    ticks: JoinHandle<()>,
}

impl Drop for ControlLoopState {
    fn drop(&mut self) {
        self.ticks.abort();
    }
}

impl Actor for ControlLoop {
    type Msg = ControlTick;
    type State = ControlLoopState;
    type Arguments = Arc<SharedState>;

    async fn pre_start(
        &self,
        myself: ActorRef<ControlTick>,
        shared: Arc<SharedState>,
    ) -> Result<ControlLoopState, ActorProcessingErr> {
        let period = Duration::from_secs_f64(1.0 / shared.config.node.control_rate_hz);
        let ticks = tokio::spawn(async move {
            let mut interval = tokio::time::interval(period);
            interval.set_missed_tick_behavior(MissedTickBehavior::Skip);
            loop {
                interval.tick().await;
                if myself.cast(ControlTick).is_err() {
                    return;
                }
            }
        });
        Ok(ControlLoopState { shared, ticks })
    }

    async fn handle(
        &self,
        _: ActorRef<ControlTick>,
        _: ControlTick,
        state: &mut ControlLoopState,
    ) -> Result<(), ActorProcessingErr> {
        let (shared, now) = (&state.shared, state.shared.now());
        let period_s = 1.0 / shared.config.node.control_rate_hz;
        let told = shared.note_tick(now, period_s);
        if let Some((severity, kind, text)) = told {
            shared.events.record(now, None, severity, kind, text);
        }
        tick(shared);
        Ok(())
    }
}

/// One control period of the node.
fn tick(shared: &SharedState) {
    let now = shared.now();
    let records = shared.vehicles.records();
    let mut entries = Vec::with_capacity(records.len());
    for record in &records {
        let (mut telemetry, link) = record.link().read(now);
        telemetry.simulated |= record.simulated;
        if shared.frame().is_none()
            && shared.may_fix_frame(now)
            && let Some(place) = shared.resume.origin().or(telemetry.home).or(telemetry.global)
            && telemetry.local_frame.is_some()
            && shared.fix_frame(place)
        {
            let text = format!(
                "swarm frame fixed at {:.7}, {:.7}, {:.1} m AMSL, the place of {}",
                place.latitude_deg, place.longitude_deg, place.altitude_amsl_m, record.name
            );
            shared
                .events
                .record(now, Some(record.id), Severity::Info, EventKind::Notice, text);
        }
        let frame = shared.frame();
        let (flight_state, anchor, limits) = {
            let published = record.state();
            (published.flight_state, published.anchor, published.limits)
        };
        let (under_order, may_rejoin, energy) = {
            let monitor = record.failsafe.lock();
            (monitor.is_under_order(), monitor.may_rejoin(), monitor.energy())
        };
        entries.push(PeerEntry {
            id: record.id,
            kinematics: frame.as_ref().and_then(|f| kinematics(f, &telemetry)),
            airborne: airborne(&telemetry),
            home: frame.zip(telemetry.home).map(|(f, home)| f.position(&home)),
            telemetry,
            link,
            flight_state,
            anchor,
            limits,
            under_order,
            may_rejoin,
            energy,
        });
    }
    add_others(shared, &mut entries, now);
    publish(shared, entries, now);
    for record in &records {
        record.actor.send_tick(VehicleMessage::Tick);
    }
    for record in &records {
        for payload in record.payloads() {
            payload.send_due_tick(now);
        }
    }
}

/// Adds the vehicles of the swarm's other nodes. Where two nodes claim one id, this node's own is what it knows best.
fn add_others(shared: &SharedState, entries: &mut Vec<PeerEntry>, now: NodeTime) {
    let Some(swarm) = &shared.swarm else { return };
    let others = swarm.peers(shared.config.link.lost_after_s, shared.frame(), now);
    if let (None, true) = (shared.frame(), shared.may_fix_frame(now))
        && let Some(place) = others.iter().find_map(|e| e.telemetry.home.or(e.telemetry.global))
    {
        shared.fix_frame(place);
    }
    let own: BTreeSet<VehicleId> = entries.iter().map(|e| e.id).collect();
    entries.extend(others.into_iter().filter(|e| !own.contains(&e.id)));
    entries.sort_by_key(|e| e.id);
}

fn publish(shared: &SharedState, entries: Vec<PeerEntry>, now: NodeTime) {
    let surroundings = surroundings::surroundings(shared, &entries, now);
    let led = entries.iter().find_map(|e| e.anchor);
    let (references, gate) = (&shared.observed.references, shared.gate());
    let (anchor, held) = (shared.coordination).work_out_anchor(led.as_ref(), references, gate.fences(), now);
    if let Some(is_held) = held {
        tell_held(shared, is_held, now);
    }
    shared.publish_peers(PeerSnapshot {
        made: now,
        entries,
        surroundings,
        anchor,
    });
}

/// Tells that a formation waits at a fence, or no longer.
fn tell_held(shared: &SharedState, is_held: bool, now: NodeTime) {
    let (severity, text) = if is_held {
        let text = "the formation waits: after its reference not all of its places would be inside of the fences";
        (Severity::Warning, text)
    } else {
        (Severity::Info, "the formation no longer waits at a fence")
    };
    shared.events.record(now, None, severity, EventKind::Formation, text);
}
