//! The typed handle to a running node: the only way in for the API, the demo and the tests. The actors' messages stay private.

mod commands;
mod control;
mod coordination;
mod emergency;
mod fences;
pub(crate) mod flying_on;
mod logs;
pub(crate) mod observers;
mod parameters;
mod parting;
mod plugins;
mod preflight;
mod recorder;
mod recording;
mod resume;
pub(crate) mod serving;
mod stick;
mod trajectories;
mod versions;

pub use control::{ControlAction, ControlReceipt};
pub use emergency::EmergencyKey;
pub use fences::FenceAnswer;
pub use observers::{AskedObserver, LONGEST_TRACK_NAME, ObserveRequest};
pub use parameters::ParameterReceipt;
pub use plugins::{InstanceUpgrade, PluginInfo, PluginRefusal, UpgradeReceipt};
pub use preflight::PreflightAnswer;

use plugins::PluginOrder;

use crate::fleet::{Discovery, FleetMessage};
use crate::parts::Parts;
use serde::{Deserialize, Serialize};
use skein_config::{LinkKind, NodeConfig};
use skein_coordination::{ReferenceReport, ReferenceSnapshot};
use skein_domain::exchange::{FaultDrill, Severity};
use skein_domain::link::VehicleLink;
use skein_domain::{AnchorReference, NodeTime, Refusal, SlotMove, VehicleId};
use skein_link_mavlink::EndpointMetrics;
use skein_state::SharedState;
use skein_streaming::CameraStreams;
use skein_view::{EventKind, EventRecord, FleetSnapshot};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
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
    pub(crate) shared: Arc<SharedState>,
    pub(crate) parts: Arc<Parts>,
}

/// Longest wait for an actor's answer. They answer at once; this bounds the wait for one that has just died.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// Longest wait for the plan of a formation.
const PLAN_WITHIN: Duration = Duration::from_secs(20);

impl NodeHandle {
    pub(crate) fn new(shared: Arc<SharedState>, parts: Arc<Parts>) -> Self {
        Self { shared, parts }
    }

    pub(crate) fn shared(&self) -> &Arc<SharedState> {
        &self.shared
    }

    pub(crate) fn parts(&self) -> &Arc<Parts> {
        &self.parts
    }

    /// The video of the swarm's cameras.
    #[must_use]
    pub fn streams(&self) -> CameraStreams {
        CameraStreams::new(self.shared.clone(), self.parts.links.clone())
    }

    /// Offers a vehicle that a link outside of this crate hears, under the name of that link's endpoint: the fleet adopts it by the rules of the
    /// configuration, as any other. Rules that name `links` take it for one over MAVLink. See "Another autopilot" in the documentation.
    ///
    /// # Errors
    /// [`Refusal::NotRunning`] while the fleet is being started again.
    pub fn offer_vehicle(&self, endpoint: &str, link: Arc<dyn VehicleLink>) -> Result<(), Refusal> {
        let not_running = || Refusal::not_running("the fleet");
        let fleet = self.parts.fleet.load_full().ok_or_else(not_running)?;
        let discovery = Discovery {
            endpoint: endpoint.to_owned(),
            kind: LinkKind::Mavlink,
            system_id: link.system_id(),
            link,
        };
        fleet
            .cast(FleetMessage::Discovered(discovery))
            .map_err(|_| not_running())
    }

    /// Now, on the node's clock.
    #[must_use]
    pub fn now(&self) -> NodeTime {
        self.shared.now()
    }

    /// The node's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.shared.config.node.name
    }

    /// The configuration it was built with.
    #[must_use]
    pub fn config(&self) -> &NodeConfig {
        &self.shared.config
    }

    /// The newest picture of the fleet.
    #[must_use]
    pub fn snapshot(&self) -> Arc<FleetSnapshot> {
        self.shared.picture()
    }

    /// Waits for a picture that was begun from now on: who has changed something, and then looks, is not to see what was before.
    /// Does not wait longer than a few pictures take: where none are made, the old one tells by its time how old it is.
    pub async fn next_snapshot(&self) -> Arc<FleetSnapshot> {
        let (from, period) = (self.now(), 1.0 / self.shared.config.node.snapshot_rate_hz);
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
        self.shared.events.subscribe()
    }

    /// Kept events with a greater sequence number.
    #[must_use]
    pub fn events_after(&self, seq: u64) -> Vec<Arc<EventRecord>> {
        self.shared.events.after(seq)
    }

    /// Marks alerts as seen by an operator. Returns how many were not before.
    #[must_use]
    pub fn acknowledge(&self, events: &[u64]) -> usize {
        self.shared.events.acknowledge(self.shared.now(), events)
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
        let formation = self.shared.coordination.read().formation.clone()?;
        let peers = self.shared.peers();
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
        self.shared.operators.hear(self.now());
    }

    /// When an operator last gave a sign of life, if ever.
    #[must_use]
    pub fn operator_heard(&self) -> Option<NodeTime> {
        self.shared.operators.heard()
    }

    /// Tells where a reference is that formations may be anchored to.
    ///
    /// # Errors
    /// For a name or a number that is of no use.
    pub fn tell_reference(&self, name: &str, report: ReferenceReport) -> Result<(), Refusal> {
        self.shared.observed.references.tell(name, report, self.now())
    }

    /// Forgets a reference.
    ///
    /// # Errors
    /// If none of that name is known.
    pub fn forget_reference(&self, name: &str) -> Result<(), Refusal> {
        let known = self.shared.observed.references.forget(name);
        known
            .then_some(())
            .ok_or_else(|| Refusal::UnknownReference { name: name.to_owned() })
    }

    /// All references.
    #[must_use]
    pub fn references(&self) -> Vec<ReferenceSnapshot> {
        self.shared.observed.references.list(self.now())
    }

    /// Injects a fault.
    ///
    /// # Errors
    /// When the configuration does not permit it, or there is no such vehicle.
    pub async fn inject_fault(&self, fault: Fault) -> Result<(), Refusal> {
        if !self.shared.config.faults.enabled {
            return Err(Refusal::not_permitted("fault injection is off (faults.enabled)"));
        }
        let text = format!("fault injected: {fault:?}");
        self.shared
            .events
            .record(self.now(), None, Severity::Advisory, EventKind::Notice, text);
        let actor_of = |vehicle: VehicleId| {
            let record = self.shared.vehicles.known(vehicle)?;
            let not_running = || Refusal::not_running(format!("actor of vehicle {vehicle}"));
            record.actor.get().ok_or_else(not_running)
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
                coordinator.ok_or(Refusal::not_running("the coordinator"))?.kill();
                Ok(())
            }
            Fault::CoordinatorAway { away } => {
                self.shared.coordination.drill_absence(away);
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
