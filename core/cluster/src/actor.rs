//! The swarm actor: this node's voice among the other nodes. It tells what its vehicles do, hears what others tell, knows who coordinates
//! and takes the leadership when it is this node's turn; what it hears is in the shared state for everybody else.
//!
//! Bound: one wake-up waits at most; all else is bounded in the bus. Must never do: let a vehicle wait; let anything leave the node that
//! follows from a term before that term is stored; carry out orders of a term that is not obeyed.

mod inbound;
mod leadership;
mod messages;
mod outbound;
mod tracking;
mod videos;

use crate::asks::Asks;
use crate::orders::Orders;
use crate::store::TermStore;
use inbound::Known;
use outbound::OutboundState;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_bus::envelope::{Boot, SwarmKey};
use skein_bus::redundant::Ways;
use skein_bus::transport::Transport;
use skein_bus::{Bus, BusSettings};
use skein_config::Apart;
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime};
use skein_failover::{LeaderMonitor, LeaderMonitorSettings, Leadership, Term, Turn, Unled};
use skein_state::asks::{Answer, Ask};
use skein_state::{SharedState, SwarmMessage};
use skein_view::{EventKind, EventRecord};
use std::collections::BTreeMap;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::broadcast;
use tokio::task::JoinHandle;
use tracking::TrackingTold;
use videos::Videos;

/// A transport that has begun.
pub struct OpenedTransport {
    /// The transport.
    pub transport: Box<dyn Transport>,
    /// If it is two in one: their names, and how each is.
    pub ways: Option<([String; 2], Ways)>,
}

impl<T: Transport + 'static> From<T> for OpenedTransport {
    fn from(transport: T) -> Self {
        Self {
            transport: Box::new(transport),
            ways: None,
        }
    }
}

/// Makes the transport; called again when the actor is restarted. May wait: it is called where that is allowed.
pub type OpenTransport = Arc<dyn Fn() -> Result<OpenedTransport, String> + Send + Sync>;

/// How a node is part of its swarm, beside its configuration.
#[derive(Clone)]
pub struct SwarmSetup {
    /// The swarm's key.
    pub key: SwarmKey,
    /// The transport.
    pub open: OpenTransport,
}

/// How often the bus is looked at though nothing arrives.
const LOOK: Duration = Duration::from_millis(10);

/// The actor.
pub struct Swarm;

/// Does what another node asks of this one. The number says by how many microseconds this node's clock is ahead of the asker's, if that was
/// measured.
pub type CarryOut = Arc<dyn Fn(Ask, Option<i64>) -> Pin<Box<dyn Future<Output = Answer> + Send>> + Send + Sync>;

/// What it is started with.
pub struct SwarmArguments {
    /// What the actors of this node share.
    pub shared: Arc<SharedState>,
    /// Does what other nodes ask.
    pub carry_out: CarryOut,
    /// Key and transport.
    pub setup: SwarmSetup,
}

/// State. What must survive a restart is in the shared state, the term in its file.
pub struct SwarmState {
    shared: Arc<SharedState>,
    carry_out: CarryOut,
    bus: Bus,
    transport: Box<dyn Transport>,
    ways: Option<([String; 2], Ways)>,
    /// Why the transport did not take a datagram, if it did not.
    transport_fault: Option<String>,
    leadership: Leadership,
    monitor: LeaderMonitor,
    unled: Unled,
    store: TermStore,
    nodes: BTreeMap<NodeId, Known>,
    asks: Asks,
    told: OutboundState,
    tracking: TrackingTold,
    /// Orders that are obeyed, but whose moments cannot be reckoned yet.
    pending: Option<(NodeId, Orders)>,
    /// The holder whose leadership it took because that one was missed.
    lost_leader: Option<NodeId>,
    /// The term it acts in, as everybody here was last told.
    noted: Option<Term>,
    /// What it was to do about the leadership when it looked last.
    turn: Option<Turn>,
    /// It has heard another node in this run.
    had_company: bool,
    videos: Videos,
    events: broadcast::Receiver<Arc<EventRecord>>,
    look_waiting: Arc<AtomicBool>,
    looks: JoinHandle<()>,
}

impl Drop for SwarmState {
    fn drop(&mut self) {
        self.looks.abort();
    }
}

impl Actor for Swarm {
    type Msg = SwarmMessage;
    type State = SwarmState;
    type Arguments = SwarmArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<SwarmMessage>,
        arguments: SwarmArguments,
    ) -> Result<SwarmState, ActorProcessingErr> {
        let SwarmArguments {
            shared,
            carry_out,
            setup,
        } = arguments;
        let open = setup.open.clone();
        let OpenedTransport { mut transport, ways } = tokio::task::spawn_blocking(move || open()).await??;
        let look_waiting = Arc::new(AtomicBool::new(false));
        let wake = {
            let (myself, waiting) = (myself.clone(), look_waiting.clone());
            move || {
                if !waiting.swap(true, Ordering::AcqRel) && myself.cast(SwarmMessage::Look).is_err() {
                    waiting.store(false, Ordering::Release);
                }
            }
        };
        transport.wake_on_arrival(Arc::new(wake.clone()));
        let looks = tokio::spawn(async move {
            let mut interval = tokio::time::interval(LOOK);
            interval.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
            loop {
                interval.tick().await;
                wake();
            }
        });
        let state = SwarmState::new(shared, carry_out, &setup, transport, ways, look_waiting, looks)?;
        if let Some(swarm) = &state.shared.swarm {
            swarm.speak_through(Some(myself));
        }
        Ok(state)
    }

    async fn handle(
        &self,
        myself: ActorRef<SwarmMessage>,
        message: SwarmMessage,
        state: &mut SwarmState,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            SwarmMessage::Look => state.look_waiting.store(false, Ordering::Release),
            SwarmMessage::Ask {
                to,
                ask,
                within,
                answer,
            } => state.ask(to, &ask, within, answer),
            SwarmMessage::Served { to, id, answer } => state.served(to, id, &answer),
            SwarmMessage::ExpectVideo { from, stream, number } => drop(number.send(state.expect_video(from, *stream))),
            SwarmMessage::ForgetVideo { from, number } => state.forget_video(from, number),
            SwarmMessage::EndVideo { to, number } => state.bus.end_video(to, number),
            SwarmMessage::WantVideoKey { from, number } => state.bus.want_video_key(from, number),
            SwarmMessage::SendVideo {
                to,
                number,
                frame,
                taken,
            } => {
                let now = state.shared.now();
                // Who does not wait for the answer goes on without it.
                let _ = taken.send(state.send_video(now, to, number, &frame));
            }
            SwarmMessage::TakeLeadership(answer) => drop(answer.send(state.take_leadership())),
        }
        state.look(&myself);
        Ok(())
    }
}

impl SwarmState {
    fn new(
        shared: Arc<SharedState>,
        carry_out: CarryOut,
        setup: &SwarmSetup,
        transport: Box<dyn Transport>,
        ways: Option<([String; 2], Ways)>,
        look_waiting: Arc<AtomicBool>,
        looks: JoinHandle<()>,
    ) -> Result<Self, ActorProcessingErr> {
        let now = shared.now();
        let settings = &shared.config.swarm;
        let me = NodeId(settings.node.unwrap_or_default());
        let store = TermStore::open(settings.state_file.clone());
        let leadership = Leadership::new(me, store.load()?);
        let monitor = LeaderMonitor::new(
            LeaderMonitorSettings {
                lost_after_s: settings.lost_after_s,
                apart: match settings.apart {
                    Apart::EveryPart => skein_failover::Apart::EveryPart,
                    Apart::Majority => skein_failover::Apart::Majority,
                },
                swarm_size: settings.members,
                ..LeaderMonitorSettings::default()
            },
            now,
        );
        let mut bus_settings = BusSettings {
            datagram_bytes: transport.largest_bytes(),
            ..BusSettings::default()
        };
        bus_settings.budget.bytes_per_s = settings.max_bytes_per_s;
        bus_settings.sends_to_each = transport.sends_to_each();
        // A run of its own: with the nonces it makes, no two may ever be the same.
        let boot = Boot(rand::random());
        Ok(Self {
            bus: Bus::new(bus_settings, setup.key.clone(), me, boot, now),
            transport,
            ways,
            transport_fault: None,
            leadership,
            monitor,
            unled: Unled::default(),
            store,
            nodes: BTreeMap::new(),
            asks: Asks::default(),
            told: OutboundState::default(),
            tracking: TrackingTold::default(),
            pending: None,
            lost_leader: None,
            noted: None,
            turn: None,
            had_company: false,
            videos: Videos::default(),
            events: shared.events.subscribe(),
            look_waiting,
            looks,
            shared,
            carry_out,
        })
    }

    /// Takes in what has arrived, decides, tells, sends.
    fn look(&mut self, myself: &ActorRef<SwarmMessage>) {
        let now = self.shared.now();
        self.monitor.look(now);
        self.take(myself, now);
        self.decide(now);
        self.tell(now);
        self.send(now);
        self.publish(now);
    }

    /// Sends what is due. What a transport does not take is lost, as on the way.
    fn send(&mut self, now: NodeTime) {
        // What follows from a term leaves only once the term is stored.
        if let Err(error) = self.store.save(self.leadership.obeyed()) {
            if self.transport_fault.is_none() {
                self.record(Severity::Critical, format!("nothing is told to the swarm: {error}"));
            }
            self.transport_fault = Some(error.to_string());
            return;
        }
        let before = self.transport_fault.take();
        while let Some(out) = self.bus.next(now) {
            if let Err(error) = self.transport.send(now, out.to, out.class, &out.bytes) {
                self.transport_fault = Some(error.to_string());
                break;
            }
        }
        if let (None, Some(fault)) = (&before, &self.transport_fault) {
            self.record(Severity::Warning, format!("the swarm is not reached: {fault}"));
        }
    }

    fn record(&self, severity: Severity, text: impl Into<String>) {
        self.shared
            .events
            .record(self.shared.now(), None, severity, EventKind::Swarm, text);
    }
}
