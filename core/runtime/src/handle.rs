//! The typed handle to a running node: the only way in for the API, the demo and the tests. The actors' messages stay private.

mod trajectories;

use crate::board::Board;
use crate::coordinator::CoordinatorMessage;
use crate::node::Parts;
use crate::plugins::PluginOrder;
use crate::references::{ReferenceReport, ReferenceSnapshot};
use crate::returns;
use crate::snapshot::{EventKind, EventRecord, FleetSnapshot};
use crate::vehicle::VehicleMessage;
use crate::ways;
use ractor::RpcReplyPort;
use ractor::rpc::CallResult;
use serde::{Deserialize, Serialize};
use skein_config::NodeConfig;
use skein_domain::exchange::{FaultDrill, Severity};
use skein_domain::{
    AnchorReference, CommandId, FormationRequest, NodeTime, Refusal, Route, SlotMove, VehicleCommand, VehicleId,
};
use skein_link_px4::EndpointMetrics;
use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::sync::broadcast;

/// Whom a command is for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Targets {
    /// Every adopted vehicle.
    All,
    /// These vehicles.
    Vehicles(Vec<VehicleId>),
}

/// What became of a command at one vehicle: taken up (how it goes on comes as events), or refused.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct CommandReceipt {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The command's id; events about its progress carry it.
    pub id: CommandId,
    /// Why it was refused; absent if it was taken up.
    pub refusal: Option<Refusal>,
}

/// What a change of formation will look like.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationReceipt {
    /// Who leads; nobody if it is anchored to something else than a vehicle.
    pub leader: Option<VehicleId>,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// How long the change takes in seconds.
    pub duration_s: f64,
    /// Smallest distance between any two vehicles on the way, in metres.
    pub planned_min_distance_m: f64,
    /// How fast it can go as a whole, in metres per second.
    pub max_speed_m_s: f64,
    /// Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
    pub view_blocked: Vec<VehicleId>,
}

/// A fault to inject, where the configuration permits it. A plugin is the vehicle's UAV model, or with a name its payload.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "fault", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// A plugin panics.
    PluginPanic {
        /// The vehicle.
        vehicle: VehicleId,
        /// The payload; the UAV model if left out.
        #[serde(default)]
        payload: Option<String>,
    },
    /// A plugin does not return.
    PluginHang {
        /// The vehicle.
        vehicle: VehicleId,
        /// The payload; the UAV model if left out.
        #[serde(default)]
        payload: Option<String>,
    },
    /// A plugin's process is killed; if it has none of its own, it panics.
    PluginKill {
        /// The vehicle.
        vehicle: VehicleId,
        /// The payload; the UAV model if left out.
        #[serde(default)]
        payload: Option<String>,
    },
    /// The actor of a vehicle is killed.
    VehicleActor {
        /// The vehicle.
        vehicle: VehicleId,
    },
    /// The coordinator actor is killed.
    Coordinator,
    /// The coordinator actor is killed and stays away until it is told to come back.
    CoordinatorAway {
        /// It is away; false lets it come back.
        away: bool,
    },
}

/// A running node, for everyone outside of it. Cheap to clone.
#[derive(Clone)]
pub struct NodeHandle {
    pub(crate) board: Arc<Board>,
    pub(crate) parts: Arc<Parts>,
}

/// Longest wait for an actor's answer. They answer at once; this bounds the wait for one that has just died.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// Longest wait for the plan of a formation.
const PLAN_WITHIN: Duration = Duration::from_secs(20);

impl NodeHandle {
    pub(crate) fn new(board: Arc<Board>, parts: Arc<Parts>) -> Self {
        Self { board, parts }
    }

    pub(crate) fn board(&self) -> &Arc<Board> {
        &self.board
    }

    pub(crate) fn parts(&self) -> &Arc<Parts> {
        &self.parts
    }

    /// Now, on the node's clock.
    #[must_use]
    pub fn now(&self) -> NodeTime {
        self.board.now()
    }

    /// The node's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.board.config.node.name
    }

    /// The configuration it was built with.
    #[must_use]
    pub fn config(&self) -> &NodeConfig {
        &self.board.config
    }

    /// The newest picture of the fleet.
    #[must_use]
    pub fn snapshot(&self) -> Arc<FleetSnapshot> {
        self.board.picture.load_full()
    }

    /// New events from now on.
    #[must_use]
    pub fn subscribe(&self) -> broadcast::Receiver<Arc<EventRecord>> {
        self.board.events.subscribe()
    }

    /// Kept events with a greater sequence number.
    #[must_use]
    pub fn events_after(&self, seq: u64) -> Vec<Arc<EventRecord>> {
        self.board.events.after(seq)
    }

    /// Local addresses of the endpoints, by name.
    #[must_use]
    pub fn endpoint_addresses(&self) -> BTreeMap<String, SocketAddr> {
        self.parts.bound.lock().clone()
    }

    /// Counters of the endpoints, by name.
    #[must_use]
    pub fn endpoint_metrics(&self) -> Vec<(Arc<str>, Arc<EndpointMetrics>)> {
        self.parts.links.metrics()
    }

    /// Where each follower belongs relative to its leader at this moment, and the anchor: what a referee compares with the truth.
    #[must_use]
    pub fn slots(&self) -> Option<FormationSlots> {
        let formation = self.board.coordination.lock().formation.clone()?;
        let peers = self.board.peers.load_full();
        let anchor = match formation.leader {
            Some(leader) => peers.entry(leader).and_then(|e| e.anchor),
            None => peers.anchor,
        }?;
        let slots = formation.slots.into_iter().collect();
        Some(FormationSlots {
            leader: formation.leader,
            anchor,
            slots,
            settled_at: formation.settled_at,
        })
    }

    /// Gives a command to vehicles; each answers for itself. A take-off of several is staggered.
    pub async fn command(&self, targets: &Targets, command: VehicleCommand) -> Vec<CommandReceipt> {
        let ids: Vec<VehicleId> = match targets {
            Targets::All => self.board.cells().iter().map(|cell| cell.id).collect(),
            Targets::Vehicles(ids) => ids.clone(),
        };
        let stagger_s = match command {
            VehicleCommand::TakeOff { .. } => self.board.config.coordinator.take_off_stagger_s,
            _ => 0.0,
        };
        self.withdraw(&ids, &command);
        let now = self.board.now();
        let mut legs = match command {
            VehicleCommand::Return if ids.len() > 1 => returns::legs(&self.board, &ids),
            _ => BTreeMap::new(),
        };
        let asked: Vec<_> = ids
            .iter()
            .enumerate()
            .map(|(i, id)| {
                let (handle, id) = (self.clone(), *id);
                let not_before = now.plus_seconds(stagger_s * i as f64);
                let legs = legs.remove(&id).unwrap_or_default();
                // All at once: a slow answer of one must not delay the stop of another.
                tokio::spawn(async move { handle.command_one(id, command, legs, not_before).await })
            })
            .collect();
        let mut receipts = Vec::with_capacity(asked.len());
        for (vehicle, answer) in ids.into_iter().zip(asked) {
            receipts.push(answer.await.unwrap_or_else(|_| CommandReceipt {
                vehicle,
                id: CommandId(0),
                refusal: Some(Refusal::NotRunning {
                    what: format!("actor of vehicle {vehicle}"),
                }),
            }));
        }
        // Who did not take the command up goes on as before; the coordinator takes it back in.
        let mut withdrawn = self.board.withdrawn.lock();
        for receipt in receipts.iter().filter(|r| r.refusal.is_some()) {
            withdrawn.remove(&receipt.vehicle);
        }
        drop(withdrawn);
        receipts
    }

    /// A command that moves or stops a vehicle by itself takes it out of the formation, and all its targets at once: a regrouping of
    /// the rest must call none of them back. A take-off makes it a newcomer again.
    fn withdraw(&self, ids: &[VehicleId], command: &VehicleCommand) {
        let mut withdrawn = self.board.withdrawn.lock();
        match command {
            VehicleCommand::Arm
            | VehicleCommand::Disarm
            | VehicleCommand::LookAt { .. }
            | VehicleCommand::StopObserving => {}
            VehicleCommand::TakeOff { .. } => withdrawn.retain(|id| !ids.contains(id)),
            VehicleCommand::Land
            | VehicleCommand::LandAt { .. }
            | VehicleCommand::Hold
            | VehicleCommand::Return
            | VehicleCommand::Observe { .. }
            | VehicleCommand::GoTo { .. } => withdrawn.extend(ids),
        }
    }

    async fn command_one(
        &self,
        vehicle: VehicleId,
        command: VehicleCommand,
        legs: VecDeque<VehicleCommand>,
        not_before: NodeTime,
    ) -> CommandReceipt {
        let id = self.board.next_command_id();
        let refused = |refusal| CommandReceipt {
            vehicle,
            id,
            refusal: Some(refusal),
        };
        let Some(cell) = self.board.cell(vehicle) else {
            return refused(Refusal::UnknownVehicle { vehicle });
        };
        let legs = match ways::legs(&self.board, vehicle, &command) {
            Ok(around) if legs.is_empty() => around,
            Ok(_) => legs,
            // A return that finds no way is better begun than not; the gate stops it where it must.
            Err(_) if command == VehicleCommand::Return => legs,
            Err(refusal) => return refused(refusal),
        };
        let not_running = Refusal::NotRunning {
            what: format!("actor of vehicle {vehicle}"),
        };
        let Some(actor) = cell.actor.load_full() else {
            return refused(not_running);
        };
        let message = |reply| VehicleMessage::Command {
            id,
            command,
            legs,
            not_before,
            reply: Some(reply),
        };
        match actor.call(message, Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(receipt)) => receipt,
            Ok(CallResult::Timeout) => refused(Refusal::TimedOut {
                what: format!("the actor of vehicle {vehicle}"),
                after_s: ANSWER_WITHIN.as_secs_f64(),
            }),
            _ => refused(not_running),
        }
    }

    /// Flies a formation.
    ///
    /// # Errors
    /// When too few vehicles are available or no safe way into the slots is found.
    pub async fn set_formation(&self, request: FormationRequest) -> Result<FormationReceipt, Refusal> {
        self.coordinate(|reply| CoordinatorMessage::SetFormation(Box::new(request), reply))
            .await
    }

    /// Ends the formation; its members hold.
    ///
    /// # Errors
    /// When the coordinator is not running.
    pub async fn dissolve_formation(&self) -> Result<(), Refusal> {
        self.coordinate(CoordinatorMessage::Dissolve).await
    }

    /// Has the leader fly a route, as fast and as wide as the formation can; gives it as it is flown.
    ///
    /// # Errors
    /// When no formation is flown behind a leader, or the route is refused by the safety gate.
    pub async fn set_route(&self, route: Route) -> Result<Route, Refusal> {
        self.coordinate(|reply| CoordinatorMessage::SetRoute(route, reply))
            .await
    }

    /// An operator gives a sign of life: the dead man's switch, where the configuration has it on, counts from the last one.
    pub fn hear_operator(&self) {
        self.board.hear_operator();
    }

    /// When an operator last gave a sign of life, if ever.
    #[must_use]
    pub fn operator_heard(&self) -> Option<NodeTime> {
        self.board.operator_heard()
    }

    /// Tells where a reference is that formations may be anchored to.
    ///
    /// # Errors
    /// For a name or a number that is of no use.
    pub fn tell_reference(&self, name: &str, report: ReferenceReport) -> Result<(), Refusal> {
        self.board.references.tell(name, report, self.now())
    }

    /// Forgets a reference.
    ///
    /// # Errors
    /// If none of that name is known.
    pub fn forget_reference(&self, name: &str) -> Result<(), Refusal> {
        let known = self.board.references.forget(name);
        known
            .then_some(())
            .ok_or_else(|| Refusal::UnknownReference { name: name.to_owned() })
    }

    /// All references.
    #[must_use]
    pub fn references(&self) -> Vec<ReferenceSnapshot> {
        self.board.references.list(self.now())
    }

    async fn coordinate<T: Send + 'static>(
        &self,
        message: impl FnOnce(RpcReplyPort<Result<T, Refusal>>) -> CoordinatorMessage,
    ) -> Result<T, Refusal> {
        let not_running = || Refusal::NotRunning {
            what: "the coordinator".into(),
        };
        let coordinator = self.parts.coordinator.load_full().ok_or_else(not_running)?;
        match coordinator.call(message, Some(PLAN_WITHIN)).await {
            Ok(CallResult::Success(answer)) => answer,
            Ok(CallResult::Timeout) => Err(Refusal::TimedOut {
                what: "the coordinator".into(),
                after_s: PLAN_WITHIN.as_secs_f64(),
            }),
            _ => Err(not_running()),
        }
    }

    /// Injects a fault.
    ///
    /// # Errors
    /// When the configuration does not permit it, or there is no such vehicle.
    pub async fn inject_fault(&self, fault: Fault) -> Result<(), Refusal> {
        if !self.board.config.faults.enabled {
            return Err(Refusal::NotPermitted {
                detail: "fault injection is off (faults.enabled)".into(),
            });
        }
        let text = format!("fault injected: {fault:?}");
        self.board
            .events
            .record(self.now(), None, Severity::Advisory, EventKind::Notice, text);
        let actor_of = |vehicle: VehicleId| {
            let cell = self.board.cell(vehicle).ok_or(Refusal::UnknownVehicle { vehicle })?;
            cell.actor.load_full().ok_or(Refusal::NotRunning {
                what: format!("actor of vehicle {vehicle}"),
            })
        };
        match fault {
            Fault::PluginPanic { vehicle, payload } => {
                self.to_plugin(vehicle, payload.as_deref(), PluginOrder::Drill(FaultDrill::Panic))
            }
            Fault::PluginHang { vehicle, payload } => {
                self.to_plugin(vehicle, payload.as_deref(), PluginOrder::Drill(FaultDrill::Hang))
            }
            Fault::PluginKill { vehicle, payload } => self.to_plugin(vehicle, payload.as_deref(), PluginOrder::Kill),
            Fault::VehicleActor { vehicle } => {
                actor_of(vehicle)?.kill();
                Ok(())
            }
            Fault::Coordinator => {
                let coordinator = self.parts.coordinator.load_full();
                coordinator
                    .ok_or(Refusal::NotRunning {
                        what: "the coordinator".into(),
                    })?
                    .kill();
                Ok(())
            }
            Fault::CoordinatorAway { away } => {
                self.board.coordinator_away.store(away, Ordering::Release);
                if let Some(coordinator) = self.parts.coordinator.load_full().filter(|_| away) {
                    coordinator.kill();
                }
                Ok(())
            }
        }
    }
}

/// The formation as its members fly it at one moment.
#[derive(Debug, Clone)]
pub struct FormationSlots {
    /// Who leads, if a vehicle does.
    pub leader: Option<VehicleId>,
    /// The anchor.
    pub anchor: AnchorReference,
    /// Each follower's slot.
    pub slots: Vec<(VehicleId, SlotMove)>,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
}
