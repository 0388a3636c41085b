//! The shared state: what the actors of a node share by reading instead of asking. Immutable snapshots of peers and intent, one record
//! per vehicle that outlives its actor, the gate, the event log.
//!
//! Must never do: wait, or hold a lock across an await.

use crate::by_hand::Relays;
use crate::cluster::share::SwarmShare;
use crate::emergency::EmergencyUnlock;
use crate::overrun::Overrun;
use crate::resume::Resume;
use crate::vehicle::VehicleRecord;
use arc_swap::{ArcSwap, ArcSwapOption};
use parking_lot::{Mutex, RwLock};
use skein_config::NodeConfig;
use skein_coordination::{AnchorKeeper, Coordination, OwnTracks, References};
use skein_domain::fence::FencePlan;
use skein_domain::payload::Track;
use skein_domain::preflight::PreflightOverride;
use skein_domain::{Clock, Geodetic, Intent, NodeId, NodeTime, SwarmFrame, VehicleId};
use skein_link_mavlink::Sightings;
use skein_plugin_host::{Catalog, Runners};
use skein_px4::PairedLink;
use skein_safety::control::ControlTable;
use skein_safety::{FencePlanError, Fences, Gate};
use skein_view::{ActorHealth, EventLog, FleetSnapshot, PeerSnapshot, RestartRecord, UnadoptedVehicle};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Everything the actors of one node share.
pub struct SharedState {
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
    records: RwLock<BTreeMap<VehicleId, Arc<VehicleRecord>>>,
    /// Vehicles that are flown over two links.
    pub pairs: Mutex<BTreeMap<VehicleId, Arc<PairedLink>>>,
    /// Vehicles heard but not flown.
    pub unadopted: Mutex<Vec<UnadoptedVehicle>>,
    /// Health of the node's own actors by name.
    pub actors: Mutex<BTreeMap<String, ActorHealth>>,
    /// Restarts of plugin instances, the newest last; as many as are kept.
    pub restarts: Mutex<VecDeque<RestartRecord>>,
    /// Whether this computer's control loop comes in time.
    pub overrun: Mutex<Overrun>,
    /// Held while the instances of a plugin are exchanged for another version.
    pub exchanging: tokio::sync::Mutex<()>,
    /// Aircraft and movers that were sighted over MAVLink.
    pub sightings: Sightings,
    /// Things that formations may be anchored to.
    pub references: References,
    /// Which console has control authority over which vehicles.
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

impl SharedState {
    /// An empty one.
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
            records: RwLock::default(),
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

    /// Whether this node's coordinator decides: alone, or because it holds the leadership in its swarm.
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
    pub fn withdraw(&self, record: &VehicleRecord) -> bool {
        record.note_withdrawal();
        self.withdrawn.lock().insert(record.id)
    }

    /// Which other node flies a vehicle; none if this one does, or nobody.
    #[must_use]
    pub fn host(&self, vehicle: VehicleId) -> Option<NodeId> {
        if self.records.read().contains_key(&vehicle) {
            return None;
        }
        self.swarm.as_ref()?.host(vehicle)
    }

    /// All vehicles of the swarm, this node's and others', by ascending id.
    #[must_use]
    pub fn vehicle_ids(&self) -> Vec<VehicleId> {
        let mut ids: BTreeSet<VehicleId> = self.records.read().keys().copied().collect();
        if let Some(swarm) = &self.swarm {
            ids.extend(swarm.vehicles.read().keys());
        }
        ids.into_iter().collect()
    }

    /// The record of the vehicle.
    #[must_use]
    pub fn record(&self, id: VehicleId) -> Option<Arc<VehicleRecord>> {
        self.records.read().get(&id).cloned()
    }

    /// All records by ascending id.
    #[must_use]
    pub fn records(&self) -> Vec<Arc<VehicleRecord>> {
        self.records.read().values().cloned().collect()
    }

    /// Adds a vehicle; the one with the same id, if any, is replaced.
    pub fn insert_record(&self, record: Arc<VehicleRecord>) {
        self.records.write().insert(record.id, record);
    }
}
