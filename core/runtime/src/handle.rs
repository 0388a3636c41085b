//! The typed handle to a running node: the only way in for the API, the demo and the tests. The actors' messages stay private.

mod commands;
mod control;
mod coordination;
mod parameters;
mod parting;
mod resume;
mod stick;
mod trajectories;

pub use control::{ControlAction, ControlReceipt};
pub use parameters::ParameterReceipt;

use crate::board::Board;
use crate::node::Parts;
use crate::plugins::PluginOrder;
use crate::references::{ReferenceReport, ReferenceSnapshot};
use crate::snapshot::{EventKind, EventRecord, FleetSnapshot};
use serde::{Deserialize, Serialize};
use skein_config::NodeConfig;
use skein_domain::exchange::{FaultDrill, Severity};
use skein_domain::{AnchorReference, CommandId, NodeTime, PositionNed, Refusal, SlotMove, VehicleId};
use skein_link_px4::EndpointMetrics;
use std::collections::BTreeMap;
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
    Vehicles(#[schemars(length(min = 1, max = 1024), extend("uniqueItems" = true))] Vec<VehicleId>),
}

/// What became of a command at one vehicle: taken up (how it goes on comes as events), or refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct CommandReceipt {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The command's id; events about its progress carry it.
    pub id: CommandId,
    /// Why it was refused; absent if it was taken up.
    pub refusal: Option<Refusal>,
}

/// What a change of formation will look like.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationReceipt {
    /// Who leads; nobody if it is anchored to something else than a vehicle.
    pub leader: Option<VehicleId>,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// How long the change takes in seconds.
    pub duration_s: f64,
    /// Smallest distance between any two vehicles on the way, in metres; null for one alone.
    pub planned_min_distance_m: Option<f64>,
    /// How fast it can go as a whole, in metres per second.
    pub max_speed_m_s: f64,
    /// Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
    pub view_blocked: Vec<VehicleId>,
}

/// How a change of formation would go if it were begun now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationForecast {
    /// What would be answered.
    pub receipt: FormationReceipt,
    /// Where the formation would look while its anchor stands where it is, in radians clockwise from north.
    pub heading_rad: f64,
    /// Who would take which place, leader first.
    pub ways: Vec<ForeseenWay>,
}

/// From where a vehicle would go into which place of a formation, in metres about the swarm's origin. With a turning formation or a
/// detour around another vehicle the way itself is no straight line.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct ForeseenWay {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// Where it is.
    pub from: PositionNed,
    /// Where its place is while the anchor stands where it is.
    pub to: PositionNed,
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

    /// Waits for a picture that was begun from now on: who has changed something, and then looks, is not to see what was before.
    /// Does not wait longer than a few pictures take: where none are made, the old one tells by its time how old it is.
    pub async fn next_snapshot(&self) -> Arc<FleetSnapshot> {
        let (from, period) = (self.now(), 1.0 / self.board.config.node.snapshot_rate_hz);
        for _ in 0..20 {
            let picture = self.snapshot();
            if picture.time > from {
                return picture;
            }
            tokio::time::sleep(Duration::from_secs_f64(period / 5.0)).await;
        }
        self.snapshot()
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

    /// Marks alerts as seen by an operator. Returns how many were not before.
    #[must_use]
    pub fn acknowledge(&self, events: &[u64]) -> usize {
        self.board.events.acknowledge(self.board.now(), events)
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
