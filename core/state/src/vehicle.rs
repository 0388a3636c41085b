//! One adopted vehicle, beyond the life of its actor, and what that actor publishes.
//!
//! Must never do: wait for the vehicle.

use crate::by_hand::Hand;
use crate::commanded::Commanded;
use crate::failsafe::FailsafeMonitor;
use crate::held_route::HeldRoute;
use crate::mailbox::{ActorSlot, VehicleMessage};
use crate::payload::PayloadRecord;
use crate::plugin::PluginRecord;
use arc_swap::ArcSwap;
use parking_lot::{Mutex, MutexGuard, RwLock};
use skein_domain::link::VehicleLink;
use skein_domain::payload::CoordinatorCapability;
use skein_domain::preflight::PreflightItem;
use skein_domain::{
    AnchorReference, FailsafeState, FlightLimits, FlightState, NodeTime, Refusal, Setpoint, SystemId, VehicleId,
};
use skein_view::{ActorHealth, Avoidance};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// One adopted vehicle. It outlives the vehicle's actor, so that a new incarnation finds state and link.
pub struct VehicleRecord {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// Name from the adoption rule.
    pub name: String,
    /// System id on its link.
    pub system_id: SystemId,
    /// Its autopilot runs in a simulation, as its rule says.
    pub simulated: bool,
    /// The UAV-model plugin instance that flies it.
    pub model: Arc<PluginRecord>,
    payloads: RwLock<BTreeMap<String, Arc<PayloadRecord>>>,
    link: ArcSwap<LinkSlot>,
    state: Mutex<PublishedState>,
    /// Its actor.
    pub actor: ActorSlot<VehicleMessage>,
    /// Its failsafe policy and its charge.
    pub failsafe: Mutex<FailsafeMonitor>,
    /// The command that it carries out.
    pub commanded: Commanded,
    /// Whether it is flown by hand, and the newest stick for it.
    pub hand: Mutex<Hand>,
    /// The route that was put on its autopilot.
    pub route: Mutex<HeldRoute>,
    /// Its motors were stopped in an emergency: nothing flies it until an operator arms it again.
    stopped: AtomicBool,
    /// How often it was taken out of the formation: so that calling it back means one of these, and no later one.
    withdrawals: AtomicU32,
}

impl VehicleRecord {
    /// A vehicle that has just been adopted.
    #[must_use]
    pub fn new(
        id: VehicleId,
        name: String,
        system_id: SystemId,
        simulated: bool,
        model: Arc<PluginRecord>,
        link: Arc<dyn VehicleLink>,
    ) -> Self {
        Self {
            id,
            name,
            system_id,
            simulated,
            model,
            payloads: RwLock::default(),
            link: ArcSwap::from_pointee(LinkSlot(link)),
            actor: ActorSlot::default(),
            state: Mutex::default(),
            failsafe: Mutex::default(),
            commanded: Commanded::default(),
            hand: Mutex::default(),
            route: Mutex::default(),
            stopped: AtomicBool::new(false),
            withdrawals: AtomicU32::new(0),
        }
    }

    /// It is taken out of the formation.
    pub(crate) fn note_withdrawal(&self) {
        self.withdrawals.fetch_add(1, Ordering::Relaxed);
    }

    /// How often it was taken out of the formation.
    #[must_use]
    pub fn withdrawals(&self) -> u32 {
        self.withdrawals.load(Ordering::Relaxed)
    }

    /// Whether its motors were stopped in an emergency.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Acquire)
    }

    /// Marks it as stopped in an emergency, or as free again.
    pub fn set_stopped(&self, stopped: bool) {
        self.stopped.store(stopped, Ordering::Release);
    }

    /// Its link.
    pub fn link(&self) -> Arc<dyn VehicleLink> {
        self.link.load().0.clone()
    }

    /// The fleet hears it over another link than before.
    pub fn replace_link(&self, link: Arc<dyn VehicleLink>) {
        self.link.store(Arc::new(LinkSlot(link)));
    }

    /// What its actor last published, to be read.
    pub fn state(&self) -> impl Deref<Target = PublishedState> {
        self.state.lock()
    }

    /// The same, for its actor, and for the fleet when that has ended.
    pub fn change_state(&self) -> MutexGuard<'_, PublishedState> {
        self.state.lock()
    }

    /// Another vehicle leads: the anchor of a former leader must not be followed.
    pub fn forget_anchor(&self) {
        self.state.lock().anchor = None;
    }

    /// The coordinator has set a new route: what its actor said of a former one says nothing of this.
    pub fn forget_finished_route(&self) {
        self.state.lock().route_finished = None;
    }

    /// The fleet puts a payload on it.
    pub fn attach(&self, payload: Arc<PayloadRecord>) {
        self.payloads.write().insert(payload.name.clone(), payload);
    }

    /// The fleet takes one off.
    pub fn detach(&self, name: &str) -> Option<Arc<PayloadRecord>> {
        self.payloads.write().remove(name)
    }

    /// What it carries, by name.
    #[must_use]
    pub fn payloads(&self) -> Vec<Arc<PayloadRecord>> {
        self.payloads.read().values().cloned().collect()
    }

    /// The payload of that name.
    #[must_use]
    pub fn payload(&self, name: &str) -> Option<Arc<PayloadRecord>> {
        self.payloads.read().get(name).cloned()
    }

    /// The payload of that name.
    ///
    /// # Errors
    /// There is none.
    pub fn known_payload(&self, name: &str) -> Result<Arc<PayloadRecord>, Refusal> {
        self.payload(name).ok_or_else(|| Refusal::UnknownPayload {
            vehicle: self.id,
            payload: name.to_owned(),
        })
    }
}

/// A link behind a thin pointer, so that it can be swapped.
struct LinkSlot(Arc<dyn VehicleLink>);

/// What a vehicle's actor publishes for its peers, the coordinator and the screens.
#[derive(Debug, Clone, Default)]
pub struct PublishedState {
    /// Flight state.
    pub flight_state: FlightState,
    /// Why.
    pub detail: String,
    /// Since when.
    pub since: NodeTime,
    /// The anchor it publishes while leading.
    pub anchor: Option<AnchorReference>,
    /// Last setpoint that passed the gate.
    pub setpoint: Option<Setpoint>,
    /// Distance to its slot or goal in metres.
    pub tracking_error_m: Option<f64>,
    /// It has flown its route to the end; with the task version of that route.
    pub route_finished: Option<u64>,
    /// Version of the task it has taken up last.
    pub task_version: u64,
    /// Actor's health.
    pub actor: ActorHealth,
    /// What the model reports of itself, as its state schema has it.
    pub model_state: Option<serde_json::Value>,
    /// Whether it can host the coordinator.
    pub capability: Option<CoordinatorCapability>,
    /// What it can do, if its model says.
    pub limits: Option<FlightLimits>,
    /// What its model has to say before it is armed.
    pub preflight: Vec<PreflightItem>,
    /// What is changed of its setpoints at this moment, to keep it off others or inside of a fence.
    pub avoiding: Option<Avoidance>,
    /// What is wrong with it and what is done about it; absent if nothing is.
    pub failsafe: Option<FailsafeState>,
}
