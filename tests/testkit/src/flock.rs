//! Several nodes of one swarm in the test's own process, each with a simulated vehicle and all over one hub: nodes that end and come
//! back, and ways between them that are cut. (Feature `swarm`.)
//!
//! Must never do: reach into a node. Each is asked through its handle, and judged by what its simulator knows.

mod referee;

pub use referee::Nearest;

use crate::{eventually, patience, plugins_dir, skein_binary};
use parking_lot::Mutex;
use referee::Referee;
use skein_bus::envelope::SwarmKey;
use skein_bus::local::{Hub, Local};
use skein_bus::transport::{Class, Datagram, SendError, To, Transport, Wake};
use skein_cluster::SwarmSetup;
use skein_config::{AdoptionRule, EndpointSettings, NodeConfig};
use skein_domain::{NodeId, NodeTime, PositionNed, VehicleId};
use skein_node::Running;
use skein_runtime::NodeHandle;
use skein_sim::{PortPlan, SimSettings, Simulation, TruthFrame, VehicleStart};
use skein_view::FleetSnapshot;
use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Name of the endpoint that a node's vehicle sends to.
const ENDPOINT: &str = "simulation";
/// Distance between the vehicles on the ground, in metres.
const SPACING_M: f64 = 6.0;

/// Ways that are cut: from whom to whom.
type Cuts = Arc<Mutex<BTreeSet<(NodeId, NodeId)>>>;

/// What the nodes of a flock are.
#[derive(Debug, Clone, Copy)]
pub struct Member {
    /// Its number; its vehicle has the same.
    pub node: u8,
    /// How suited it is to coordinate, if it is.
    pub priority: Option<u8>,
    /// It flies a vehicle. One on the ground does not.
    pub flies: bool,
}

struct Place {
    running: Option<Running>,
    member: Member,
    simulation: Option<Simulation>,
}

/// Several nodes. Call [`Flock::stop`] at the end of a test.
pub struct Flock {
    places: BTreeMap<u8, Place>,
    hub: Hub,
    cuts: Cuts,
    folder: PathBuf,
    adapt: fn(&mut NodeConfig),
    referee: Arc<Mutex<Referee>>,
}

impl Flock {
    /// These nodes, with files in this folder.
    ///
    /// # Panics
    /// If one cannot be started.
    pub async fn start(members: &[Member], folder: PathBuf, adapt: fn(&mut NodeConfig)) -> Self {
        let mut flock = Self {
            places: BTreeMap::new(),
            hub: Hub::default(),
            cuts: Cuts::default(),
            folder,
            adapt,
            referee: Arc::default(),
        };
        for member in members {
            let place = Place {
                running: None,
                member: *member,
                simulation: None,
            };
            flock.places.insert(member.node, place);
            flock.begin(member.node).await;
        }
        flock
    }

    /// Starts a node, with what its former run kept.
    ///
    /// # Panics
    /// If it cannot be started.
    pub async fn begin(&mut self, node: u8) {
        let member = self.places[&node].member;
        let config = self.config(&member);
        let (hub, cuts, id) = (self.hub.clone(), self.cuts.clone(), NodeId(u64::from(node)));
        let open = move || {
            let (local, cuts) = (hub.join(id), cuts.clone());
            Ok(Cut { local, cuts }.into())
        };
        let key = SwarmKey::derive("flock", b"a secret of the tests").unwrap_or_else(|e| panic!("{e}"));
        let setup = SwarmSetup {
            key,
            open: Arc::new(open),
        };
        let running = skein_node::build_in(config, Some(setup))
            .await
            .unwrap_or_else(|error| panic!("node {node} does not start: {error}"));
        running.handle().set_plugin_host_program(skein_binary());
        let place = self.places.get_mut(&node).unwrap_or_else(|| panic!("no node {node}"));
        if member.flies && place.simulation.is_none() {
            let address = running.handle().endpoint_addresses().get(ENDPOINT).copied();
            place.simulation = Some(simulation(node, address));
        }
        place.running = Some(running);
    }

    fn config(&self, member: &Member) -> NodeConfig {
        let mut config = NodeConfig::default();
        config.node.name = format!("node-{}", member.node);
        config.swarm.id = Some("flock".into());
        config.swarm.node = Some(u64::from(member.node));
        config.swarm.coordinator_priority = member.priority;
        config.swarm.state_file = Some(self.folder.join(format!("{}.term", member.node)));
        config.plugins.directories = vec![plugins_dir()];
        config.web.listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        config.faults.enabled = true;
        if member.flies {
            config.endpoints = vec![EndpointSettings {
                name: Some(ENDPOINT.into()),
                address: "udp-listen://127.0.0.1:0".into(),
            }];
            config.adopt = vec![AdoptionRule::default()];
        }
        (self.adapt)(&mut config);
        config
    }

    /// Begins to look how near the vehicles come to each other: from when they are up.
    pub fn judge(&self) {
        for (node, place) in &self.places {
            let Some(simulation) = &place.simulation else { continue };
            let (referee, node) = (self.referee.clone(), *node);
            let observe = move |frame: &TruthFrame| referee.lock().see(node, frame);
            simulation
                .observe(Box::new(observe))
                .unwrap_or_else(|error| panic!("{error}"));
        }
    }

    /// The smallest distance between two vehicles of which one was off the ground, since it was first asked to be looked at.
    #[must_use]
    pub fn nearest(&self) -> Nearest {
        self.referee.lock().nearest().clone()
    }

    /// Ends a node as if its computer failed: nobody is told. Its vehicle is left to its autopilot.
    ///
    /// # Panics
    /// If it does not run.
    pub async fn end(&mut self, node: u8) {
        let place = self.places.get_mut(&node).unwrap_or_else(|| panic!("no node {node}"));
        let running = place
            .running
            .take()
            .unwrap_or_else(|| panic!("node {node} does not run"));
        running.stop().await;
    }

    /// Cuts the ways between these and all others, both ways.
    pub fn part(&self, these: &[u8]) {
        let mut cuts = self.cuts.lock();
        for a in self.places.keys() {
            for b in self.places.keys().filter(|b| these.contains(a) != these.contains(b)) {
                cuts.insert((NodeId(u64::from(*a)), NodeId(u64::from(*b))));
            }
        }
    }

    /// All ways are open again.
    pub fn join(&self) {
        self.cuts.lock().clear();
    }

    /// The handle to a node that runs.
    ///
    /// # Panics
    /// If it does not.
    #[must_use]
    pub fn node(&self, node: u8) -> NodeHandle {
        let running = self.places[&node].running.as_ref();
        running.unwrap_or_else(|| panic!("node {node} does not run")).handle()
    }

    /// Where a node's API listens.
    ///
    /// # Panics
    /// If it does not.
    #[must_use]
    pub fn web_address(&self, node: u8) -> SocketAddr {
        let running = self.places[&node].running.as_ref();
        running
            .and_then(Running::web_address)
            .unwrap_or_else(|| panic!("node {node} does not listen"))
    }

    /// Numbers of the nodes that run.
    #[must_use]
    pub fn running(&self) -> Vec<u8> {
        self.places
            .iter()
            .filter(|(_, place)| place.running.is_some())
            .map(|(node, _)| *node)
            .collect()
    }

    /// The simulation of a node's vehicle.
    ///
    /// # Panics
    /// If it has none.
    #[must_use]
    pub fn simulation(&self, node: u8) -> &Simulation {
        self.places[&node]
            .simulation
            .as_ref()
            .unwrap_or_else(|| panic!("node {node} flies nothing"))
    }

    /// Waits until the fleet as this node sees it is as wanted.
    ///
    /// # Panics
    /// If it does not become so; the message holds the last picture.
    pub async fn until(
        &self,
        node: u8,
        what: &str,
        extra: Duration,
        wanted: impl Fn(&FleetSnapshot) -> bool,
    ) -> FleetSnapshot {
        let handle = self.node(node);
        let deadline = tokio::time::Instant::now() + patience() + extra;
        eventually(patience() + extra + Duration::from_secs(5), what, async || {
            let picture = handle.snapshot();
            let late = tokio::time::Instant::now() > deadline;
            assert!(
                !late || wanted(&picture),
                "node {node} waited in vain for {what}; last seen: {picture:#?}\n{}",
                self.told(node)
            );
            wanted(&picture).then(|| (*picture).clone())
        })
        .await
    }

    /// What has happened, as a node knows it.
    #[must_use]
    pub fn told(&self, node: u8) -> String {
        let line = |e: &Arc<skein_view::EventRecord>| {
            let on = e.node.map_or_else(String::new, |node| format!("node {node}: "));
            format!("{:.2} {on}{}\n", e.time.as_seconds(), e.text)
        };
        self.node(node).events_after(0).iter().map(line).collect()
    }

    /// Ends everything.
    pub async fn stop(self) {
        for place in self.places.into_values() {
            if let Some(simulation) = place.simulation {
                simulation.stop();
            }
            if let Some(running) = place.running {
                running.stop().await;
            }
        }
    }
}

fn simulation(node: u8, address: Option<SocketAddr>) -> Simulation {
    let (row, column) = (f64::from(node / 3), f64::from(node % 3));
    let settings = SimSettings {
        seed: u64::from(node),
        starts: vec![VehicleStart {
            system_id: Some(node),
            position: PositionNed::new(row * SPACING_M, column * SPACING_M, 0.0),
            ..VehicleStart::default()
        }],
        ports: PortPlan::SendTo(address.unwrap_or_else(|| panic!("the endpoint is not bound"))),
        ..SimSettings::default()
    };
    Simulation::start(settings).unwrap_or_else(|error| panic!("no simulation: {error}"))
}

/// A place at the hub whose ways may be cut.
struct Cut {
    local: Local,
    cuts: Cuts,
}

impl Transport for Cut {
    fn node(&self) -> NodeId {
        self.local.node()
    }

    fn largest_bytes(&self) -> usize {
        self.local.largest_bytes()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.local.send(now, to, class, bytes)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        loop {
            let datagram = self.local.receive(now)?;
            if !self.cuts.lock().contains(&(datagram.from, self.local.node())) {
                return Some(datagram);
            }
        }
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.local.wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        self.local.overflowed()
    }
}

/// All vehicles of these numbers.
#[must_use]
pub fn vehicles(of: &[u8]) -> Vec<VehicleId> {
    of.iter().map(|id| VehicleId(u16::from(*id))).collect()
}
