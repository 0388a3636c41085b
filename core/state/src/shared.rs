//! The shared state: what the actors of a node share by reading instead of asking. Immutable snapshots of peers and intent, one record
//! per vehicle that outlives its actor, the gate, the event log.
//!
//! Must never do: wait, or hold a lock across an await.

use crate::asks::{Answer, Ask};
use crate::cluster::share::SwarmShare;
use crate::coordination::SharedCoordination;
use crate::mailbox::asking;
use crate::observed::Observed;
use crate::operators::Operators;
use crate::overrun::{Overrun, OverrunEvent};
use crate::plugins::Plugins;
use crate::recordings::Recordings;
use crate::resume::Resume;
use crate::tape::Tape;
use crate::vehicles::Vehicles;
use crate::video::VideosElsewhere;
use arc_swap::{ArcSwap, ArcSwapOption};
use parking_lot::Mutex;
use skein_config::NodeConfig;
use skein_domain::fence::FencePlan;
use skein_domain::{Clock, Geodetic, LogFetch, NodeId, NodeTime, Refusal, SwarmFrame, VehicleId};
use skein_plugin_host::Catalog;
use skein_safety::control::ControlTable;
use skein_safety::{FencePlanError, Fences, Gate};
use skein_view::{ActorHealth, EventLog, FleetSnapshot, PeerSnapshot, RecorderStatus};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Everything the actors of one node share.
pub struct SharedState {
    /// The configuration the node was built with.
    pub config: NodeConfig,
    /// The node's clock.
    pub clock: Arc<dyn Clock>,
    /// Events.
    pub events: EventLog,
    /// What operators have told.
    pub operators: Operators,
    /// This node's vehicles.
    pub vehicles: Vehicles,
    /// Its plugins.
    pub plugins: Plugins,
    /// What the coordinator wants.
    pub coordination: SharedCoordination,
    /// What is known of others than the swarm's vehicles.
    pub observed: Observed,
    /// Videos between nodes.
    pub videos: VideosElsewhere,
    /// Videos that are being recorded.
    pub recordings: Recordings,
    /// What the recorder is told.
    pub tape: Arc<Tape>,
    /// What it says of itself.
    pub recorder: ArcSwap<RecorderStatus>,
    /// What was flown when the node was killed, and who of it is taken back.
    pub resume: Resume,
    /// Logs of autopilots that are fetched, and were last.
    pub log_fetches: Mutex<BTreeMap<VehicleId, LogFetch>>,
    /// The swarm this node is part of, if any.
    pub swarm: Option<SwarmShare>,
    /// The safety gate; replaced as a whole when the fences change.
    gate: ArcSwap<Gate>,
    /// The fences as they were described.
    fence_plan: Mutex<FencePlan>,
    /// The swarm's common frame, once known. Set once: positions given before must keep their meaning.
    frame: ArcSwapOption<SwarmFrame>,
    /// Peers of the present control period.
    peers: ArcSwap<PeerSnapshot>,
    /// The picture for screens.
    picture: ArcSwap<FleetSnapshot>,
    /// Health of the node's own actors by name.
    actors: Mutex<BTreeMap<String, ActorHealth>>,
    /// Whether this computer's control loop comes in time.
    overrun: Mutex<Overrun>,
    /// The node is stopping: nobody goes into OFFBOARD any more.
    stopping: AtomicBool,
    /// Another version is about to be started, or is on trial: nothing is armed.
    arming_held: AtomicBool,
    next_command: AtomicU64,
}

impl SharedState {
    /// Asks another node of the swarm.
    ///
    /// # Errors
    /// Its refusal, or that this node has no part in a swarm, or the actor for it has just died.
    pub async fn ask(&self, node: NodeId, ask: Ask, within: Duration) -> Result<Answer, Refusal> {
        let not_running = || Refusal::not_running("this node's part in a swarm");
        let actor = self.swarm.as_ref().and_then(|swarm| swarm.actor());
        let (message, answered) = asking(node, ask, within);
        actor
            .ok_or_else(not_running)?
            .cast(message)
            .map_err(|_| not_running())?;
        answered.await.map_err(|_| not_running())?
    }

    /// An empty one.
    #[must_use]
    pub fn new(config: NodeConfig, clock: Arc<dyn Clock>, gate: Gate, fence_plan: FencePlan, catalog: Catalog) -> Self {
        let frame = config.swarm.origin.map(|origin| Arc::new(SwarmFrame::new(origin)));
        let node = config.swarm.id.as_ref().and(config.swarm.node).map(NodeId);
        let swarm = node.map(|node| SwarmShare::new(node, config.swarm.observer));
        let (events, now) = (EventLog::default(), clock.now());
        let resume = Resume::open(&config, &events, now);
        let mut control = ControlTable::new(node.unwrap_or(NodeId(0)));
        resume.hand_back(&mut control, now);
        Self {
            operators: Operators::new(control),
            vehicles: Vehicles::default(),
            plugins: Plugins::new(catalog, &config.plugins),
            coordination: SharedCoordination::default(),
            observed: Observed::new(config.safety.max_speed_m_s, config.tracking.steer_by_fused),
            swarm,
            config,
            clock,
            gate: ArcSwap::from_pointee(gate),
            fence_plan: Mutex::new(fence_plan),
            events,
            videos: VideosElsewhere::default(),
            recordings: Recordings::default(),
            tape: Arc::default(),
            recorder: ArcSwap::default(),
            resume,
            log_fetches: Mutex::default(),
            frame: ArcSwapOption::from(frame),
            peers: ArcSwap::default(),
            picture: ArcSwap::default(),
            actors: Mutex::default(),
            overrun: Mutex::default(),
            stopping: AtomicBool::new(false),
            arming_held: AtomicBool::new(false),
            // Each node of a swarm counts from elsewhere, so that a command can be told from another node's.
            next_command: AtomicU64::new(node.map_or(0, |node| node.0 & 0x1FFF) << 40 | 1),
        }
    }

    /// The safety gate.
    #[must_use]
    pub fn gate(&self) -> Arc<Gate> {
        self.gate.load_full()
    }

    /// The fences as they were described.
    #[must_use]
    pub fn fence_plan(&self) -> FencePlan {
        self.fence_plan.lock().clone()
    }

    /// Other fences from now on.
    ///
    /// # Errors
    /// When a zone cannot be one, or cannot be placed yet.
    pub fn set_fences(&self, plan: FencePlan) -> Result<(), FencePlanError> {
        let fences = Fences::from_plan(&plan, self.frame().as_ref())?;
        let gate = Gate::new(*self.gate().limits(), fences).with_min_height(self.gate().min_height_m());
        *self.fence_plan.lock() = plan;
        self.gate.store(Arc::new(gate));
        Ok(())
    }

    /// A recording says that this gate, with these fences, was in force.
    pub fn hold_gate(&self, gate: Gate, plan: FencePlan) {
        *self.fence_plan.lock() = plan;
        self.gate.store(Arc::new(gate));
    }

    /// All vehicles at the present control period.
    #[must_use]
    pub fn peers(&self) -> Arc<PeerSnapshot> {
        self.peers.load_full()
    }

    /// The control loop has read all links.
    pub fn publish_peers(&self, peers: PeerSnapshot) {
        self.peers.store(Arc::new(peers));
    }

    /// The newest picture for screens.
    #[must_use]
    pub fn picture(&self) -> Arc<FleetSnapshot> {
        self.picture.load_full()
    }

    /// The observer has made a picture.
    pub fn publish_picture(&self, picture: FleetSnapshot) {
        self.picture.store(Arc::new(picture));
    }

    /// Health of the node's own actors.
    #[must_use]
    pub fn actors(&self) -> Vec<ActorHealth> {
        self.actors.lock().values().cloned().collect()
    }

    /// The node says how one of its actors is; without an error the last one stays known.
    pub fn note_actor(&self, name: String, mut health: ActorHealth) {
        let mut actors = self.actors.lock();
        if health.last_error.is_empty()
            && let Some(before) = actors.get(&name)
        {
            health.last_error.clone_from(&before.last_error);
        }
        actors.insert(name, health);
    }

    /// The control loop ticks; what there is to tell of that.
    pub fn note_tick(&self, now: NodeTime, period_s: f64) -> Option<OverrunEvent> {
        self.overrun.lock().tick(now, period_s)
    }

    /// Whether the control loop comes in time, to be read.
    pub fn overrun(&self) -> impl Deref<Target = Overrun> {
        self.overrun.lock()
    }

    /// The node is stopping from now on: nobody goes into OFFBOARD any more, and nothing is kept for a restart.
    pub fn begin_stopping(&self) {
        self.stopping.store(true, Ordering::Release);
    }

    /// Whether the node is stopping.
    #[must_use]
    pub fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Acquire)
    }

    /// Nothing is armed from now on, or it may be again: while another version is about to be started, and while this one is on trial.
    pub fn hold_arming(&self, held: bool) {
        self.arming_held.store(held, Ordering::Release);
    }

    /// Whether nothing is armed for the sake of another version.
    #[must_use]
    pub fn is_arming_held(&self) -> bool {
        self.arming_held.load(Ordering::Acquire)
    }

    /// When the coordinator that this node obeys last gave a sign of life.
    #[must_use]
    pub fn coordinator_seen(&self) -> NodeTime {
        let swarm = self.swarm.as_ref();
        let elsewhere = swarm.and_then(|swarm| swarm.role().coordinator_seen);
        elsewhere.unwrap_or_else(|| self.coordination.coordinator_seen())
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
        self.swarm.as_ref().is_none_or(|swarm| swarm.role().acting.is_some())
    }

    /// Whether this node may fix the swarm's frame: alone, or because nobody disputes that it coordinates.
    #[must_use]
    pub fn may_fix_frame(&self, now: NodeTime) -> bool {
        let swarm = self.swarm.as_ref();
        swarm.is_none_or(|swarm| swarm.role().is_undisputed(now))
    }

    /// Which other node flies a vehicle; none if this one does, or nobody.
    #[must_use]
    pub fn host(&self, vehicle: VehicleId) -> Option<NodeId> {
        if self.vehicles.record(vehicle).is_some() {
            return None;
        }
        self.swarm.as_ref()?.host(vehicle)
    }

    /// All vehicles of the swarm, this node's and others', by ascending id.
    #[must_use]
    pub fn vehicle_ids(&self) -> Vec<VehicleId> {
        let own = self.vehicles.records();
        let mut ids: BTreeSet<VehicleId> = own.iter().map(|record| record.id).collect();
        if let Some(swarm) = &self.swarm {
            ids.extend(swarm.vehicles().keys());
        }
        ids.into_iter().collect()
    }
}
