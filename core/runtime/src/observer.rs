//! The observer actor: makes the picture of the fleet for screens, metrics and recorders, a few times a second, from what lies on
//! the shared state. Nothing in the control path waits for it.
//!
//! Bound: a picture that comes late is skipped. Must never do: change anything.

use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_coordination::Coordination;
use skein_domain::{NodeTime, VehicleId};
use skein_state::{SharedState, picture};
use skein_view::{ActorHealth, FleetSnapshot, FormationSnapshot, PeerSnapshot, VehicleSnapshot};
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
    shared: Arc<SharedState>,
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
    type Arguments = Arc<SharedState>;

    async fn pre_start(
        &self,
        myself: ActorRef<Look>,
        shared: Arc<SharedState>,
    ) -> Result<ObserverState, ActorProcessingErr> {
        let period = Duration::from_secs_f64(1.0 / shared.config.node.snapshot_rate_hz);
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
        let sequence = shared.picture().sequence;
        Ok(ObserverState {
            shared,
            sequence,
            looks,
        })
    }

    async fn handle(&self, _: ActorRef<Look>, _: Look, state: &mut ObserverState) -> Result<(), ActorProcessingErr> {
        state.sequence += 1;
        state.shared.publish_picture(fleet(&state.shared, state.sequence));
        Ok(())
    }
}

fn fleet(shared: &SharedState, sequence: u64) -> FleetSnapshot {
    let now = shared.now();
    let peers = shared.peers();
    let coordination = shared.coordination.read().clone();
    let intent_version = shared.coordination.intent().version;
    let leader = coordination.formation.as_ref().and_then(|f| f.leader);
    let actors: Vec<ActorHealth> = shared.actors();
    FleetSnapshot {
        time: now,
        sequence,
        frame: shared.frame(),
        vehicles: vehicles(shared, &peers, leader, now),
        unadopted: shared.vehicles.unadopted(),
        formation: formation(&coordination, &peers, intent_version, now),
        actors,
        tracks: shared.observed.estimates(),
        swarm: shared.swarm.as_ref().map(|swarm| swarm.picture().as_ref().clone()),
        resume: shared.resume.question(),
    }
}

/// This node's and those of the swarm's other nodes, by ascending id.
fn vehicles(
    shared: &SharedState,
    peers: &PeerSnapshot,
    leader: Option<VehicleId>,
    now: NodeTime,
) -> Vec<VehicleSnapshot> {
    let node = shared.swarm.as_ref().map(|swarm| swarm.role().node);
    let records = shared.vehicles.records();
    let mut all: Vec<VehicleSnapshot> = records
        .iter()
        .filter_map(|record| picture::vehicle(shared, record, peers, leader, now))
        .map(|vehicle| VehicleSnapshot { node, ..vehicle })
        .collect();
    if let Some(swarm) = &shared.swarm {
        let remote = swarm.vehicles();
        let others = remote.iter().filter(|(id, _)| shared.vehicles.record(**id).is_none());
        all.extend(others.filter_map(|(id, remote)| remote.snapshot(peers.entry(*id)?, leader, now)));
        all.sort_by_key(|vehicle| vehicle.id);
    }
    all
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
