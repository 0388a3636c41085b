//! The observer actor: makes the picture of the fleet for screens, metrics and recorders, a few times a second, from what lies on
//! the board. Nothing in the control path waits for it.
//!
//! Bound: a picture that comes late is skipped. Must never do: change anything.

use crate::board::{Board, PeerSnapshot, VehicleCell};
use crate::coordination::Coordination;
use crate::payload::PayloadCell;
use crate::snapshot::{
    ActorHealth, ActorStatus, FleetSnapshot, FormationSnapshot, PayloadSnapshot, PluginHealth, VehicleSnapshot,
};
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::{NodeTime, PositionNed, VehicleId};
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::MissedTickBehavior;

/// The actor.
pub struct Observer;

/// Make a picture.
pub struct Look;

/// State.
pub struct ObserverState {
    board: Arc<Board>,
    sequence: u64,
    looks: JoinHandle<()>,
}

impl Drop for ObserverState {
    fn drop(&mut self) {
        self.looks.abort();
    }
}

impl Actor for Observer {
    type Msg = Look;
    type State = ObserverState;
    type Arguments = Arc<Board>;

    async fn pre_start(&self, myself: ActorRef<Look>, board: Arc<Board>) -> Result<ObserverState, ActorProcessingErr> {
        let period = Duration::from_secs_f64(1.0 / board.config.node.snapshot_rate_hz);
        let looks = tokio::spawn(async move {
            let mut interval = tokio::time::interval(period);
            interval.set_missed_tick_behavior(MissedTickBehavior::Skip);
            loop {
                interval.tick().await;
                if myself.cast(Look).is_err() {
                    return;
                }
            }
        });
        let sequence = board.picture.load().sequence;
        Ok(ObserverState { board, sequence, looks })
    }

    async fn handle(&self, _: ActorRef<Look>, _: Look, state: &mut ObserverState) -> Result<(), ActorProcessingErr> {
        state.sequence += 1;
        state
            .board
            .picture
            .store(Arc::new(picture(&state.board, state.sequence)));
        Ok(())
    }
}

fn picture(board: &Board, sequence: u64) -> FleetSnapshot {
    let now = board.now();
    let peers = board.peers.load_full();
    let coordination = board.coordination.lock().clone();
    let intent_version = board.intent.load().version;
    let leader = coordination.formation.as_ref().and_then(|f| f.leader);
    let actors: Vec<ActorHealth> = board.actors.lock().values().cloned().collect();
    FleetSnapshot {
        time: now,
        sequence,
        frame: board.frame(),
        vehicles: vehicles(board, &peers, leader, now),
        unadopted: board.unadopted.lock().clone(),
        formation: formation(&coordination, &peers, intent_version, now),
        actors,
        tracks: board.tracks.load().as_ref().clone(),
        swarm: board.swarm.as_ref().map(|swarm| swarm.picture.load().as_ref().clone()),
        resume: board.resume.question(),
    }
}

/// This node's and those of the swarm's other nodes, by ascending id.
fn vehicles(board: &Board, peers: &PeerSnapshot, leader: Option<VehicleId>, now: NodeTime) -> Vec<VehicleSnapshot> {
    let node = board.swarm.as_ref().map(|swarm| swarm.role.load().node);
    let cells = board.cells();
    let mut all: Vec<VehicleSnapshot> = cells
        .iter()
        .filter_map(|cell| vehicle(board, cell, peers, leader, now))
        .map(|vehicle| VehicleSnapshot { node, ..vehicle })
        .collect();
    if let Some(swarm) = &board.swarm {
        let remote = swarm.vehicles.read();
        let others = remote.iter().filter(|(id, _)| board.cell(**id).is_none());
        all.extend(others.filter_map(|(id, remote)| remote.snapshot(peers.entry(*id)?, leader, now)));
        all.sort_by_key(|vehicle| vehicle.id);
    }
    all
}

pub(crate) fn vehicle(
    board: &Board,
    cell: &VehicleCell,
    peers: &PeerSnapshot,
    leader: Option<VehicleId>,
    now: NodeTime,
) -> Option<VehicleSnapshot> {
    let entry = peers.entry(cell.id)?;
    let telemetry = &entry.telemetry;
    let state = cell.state.lock().clone();
    let model = cell.model.health.lock().clone();
    let payloads: Vec<PayloadSnapshot> = cell.payloads().iter().map(|cell| payload(cell)).collect();
    let slot: Option<PositionNed> = state
        .setpoint
        .filter(|_| state.flight_state.is_available_in_air())
        .and_then(|s| s.position);
    Some(VehicleSnapshot {
        id: cell.id,
        node: None,
        name: cell.name.clone(),
        simulated: telemetry.simulated || board.config.node.simulated,
        system_id: cell.system_id,
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
        ways: cell.link.load().0.ways(now),
        age_s: now.seconds_since(entry.link.last_heard).max(0.0),
        tracking_error_m: state.tracking_error_m.filter(|_| slot.is_some()),
        slot,
        is_leader: leader == Some(cell.id),
        actor: state.actor,
        degraded: degraded(&model, &payloads),
        model,
        model_state: state.model_state,
        avoiding: state.avoiding,
        ladder: state.ladder,
        energy: entry.energy,
        stopped: cell.is_stopped(),
        limits: state.limits,
        capability: state.capability,
        payloads,
    })
}

fn payload(cell: &PayloadCell) -> PayloadSnapshot {
    let published = cell.state.lock().clone();
    PayloadSnapshot {
        name: cell.name.clone(),
        kind: cell.kind,
        actor: published.actor,
        plugin: cell.life.health.lock().clone(),
        state: published.report.map(|report| report.value.as_ref().clone()),
        transport_fault: published.transport_fault,
        frame: cell.frame.load().as_ref().map(|frame| frame.header.clone()),
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

fn formation(
    coordination: &Coordination,
    peers: &PeerSnapshot,
    intent_version: u64,
    now: NodeTime,
) -> Option<FormationSnapshot> {
    let formation = coordination.formation.as_ref()?;
    Some(FormationSnapshot {
        request: formation.request.clone(),
        leader: formation.leader,
        anchor: match formation.leader {
            Some(leader) => peers.entry(leader).and_then(|e| e.anchor),
            None => peers.anchor,
        }
        .map(|anchor| anchor.position),
        keeps_itself: formation.keeps_itself(now),
        max_speed_m_s: formation.max_speed_m_s,
        members: formation.members.clone(),
        view_blocked: formation.view_blocked.clone(),
        route: coordination.route.as_ref().map(|r| r.route.clone()),
        route_finished: coordination.route.as_ref().is_some_and(|r| r.finished),
        settled_at: formation.settled_at,
        planned_min_distance_m: formation.apart_m(),
        intent_version,
    })
}
