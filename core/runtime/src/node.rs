//! The node actor: root of the supervision tree. It starts endpoints, fleet, control loop, coordinator and observer, and starts again
//! whichever of them ends.
//!
//! Must never do: wait for a child, or take part in flying.

use crate::clock::TokioClock;
use crate::control_loop::ControlLoop;
use crate::coordinator::Coordinator;
use crate::dds_links::{DdsLinks, DdsLinksArguments};
use crate::fleet::Fleet;
use crate::handle::serving::carry_out;
use crate::handle::{NodeHandle, Targets};
use crate::listening;
use crate::observer::Observer;
use crate::parts::Parts;
use crate::resume::{Keeper, KeeperArguments};
use crate::wiring::{self, WiringError};
use ractor::{Actor, ActorCell, ActorId, ActorProcessingErr, ActorRef, RpcReplyPort, SpawnErr, SupervisionEvent};
use skein_cluster::{Swarm, SwarmArguments, SwarmSetup};
use skein_config::NodeConfig;
use skein_dds::Place;
use skein_domain::exchange::Severity;
use skein_domain::{Clock, Incarnation, NodeTime};
use skein_link_mavlink::{Endpoint, EndpointArguments, EndpointSettings};
use skein_px4::LinkSettings;
use skein_state::restart::{Decision, NODE_LIMITS, RestartHistory};
use skein_streaming::RtpOut;
use skein_tracking::{Tracking, TrackingArguments};
use skein_view::{ActorHealth, ActorStatus, EventKind};
use std::collections::{BTreeMap, HashMap};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::task::JoinHandle;

/// Why a node could not be started.
#[derive(Debug, Error)]
pub enum NodeError {
    /// The configuration cannot be turned into a node.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// A part could not be started, for example because its port is in use.
    #[error("{part}: {reason}")]
    Part {
        /// Which part.
        part: String,
        /// Why.
        reason: String,
    },
}

/// A part of a node that this crate does not know, for example the gateway: how to start its actor under the node's supervision.
#[derive(Clone)]
pub struct Adapter {
    /// Its name in the supervision tree.
    pub name: String,
    /// Starts its actor, linked to the given supervisor; called again after each of its ends.
    pub start: AdapterStart,
}

/// Starts an adapter's actor and gives its id, or says why not. Must not wait for anything but its own `pre_start`.
pub type AdapterStart =
    Arc<dyn Fn(NodeHandle, ActorCell) -> Pin<Box<dyn Future<Output = Result<ActorId, String>> + Send>> + Send + Sync>;

/// A running node. Dropping it does not stop it; [`Node::stop`] does.
pub struct Node {
    handle: NodeHandle,
    root: ActorRef<NodeMessage>,
    ended: JoinHandle<()>,
}

impl Node {
    /// Builds and starts a node. Nothing is bound when the configuration is wrong.
    ///
    /// # Errors
    /// When the configuration does not make sense, a plugin is missing, or a port is in use.
    pub async fn start(
        config: NodeConfig,
        adapters: Vec<Adapter>,
        swarm: Option<SwarmSetup>,
        place: Arc<Place>,
    ) -> Result<Self, NodeError> {
        // In a swarm others tell of what was before this node started.
        let began = if swarm.is_some() {
            LONG_BEFORE
        } else {
            NodeTime::default()
        };
        let clock: Arc<dyn Clock> = Arc::new(TokioClock::start_at(began));
        let endpoints = wiring::endpoints(&config)?;
        let dds = config.flies_over_dds().then(|| (place, wiring::link_settings(&config)));
        let shared = Arc::new(wiring::shared(config, clock)?);
        let parts = Arc::new(Parts::default());
        let handle = NodeHandle::new(shared, parts);
        let shared = NodeArguments {
            handle: handle.clone(),
            endpoints,
            adapters,
            swarm,
            dds,
        };
        let failed = |reason: String| NodeError::Part {
            part: "node".into(),
            reason,
        };
        let (root, ended) = root(shared).await.map_err(|e| failed(e.to_string()))?;
        let started = root.call(NodeMessage::Start, Some(Duration::from_secs(10))).await;
        let node = Self { handle, root, ended };
        match started {
            Ok(ractor::rpc::CallResult::Success(Ok(()))) => Ok(node),
            Ok(ractor::rpc::CallResult::Success(Err(error))) => {
                node.stop().await;
                Err(error)
            }
            _ => {
                node.stop().await;
                Err(failed("did not start within 10 s".into()))
            }
        }
    }

    /// The handle to it.
    #[must_use]
    pub fn handle(&self) -> NodeHandle {
        self.handle.clone()
    }

    /// Stops all actors and waits for them.
    pub async fn stop(self) {
        self.root.stop(Some("stopped".into()));
        // An aborted root has ended too.
        let _ = self.ended.await;
    }
}

/// Starts the root actor. No `async fn`: the compiler makes the code of one in every crate that awaits it, and with this one that of all actors.
#[inline(never)]
fn root(arguments: NodeArguments) -> Pin<Box<dyn Future<Output = Result<Root, SpawnErr>> + Send>> {
    Box::pin(Actor::spawn(None, NodeActor, arguments))
}

type Root = (ActorRef<NodeMessage>, JoinHandle<()>);

/// The root actor.
struct NodeActor;

enum NodeMessage {
    Start(RpcReplyPort<Result<(), NodeError>>),
    Restart(Part),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Fleet,
    ControlLoop,
    Coordinator,
    Observer,
    Keeper,
    Tracking,
    Swarm,
    DdsLinks,
    Endpoint(usize),
    Rtp,
    Adapter(usize),
}

struct NodeArguments {
    handle: NodeHandle,
    endpoints: Vec<EndpointSettings>,
    adapters: Vec<Adapter>,
    swarm: Option<SwarmSetup>,
    /// If vehicles are looked for on DDS.
    dds: Option<(Arc<Place>, LinkSettings)>,
}

/// What the clock of a node in a swarm says when it starts: thirty days.
const LONG_BEFORE: NodeTime = NodeTime(30 * 86_400 * 1_000_000);

/// How often it is looked whether a coordinator that a drill keeps away may come back.
const AWAY_LOOK: Duration = Duration::from_millis(100);

struct NodeState {
    arguments: NodeArguments,
    children: HashMap<ActorId, Part>,
    records: BTreeMap<Part, (Incarnation, RestartHistory)>,
}

impl Actor for NodeActor {
    type Msg = NodeMessage;
    type State = NodeState;
    type Arguments = NodeArguments;

    async fn pre_start(
        &self,
        _: ActorRef<NodeMessage>,
        arguments: NodeArguments,
    ) -> Result<NodeState, ActorProcessingErr> {
        Ok(NodeState {
            arguments,
            children: HashMap::new(),
            records: BTreeMap::new(),
        })
    }

    async fn handle(
        &self,
        myself: ActorRef<NodeMessage>,
        message: NodeMessage,
        state: &mut NodeState,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            NodeMessage::Start(reply) => {
                let _ = reply.send(state.start_all(&myself).await);
            }
            NodeMessage::Restart(Part::Coordinator) if state.coordinator_is_away() => {
                myself.send_after(AWAY_LOOK, || NodeMessage::Restart(Part::Coordinator));
            }
            NodeMessage::Restart(part) => {
                if let Err(error) = state.start(&myself, part).await {
                    state.ended(&myself, part, &error.to_string());
                }
            }
        }
        Ok(())
    }

    async fn handle_supervisor_evt(
        &self,
        myself: ActorRef<NodeMessage>,
        event: SupervisionEvent,
        state: &mut NodeState,
    ) -> Result<(), ActorProcessingErr> {
        let (record, error): (ActorCell, String) = match event {
            SupervisionEvent::ActorFailed(record, error) => (record, error.to_string()),
            SupervisionEvent::ActorTerminated(record, _, reason) => (record, reason.unwrap_or_else(|| "ended".into())),
            _ => return Ok(()),
        };
        if let Some(part) = state.children.remove(&record.get_id()) {
            state.ended(&myself, part, &error);
        }
        Ok(())
    }
}

impl NodeState {
    async fn start_all(&mut self, myself: &ActorRef<NodeMessage>) -> Result<(), NodeError> {
        // The fleet first: endpoints report what they hear to it.
        let endpoints = (0..self.arguments.endpoints.len()).map(Part::Endpoint);
        let rtp = (!self.arguments.handle.config().video.rtp.is_empty()).then_some(Part::Rtp);
        let adapters = (0..self.arguments.adapters.len()).map(Part::Adapter);
        let first = [
            Part::Fleet,
            Part::Coordinator,
            Part::ControlLoop,
            Part::Observer,
            Part::Keeper,
            Part::Tracking,
        ];
        let swarm = self.arguments.swarm.as_ref().map(|_| Part::Swarm);
        let dds = self.arguments.dds.as_ref().map(|_| Part::DdsLinks);
        for part in first
            .into_iter()
            .chain(swarm)
            .chain(dds)
            .chain(endpoints)
            .chain(rtp)
            .chain(adapters)
        {
            self.start(myself, part).await?;
        }
        Ok(())
    }

    fn name(&self, part: Part) -> String {
        match part {
            Part::Fleet => "fleet".into(),
            Part::ControlLoop => "control-loop".into(),
            Part::Coordinator => "coordinator".into(),
            Part::Observer => "observer".into(),
            Part::Keeper => "keeper".into(),
            Part::Tracking => "tracking".into(),
            Part::Swarm => "swarm".into(),
            Part::DdsLinks => "dds-links".into(),
            Part::Rtp => "rtp".into(),
            Part::Endpoint(i) => self
                .arguments
                .endpoints
                .get(i)
                .map_or_else(|| "endpoint".into(), |e| format!("endpoint-{}", e.name)),
            Part::Adapter(i) => self
                .arguments
                .adapters
                .get(i)
                .map_or_else(|| "adapter".into(), |a| a.name.clone()),
        }
    }

    /// A drill keeps it from being started.
    fn coordinator_is_away(&self) -> bool {
        self.arguments.handle.shared().coordination.is_coordinator_away()
    }

    /// Starts a part and puts it on record.
    async fn start(&mut self, myself: &ActorRef<NodeMessage>, part: Part) -> Result<(), NodeError> {
        let name = self.name(part);
        let spawned = self.spawn(myself.get_cell(), part).await;
        let id = spawned.map_err(|reason| NodeError::Part {
            part: name.clone(),
            reason,
        })?;
        self.children.insert(id, part);
        let now = self.arguments.handle.now();
        let record = self.records.entry(part).or_default();
        record.0 = record.0.next();
        let health = ActorHealth {
            name: name.clone(),
            incarnation: record.0,
            since: now,
            ..ActorHealth::default()
        };
        self.publish(name, health);
        Ok(())
    }

    /// Spawns a part's actor. Each `pre_start` only takes what lies ready or binds a socket, so that nothing is waited for.
    async fn spawn(&self, parent: ActorCell, part: Part) -> Result<ActorId, String> {
        let (shared, parts) = (self.arguments.handle.shared().clone(), self.arguments.handle.parts());
        match part {
            Part::Fleet => {
                let fleet = spawned(Fleet::spawn_linked(None, Fleet, shared, parent).await)?;
                let id = fleet.get_id();
                parts.fleet.store(Some(Arc::new(fleet)));
                Ok(id)
            }
            Part::Coordinator => {
                let coordinator = spawned(Coordinator::spawn_linked(None, Coordinator, shared, parent).await)?;
                let id = coordinator.get_id();
                parts.coordinator.store(Some(Arc::new(coordinator)));
                Ok(id)
            }
            Part::ControlLoop => {
                Ok(spawned(ControlLoop::spawn_linked(None, ControlLoop, shared, parent).await)?.get_id())
            }
            Part::Observer => Ok(spawned(Observer::spawn_linked(None, Observer, shared, parent).await)?.get_id()),
            Part::Keeper => {
                let handle = self.arguments.handle.clone();
                let arguments = KeeperArguments { handle };
                Ok(spawned(Keeper::spawn_linked(None, Keeper, arguments, parent).await)?.get_id())
            }
            Part::Tracking => self.spawn_tracking(parent).await,
            Part::Swarm => {
                let handle = self.arguments.handle.clone();
                let arguments = swarm_arguments(handle, self.arguments.swarm.clone().ok_or("not configured")?);
                Ok(spawned(Swarm::spawn_linked(None, Swarm, arguments, parent).await)?.get_id())
            }
            Part::DdsLinks => {
                let (place, settings) = self.arguments.dds.clone().ok_or("not configured")?;
                let arguments = DdsLinksArguments {
                    shared,
                    parts: parts.clone(),
                    place,
                    settings,
                };
                Ok(spawned(DdsLinks::spawn_linked(None, DdsLinks, arguments, parent).await)?.get_id())
            }
            Part::Endpoint(i) => {
                let settings = self.arguments.endpoints.get(i).cloned().ok_or("not configured")?;
                let arguments = EndpointArguments {
                    settings,
                    clock: shared.clock.clone(),
                    links: parts.links.clone(),
                    events: listening::sink(&shared, parts),
                    references: Some(listening::sightings(&shared)),
                };
                Ok(spawned(Endpoint::spawn_linked(None, Endpoint, arguments, parent).await)?.get_id())
            }
            Part::Rtp => self.spawn_rtp(parent).await,
            Part::Adapter(i) => {
                let adapter = self.arguments.adapters.get(i).ok_or("not configured")?;
                (adapter.start)(self.arguments.handle.clone(), parent).await
            }
        }
    }

    async fn spawn_rtp(&self, parent: ActorCell) -> Result<ActorId, String> {
        let node = self.arguments.handle.clone();
        Ok(spawned(RtpOut::spawn_linked(None, RtpOut, node.streams(), parent).await)?.get_id())
    }

    async fn spawn_tracking(&self, parent: ActorCell) -> Result<ActorId, String> {
        let handle = self.arguments.handle.clone();
        let asked = handle.clone();
        let arguments = TrackingArguments {
            shared: handle.shared().clone(),
            ask: Arc::new(move |vehicle, command| {
                let asked = asked.clone();
                Box::pin(async move {
                    let receipts = asked.command(&Targets::Vehicles(vec![vehicle]), command).await;
                    receipts.iter().any(|receipt| receipt.refusal.is_some())
                })
            }),
        };
        let tracking = spawned(Tracking::spawn_linked(None, Tracking, arguments, parent).await)?;
        let id = tracking.get_id();
        handle.parts().tracking.store(Some(Arc::new(tracking)));
        Ok(id)
    }

    fn publish(&self, name: String, health: ActorHealth) {
        self.arguments.handle.shared().note_actor(name, health);
    }

    fn ended(&mut self, myself: &ActorRef<NodeMessage>, part: Part, error: &str) {
        match part {
            Part::Fleet => self.arguments.handle.parts().fleet.store(None),
            Part::Coordinator => self.arguments.handle.parts().coordinator.store(None),
            Part::Tracking => self.arguments.handle.parts().tracking.store(None),
            Part::Swarm => {
                if let Some(swarm) = &self.arguments.handle.shared().swarm {
                    swarm.speak_through(None);
                    swarm.silence();
                }
            }
            _ => {}
        }
        let now = self.arguments.handle.now();
        let name = self.name(part);
        let record = self.records.entry(part).or_default();
        let delay_s = match record.1.decide(&NODE_LIMITS, now, (now.0 % 1_000) as f64 / 1_000.0) {
            Decision::RestartAfter(delay_s) => delay_s,
            // These limits never give up; were it ever otherwise, the slowest pace is right for a part nothing flies without.
            Decision::GiveUp => NODE_LIMITS.max_delay_s,
        };
        let incarnation = record.0;
        let status = ActorStatus::Restarting;
        let kind = EventKind::Supervision {
            actor: name.clone(),
            status,
        };
        let text = format!("{name} ended ({error}); restarting");
        self.arguments
            .handle
            .shared()
            .events
            .record(now, None, Severity::Warning, kind, text);
        self.publish(
            name.clone(),
            ActorHealth {
                name,
                status,
                incarnation,
                last_error: error.to_owned(),
                since: now,
            },
        );
        // Through the mailbox even without a delay, so that one failing part cannot keep the node in this loop.
        myself.send_after(Duration::from_secs_f64(delay_s), move || NodeMessage::Restart(part));
    }
}

/// The actor that was spawned, or its own reason why it was not.
fn spawned<M>(result: Result<(ActorRef<M>, JoinHandle<()>), SpawnErr>) -> Result<ActorRef<M>, String> {
    match result {
        Ok((actor, _)) => Ok(actor),
        Err(SpawnErr::StartupFailed(cause)) => Err(cause.to_string()),
        Err(other) => Err(other.to_string()),
    }
}

/// What other nodes ask of this one goes through the handle, as what is asked here.
fn swarm_arguments(handle: NodeHandle, setup: SwarmSetup) -> SwarmArguments {
    SwarmArguments {
        shared: handle.shared().clone(),
        carry_out: Arc::new(move |ask, ahead_us| Box::pin(carry_out(handle.clone(), ask, ahead_us))),
        setup,
    }
}
