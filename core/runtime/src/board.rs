//! The board: what the actors of a node share by reading instead of asking. Immutable snapshots of peers and intent, one cell
//! per vehicle that outlives its actor, the gate, the event log.
//!
//! Must never do: wait, or hold a lock across an await.

use crate::anchor::AnchorKeeper;
use crate::by_hand::{Hand, Relays};
use crate::coordination::Coordination;
use crate::emergency::EmergencyUnlock;
use crate::events::EventLog;
use crate::overrun::Overrun;
use crate::own_tracks::OwnTracks;
use crate::paired::PairedLink;
use crate::payload::PayloadCell;
use crate::plugin_life::LifeRecord;
use crate::references::References;
use crate::resume::Resume;
use crate::snapshot::{ActorHealth, Avoidance, FleetSnapshot, RestartRecord, UnadoptedVehicle};
use crate::swarm::SwarmShare;
use crate::vehicle::{HeldRoute, Itinerary, VehicleMessage, Watch};
use arc_swap::{ArcSwap, ArcSwapOption};
use parking_lot::{Mutex, RwLock};
use ractor::ActorRef;
use skein_config::NodeConfig;
use skein_domain::fence::FencePlan;
use skein_domain::link::VehicleLink;
use skein_domain::payload::{CoordinatorCapability, Track};
use skein_domain::preflight::{PreflightItem, PreflightOverride};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorReference, Clock, CommandId, EnergyState, FlightLimits, FlightState, Geodetic, Intent, LadderState,
    LandedState, LinkHealth, NodeId, NodeTime, PositionNed, Setpoint, SwarmFrame, SystemId, Telemetry, VehicleCommand,
    VehicleId,
};
use skein_link_px4::Sightings;
use skein_plugin_host::{Catalog, Runners};
use skein_safety::avoidance::Surroundings;
use skein_safety::control::ControlTable;
use skein_safety::{FencePlanError, Fences, Gate};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// Everything the actors of one node share.
pub struct Board {
    /// The configuration the node was built with.
    pub config: NodeConfig,
    /// The node's clock.
    pub clock: Arc<dyn Clock>,
    /// The safety gate; replaced as a whole when the fences change.
    gate: ArcSwap<Gate>,
    /// The fences as they were described.
    pub fence_plan: Mutex<FencePlan>,
    /// Events.
    pub events: EventLog,
    /// Plugins found.
    pub catalog: Catalog,
    /// Threads that UAV models' calls run on.
    pub runners: Arc<Runners>,
    /// Threads that payloads' calls run on: a camera that draws a picture must keep no vehicle waiting.
    pub payload_runners: Arc<Runners>,
    /// The swarm's common frame, once known. Set once: positions given before must keep their meaning.
    frame: ArcSwapOption<SwarmFrame>,
    /// Peers of the present control period.
    pub peers: ArcSwap<PeerSnapshot>,
    /// What the coordinator wants.
    pub intent: ArcSwap<Intent>,
    /// What the coordinator must find again after a restart.
    pub coordination: Mutex<Coordination>,
    /// Vehicles that an operator's command took out of the formation. Written before the command is sent, so that no regrouping can
    /// come between and call them back.
    pub withdrawn: Mutex<BTreeSet<VehicleId>>,
    /// Vehicles by id.
    cells: RwLock<BTreeMap<VehicleId, Arc<VehicleCell>>>,
    /// Vehicles that are flown over two links.
    pub pairs: Mutex<BTreeMap<VehicleId, Arc<PairedLink>>>,
    /// Vehicles heard but not flown.
    pub unadopted: Mutex<Vec<UnadoptedVehicle>>,
    /// Health of the node's own actors by name.
    pub actors: Mutex<BTreeMap<String, ActorHealth>>,
    /// Restarts of plugin instances, the newest last; as many as are kept.
    pub restarts: Mutex<VecDeque<RestartRecord>>,
    /// Whether this computer's control loop comes in time.
    pub(crate) overrun: Mutex<Overrun>,
    /// Held while the instances of a plugin are exchanged for another version.
    pub exchanging: tokio::sync::Mutex<()>,
    /// Aircraft and movers that were sighted over MAVLink.
    pub sightings: Sightings,
    /// Things that formations may be anchored to.
    pub references: References,
    /// Which console has which vehicles in hand.
    pub control: Mutex<ControlTable>,
    /// Sticks on their way to vehicles of other nodes that are flown by hand.
    pub relays: Relays,
    /// Works out the anchor of a formation that follows no vehicle.
    pub anchor: Mutex<AnchorKeeper>,
    /// Which tracks are of our own vehicles.
    pub own_tracks: Mutex<OwnTracks>,
    /// When the coordinator last looked at its formation, in microseconds of node time.
    coordinator_seen_us: AtomicU64,
    /// When an operator last gave a sign of life, in microseconds of node time; 0 if none ever did.
    operator_heard_us: AtomicU64,
    /// The same at another node of the swarm.
    operator_elsewhere_us: AtomicU64,
    /// What is tracked was told at this node last.
    tracks_are_ours: AtomicBool,
    /// Red items that somebody took upon himself at this node.
    pub overrides_here: Mutex<Vec<PreflightOverride>>,
    /// Red items of preflight reports that somebody takes upon himself.
    pub overrides: Mutex<Vec<PreflightOverride>>,
    /// The emergency stop, while it is unlocked.
    pub emergency: Mutex<Option<EmergencyUnlock>>,
    /// A drill: the coordinator is not started again as long as this is set.
    pub coordinator_away: AtomicBool,
    /// The node is stopping: nobody goes into OFFBOARD any more.
    pub stopping: AtomicBool,
    /// What was flown when the node was killed, and who of it is taken back.
    pub resume: Resume,
    /// What is tracked; replaced as a whole.
    pub tracks: ArcSwap<Vec<Track>>,
    /// The picture for screens.
    pub picture: ArcSwap<FleetSnapshot>,
    /// The swarm this node is part of, if any.
    pub swarm: Option<SwarmShare>,
    next_command: AtomicU64,
}

impl Board {
    /// An empty board.
    #[must_use]
    pub fn new(config: NodeConfig, clock: Arc<dyn Clock>, gate: Gate, fence_plan: FencePlan, catalog: Catalog) -> Self {
        let runners = || {
            let deadline = Duration::from_secs_f64(config.plugins.call_deadline_s);
            Runners::new(config.plugins.runner_threads, deadline)
        };
        let frame = config.swarm.origin.map(|origin| Arc::new(SwarmFrame::new(origin)));
        let (runners, payload_runners) = (runners(), runners());
        let max_speed_m_s = config.safety.max_speed_m_s;
        let node = config.swarm.id.as_ref().and(config.swarm.node).map(NodeId);
        let swarm = node.map(|node| SwarmShare::new(node, config.swarm.observer));
        let (events, now) = (EventLog::default(), clock.now());
        let resume = Resume::open(&config, &events, now);
        let mut control = ControlTable::new(node.unwrap_or(NodeId(0)));
        resume.hand_back(&mut control, now);
        Self {
            swarm,
            config,
            clock,
            gate: ArcSwap::from_pointee(gate),
            fence_plan: Mutex::new(fence_plan),
            events,
            resume,
            catalog,
            runners,
            payload_runners,
            frame: ArcSwapOption::from(frame),
            peers: ArcSwap::default(),
            intent: ArcSwap::default(),
            coordination: Mutex::default(),
            withdrawn: Mutex::default(),
            cells: RwLock::default(),
            pairs: Mutex::default(),
            unadopted: Mutex::default(),
            actors: Mutex::default(),
            restarts: Mutex::default(),
            overrun: Mutex::default(),
            exchanging: tokio::sync::Mutex::default(),
            sightings: Sightings::new(),
            references: References::new(max_speed_m_s),
            control: Mutex::new(control),
            relays: Relays::default(),
            anchor: Mutex::default(),
            own_tracks: Mutex::default(),
            coordinator_seen_us: AtomicU64::new(0),
            operator_heard_us: AtomicU64::new(0),
            operator_elsewhere_us: AtomicU64::new(0),
            tracks_are_ours: AtomicBool::new(false),
            overrides_here: Mutex::default(),
            overrides: Mutex::default(),
            emergency: Mutex::default(),
            coordinator_away: AtomicBool::new(false),
            stopping: AtomicBool::new(false),
            tracks: ArcSwap::default(),
            picture: ArcSwap::default(),
            // Each node of a swarm counts from elsewhere, so that a command can be told from another node's.
            next_command: AtomicU64::new(node.map_or(0, |node| node.0 & 0x1FFF) << 40 | 1),
        }
    }

    /// The safety gate.
    #[must_use]
    pub fn gate(&self) -> Arc<Gate> {
        self.gate.load_full()
    }

    /// The coordinator gives a sign of life.
    pub fn see_coordinator(&self) {
        self.coordinator_seen_us.store(self.now().0, Ordering::Relaxed);
    }

    /// When the coordinator last gave a sign of life.
    #[must_use]
    pub fn coordinator_seen(&self) -> NodeTime {
        if let Some(seen) = self.swarm.as_ref().and_then(|swarm| swarm.role.load().coordinator_seen) {
            return seen;
        }
        NodeTime(self.coordinator_seen_us.load(Ordering::Relaxed))
    }

    /// An operator gave a sign of life at another node.
    pub fn hear_operator_elsewhere(&self, at: NodeTime) {
        self.operator_elsewhere_us.fetch_max(at.0, Ordering::Relaxed);
    }

    /// When an operator last gave a sign of life at this node, if ever.
    #[must_use]
    pub fn operator_heard_here(&self) -> Option<NodeTime> {
        let heard_us = self.operator_heard_us.load(Ordering::Relaxed);
        (heard_us > 0).then_some(NodeTime(heard_us))
    }

    /// What is tracked, as it was told here.
    pub fn tell_tracks(&self, tracks: Vec<Track>) {
        self.tracks_are_ours.store(true, Ordering::Release);
        self.tracks.store(Arc::new(tracks));
    }

    /// What is tracked, as it was told at another node.
    pub fn hear_tracks(&self, tracks: Vec<Track>) {
        self.tracks_are_ours.store(false, Ordering::Release);
        self.tracks.store(Arc::new(tracks));
    }

    /// What is tracked, if it was told here last.
    #[must_use]
    pub fn tracks_here(&self) -> Option<Vec<Track>> {
        let ours = self.tracks_are_ours.load(Ordering::Acquire);
        ours.then(|| self.tracks.load().as_ref().clone())
    }

    /// An operator gives a sign of life.
    pub fn hear_operator(&self) {
        self.operator_heard_us.store(self.now().0.max(1), Ordering::Relaxed);
    }

    /// When an operator last gave a sign of life, if ever.
    #[must_use]
    pub fn operator_heard(&self) -> Option<NodeTime> {
        let elsewhere_us = self.operator_elsewhere_us.load(Ordering::Relaxed);
        let heard_us = self.operator_heard_us.load(Ordering::Relaxed).max(elsewhere_us);
        (heard_us > 0).then_some(NodeTime(heard_us))
    }

    /// Other fences from now on.
    ///
    /// # Errors
    /// When a zone cannot be one, or cannot be placed yet.
    pub fn set_fences(&self, plan: FencePlan) -> Result<(), FencePlanError> {
        let fences = Fences::from_plan(&plan, self.frame().as_ref())?;
        let gate = Gate::new(*self.gate().limits(), fences);
        *self.fence_plan.lock() = plan;
        self.gate.store(Arc::new(gate));
        Ok(())
    }

    /// Now.
    #[must_use]
    pub fn now(&self) -> NodeTime {
        self.clock.now()
    }

    /// The swarm frame, if known.
    #[must_use]
    pub fn frame(&self) -> Option<SwarmFrame> {
        self.frame.load().as_deref().copied()
    }

    /// Fixes the swarm frame's origin if it is not known yet; tells whether this call did it.
    pub fn fix_frame(&self, origin: Geodetic) -> bool {
        if self.frame.load().is_some() || !origin.is_valid() {
            return false;
        }
        self.frame.store(Some(Arc::new(SwarmFrame::new(origin))));
        true
    }

    /// A new command id.
    pub fn next_command_id(&self) -> skein_domain::CommandId {
        skein_domain::CommandId(self.next_command.fetch_add(1, Ordering::Relaxed))
    }

    /// Whether this node's coordinator decides: alone, or because it holds the office in its swarm.
    #[must_use]
    pub fn coordinates(&self) -> bool {
        self.swarm
            .as_ref()
            .is_none_or(|swarm| swarm.role.load().acting.is_some())
    }

    /// Whether this node may fix the swarm's frame: alone, or because nobody disputes that it coordinates.
    #[must_use]
    pub fn may_fix_frame(&self, now: NodeTime) -> bool {
        let swarm = self.swarm.as_ref();
        swarm.is_none_or(|swarm| swarm.role.load().is_undisputed(now))
    }

    /// Takes one of this node's vehicles out of the formation; tells whether it was in it.
    pub fn withdraw(&self, cell: &VehicleCell) -> bool {
        cell.withdrawals.fetch_add(1, Ordering::Relaxed);
        self.withdrawn.lock().insert(cell.id)
    }

    /// Which other node flies a vehicle; none if this one does, or nobody.
    #[must_use]
    pub fn host(&self, vehicle: VehicleId) -> Option<NodeId> {
        if self.cells.read().contains_key(&vehicle) {
            return None;
        }
        self.swarm.as_ref()?.host(vehicle)
    }

    /// All vehicles of the swarm, this node's and others', by ascending id.
    #[must_use]
    pub fn vehicle_ids(&self) -> Vec<VehicleId> {
        let mut ids: BTreeSet<VehicleId> = self.cells.read().keys().copied().collect();
        if let Some(swarm) = &self.swarm {
            ids.extend(swarm.vehicles.read().keys());
        }
        ids.into_iter().collect()
    }

    /// The vehicle's cell.
    #[must_use]
    pub fn cell(&self, id: VehicleId) -> Option<Arc<VehicleCell>> {
        self.cells.read().get(&id).cloned()
    }

    /// All cells by ascending id.
    #[must_use]
    pub fn cells(&self) -> Vec<Arc<VehicleCell>> {
        self.cells.read().values().cloned().collect()
    }

    /// Adds a vehicle; the one with the same id, if any, is replaced.
    pub fn insert_cell(&self, cell: Arc<VehicleCell>) {
        self.cells.write().insert(cell.id, cell);
    }
}

/// One adopted vehicle. It outlives the vehicle's actor, so that a new incarnation finds state and link.
pub struct VehicleCell {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// Name from the adoption rule.
    pub name: String,
    /// System id on its link.
    pub system_id: SystemId,
    /// Its autopilot runs in a simulation, as its rule says.
    pub simulated: bool,
    /// The UAV-model plugin instance that flies it.
    pub model: Arc<LifeRecord>,
    /// What it carries, by name.
    pub payloads: RwLock<BTreeMap<String, Arc<PayloadCell>>>,
    /// Its link. Replaced when the vehicle comes back over another one.
    pub link: ArcSwap<LinkSlot>,
    /// The running actor, if any.
    pub actor: ArcSwapOption<ActorRef<VehicleMessage>>,
    /// A tick has been sent and not yet been taken up: at most one waits in the mailbox.
    pub tick_waiting: AtomicBool,
    /// What the actor last published.
    pub state: Mutex<PublishedState>,
    /// Its ladder of reactions and its charge.
    pub watch: Mutex<Watch>,
    /// The command that it carries out, if one.
    pub under_way: Mutex<Option<(CommandId, VehicleCommand)>>,
    /// A command in several legs that is being carried out.
    pub itinerary: Mutex<Option<Itinerary>>,
    /// Whether it is flown by hand, and the newest stick for it.
    pub hand: Mutex<Hand>,
    /// The route that was put on its autopilot.
    pub route: Mutex<HeldRoute>,
    /// Its motors were stopped in an emergency: nothing flies it until an operator arms it again.
    stopped: AtomicBool,
    /// How often it was taken out of the formation: so that calling it back means one of these, and no later one.
    withdrawals: AtomicU32,
}

impl VehicleCell {
    /// A vehicle that has just been adopted.
    #[must_use]
    pub fn new(
        id: VehicleId,
        name: String,
        system_id: SystemId,
        simulated: bool,
        model: Arc<LifeRecord>,
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
            actor: ArcSwapOption::default(),
            tick_waiting: AtomicBool::new(false),
            state: Mutex::default(),
            watch: Mutex::default(),
            under_way: Mutex::default(),
            itinerary: Mutex::default(),
            hand: Mutex::default(),
            route: Mutex::default(),
            stopped: AtomicBool::new(false),
            withdrawals: AtomicU32::new(0),
        }
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

    /// What it carries, by name.
    #[must_use]
    pub fn payloads(&self) -> Vec<Arc<PayloadCell>> {
        self.payloads.read().values().cloned().collect()
    }

    /// The payload of that name.
    #[must_use]
    pub fn payload(&self, name: &str) -> Option<Arc<PayloadCell>> {
        self.payloads.read().get(name).cloned()
    }
}

/// A link behind a thin pointer, so that it can be swapped.
pub struct LinkSlot(pub Arc<dyn VehicleLink>);

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
    pub ladder: Option<LadderState>,
}

/// All vehicles at one control period.
#[derive(Debug, Clone, Default)]
pub struct PeerSnapshot {
    /// When that control period began: what was known of them then is in here.
    pub made: NodeTime,
    /// By ascending id.
    pub entries: Vec<PeerEntry>,
    /// Everything in the air as the separation filter wants it, ours and not ours.
    pub surroundings: Surroundings,
    /// The formation's anchor, if it is no vehicle.
    pub anchor: Option<AnchorReference>,
}

/// One vehicle in a [`PeerSnapshot`].
#[derive(Debug, Clone, Copy)]
pub struct PeerEntry {
    /// Its id.
    pub id: VehicleId,
    /// Position, velocity, yaw in the swarm frame, as measured.
    pub kinematics: Option<VehicleKinematics>,
    /// Motors armed and not known to be on the ground.
    pub airborne: bool,
    /// Telemetry as the link gives it.
    pub telemetry: Telemetry,
    /// Its link.
    pub link: LinkHealth,
    /// Flight state.
    pub flight_state: FlightState,
    /// Its anchor while it leads.
    pub anchor: Option<AnchorReference>,
    /// Launch place in the swarm frame.
    pub home: Option<PositionNed>,
    /// What it can do, if its model says.
    pub limits: Option<FlightLimits>,
    /// A reaction of its ladder is in force: it takes no slot.
    pub under_order: bool,
    /// Its ladder took it out of the formation, and what that was for is over.
    pub may_rejoin: bool,
    /// Its charge against its way home.
    pub energy: Option<EnergyState>,
}

impl PeerSnapshot {
    /// The entry of a vehicle.
    #[must_use]
    pub fn entry(&self, id: VehicleId) -> Option<&PeerEntry> {
        self.entries
            .binary_search_by_key(&id, |e| e.id)
            .ok()
            .and_then(|i| self.entries.get(i))
    }
}

/// Puts telemetry into the swarm frame.
#[must_use]
pub fn kinematics(frame: &SwarmFrame, telemetry: &Telemetry) -> Option<VehicleKinematics> {
    let position = match (telemetry.local_frame, telemetry.local, telemetry.global) {
        (Some(local_frame), Some(local), _) => local_frame.to_swarm(frame, &local),
        (_, _, Some(global)) => frame.position(&global),
        _ => return None,
    };
    Some(VehicleKinematics {
        position,
        velocity: telemetry.velocity.unwrap_or_default(),
        yaw_rad: f64::from(telemetry.yaw_rad),
        measured: telemetry.position_time,
    })
}

/// Whether a vehicle must be counted as flying: armed, and not known to stand on the ground.
#[must_use]
pub fn airborne(telemetry: &Telemetry) -> bool {
    telemetry.armed && telemetry.landed != LandedState::OnGround
}
