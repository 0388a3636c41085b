//! A whole node, built by the function the program itself uses, with simulated vehicles on its endpoint. (Feature `swarm`.)
//!
//! Must never do: reach into the node. It is flown through `NodeHandle`, and judged by what the simulator knows.

use crate::{eventually, patience, plugins_dir, skein_binary};
use skein_config::{AdoptionRule, EndpointSettings, NodeConfig};
use skein_domain::{FlightState, VehicleCommand};
use skein_node::Running;
use skein_runtime::{NodeHandle, Targets};
use skein_sim::{PortPlan, SimSettings, Simulation, TruthFrame};
use skein_view::FleetSnapshot;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

/// Name of the endpoint that the vehicles send to.
const ENDPOINT: &str = "simulation";
/// What a climb to test height takes, all vehicles together, beyond our patience.
const CLIMB: Duration = Duration::from_secs(30);

/// A node and its simulated vehicles. Call [`Swarm::stop`] at the end of a test.
pub struct Swarm {
    running: Running,
    simulation: Simulation,
    vehicles: usize,
}

impl Swarm {
    /// So many vehicles, with settings for tests: loopback, free ports, faults permitted.
    ///
    /// # Panics
    /// If it cannot be started.
    pub async fn start(vehicles: usize) -> Self {
        Self::start_with(vehicles, |_, _| ()).await
    }

    /// As [`Self::start`], after `adapt` has changed what it wants of both settings.
    ///
    /// # Panics
    /// If it cannot be started.
    pub async fn start_with(vehicles: usize, adapt: impl FnOnce(&mut NodeConfig, &mut SimSettings)) -> Self {
        let mut config = NodeConfig {
            endpoints: vec![EndpointSettings {
                name: Some(ENDPOINT.into()),
                address: "udp-listen://127.0.0.1:0".into(),
            }],
            adopt: vec![AdoptionRule::default()],
            ..NodeConfig::default()
        };
        config.plugins.directories = vec![plugins_dir()];
        config.web.listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        config.faults.enabled = true;
        let mut settings = SimSettings {
            vehicles,
            ..SimSettings::default()
        };
        adapt(&mut config, &mut settings);
        let running = skein_node::build(config)
            .await
            .unwrap_or_else(|error| panic!("the node does not start: {error}"));
        // A test is not the program that a child process is made of.
        running.handle().set_plugin_host_program(skein_binary());
        let address = running.handle().endpoint_addresses().get(ENDPOINT).copied();
        settings.ports = PortPlan::SendTo(address.expect("the endpoint is bound"));
        let simulation = Simulation::start(settings).unwrap_or_else(|error| panic!("no simulation: {error}"));
        Self {
            running,
            simulation,
            vehicles,
        }
    }

    /// The handle to the node.
    #[must_use]
    pub fn node(&self) -> NodeHandle {
        self.running.handle()
    }

    /// The simulation: the truth, and what may happen to vehicles.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// What is really the case after all that the node has been told by now: the simulation publishes the truth a moment after it speaks.
    ///
    /// # Panics
    /// If the simulation publishes nothing more.
    pub async fn truth_now(&self) -> Arc<TruthFrame> {
        let before = self.simulation.truth().sequence;
        eventually(patience(), "the next frame of the truth", async || {
            Some(self.simulation.truth()).filter(|truth| truth.sequence > before)
        })
        .await
    }

    /// Where API and dashboard listen.
    #[must_use]
    pub fn web_address(&self) -> SocketAddr {
        self.running.web_address().expect("the API is served")
    }

    /// Waits until the picture of the fleet is as wanted, `extra` longer than our patience, and returns it.
    ///
    /// # Panics
    /// If it does not become so; the message holds the last picture.
    pub async fn until(&self, what: &str, extra: Duration, wanted: impl Fn(&FleetSnapshot) -> bool) -> FleetSnapshot {
        let node = self.node();
        let deadline = tokio::time::Instant::now() + patience() + extra;
        eventually(patience() + extra + Duration::from_secs(5), what, async || {
            let picture = node.snapshot();
            let late = tokio::time::Instant::now() > deadline;
            assert!(
                !late || wanted(&picture),
                "waited in vain for {what}; last seen: {picture:#?}"
            );
            wanted(&picture).then(|| (*picture).clone())
        })
        .await
    }

    /// Waits until all vehicles are found, ready to arm, and nothing in the preflight report keeps them from it.
    ///
    /// # Panics
    /// If they are not in time.
    pub async fn ready(&self) -> FleetSnapshot {
        let count = self.vehicles;
        let node = self.node();
        let wanted = |fleet: &FleetSnapshot| {
            let all_ready = fleet.vehicles.iter().all(|v| v.ready_to_arm == Some(true));
            fleet.vehicles.len() == count && all_ready && node.preflight().is_green()
        };
        self.until("all vehicles found and ready to arm", Duration::ZERO, wanted)
            .await
    }

    /// Gives all vehicles a command that each of them must take up.
    ///
    /// # Panics
    /// If one refuses.
    pub async fn command_all(&self, command: VehicleCommand) {
        let receipts = self.node().command(&Targets::All, command).await;
        assert!(!receipts.is_empty(), "there is no vehicle to {}", command.name());
        for receipt in receipts {
            assert_eq!(
                receipt.refusal,
                None,
                "vehicle {} refuses to {}",
                receipt.vehicle,
                command.name()
            );
        }
    }

    /// Takes all vehicles up to a height and waits until they hold there.
    ///
    /// # Panics
    /// If one refuses, or does not come up in time.
    pub async fn take_off(&self, height_m: f64) -> FleetSnapshot {
        self.ready().await;
        self.command_all(VehicleCommand::TakeOff { height_m }).await;
        let holding = |fleet: &FleetSnapshot| fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding);
        self.until("all vehicles up and holding", CLIMB, holding).await
    }

    /// Ends simulation and node.
    pub async fn stop(self) {
        self.simulation.stop();
        self.running.stop().await;
    }
}
