//! The commands of a compose file, for hosts that are namespaces in place of containers.
//!
//! Must never do: leave out a word of a command; what a container has and a namespace has not is said after them.

use crate::field::{SECRET, usual};
use crate::host::{ORIGIN, Plan};
use serde::Deserialize;
use skein_testkit::plugins_dir;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

/// Where a container has the configurations.
const MOUNTED: &str = "/etc/skein/";

#[derive(Deserialize)]
struct File {
    services: BTreeMap<String, Service>,
}

#[derive(Deserialize, Clone)]
struct Service {
    #[serde(default)]
    command: Vec<String>,
    #[serde(default)]
    network_mode: String,
}

/// What one host runs.
#[derive(Debug, Clone)]
pub struct Composed {
    node: Vec<String>,
    simulation: Vec<String>,
}

/// The hosts of a compose file: its vehicles, each with the simulation that shares its network, then its ground station.
///
/// # Panics
/// If the file is none, or a vehicle has no simulation.
#[must_use]
pub fn plans(name: &str) -> Vec<Plan> {
    let path = deploy().join("compose").join(name);
    let text = std::fs::read_to_string(&path).expect("the compose file");
    let file: File = serde_saphyr::from_str(&text).expect("a compose file");
    let plan = |composed: Composed, flies: bool| Plan {
        vehicle: flies.then_some((0.0, 0.0)),
        secret: SECRET.to_owned(),
        composed: Some(composed),
        ..usual().remove(0)
    };
    let vehicles = file
        .services
        .iter()
        .filter(|(service, _)| service.starts_with("vehicle-"));
    let vehicles = vehicles.map(|(service, node)| {
        let shared = format!("service:{service}");
        let simulation = file.services.values().find(|other| other.network_mode == shared);
        let simulation = simulation
            .unwrap_or_else(|| panic!("{service} has no simulation"))
            .command
            .clone();
        let node = node.command.clone();
        plan(Composed { node, simulation }, true)
    });
    let ground = Composed {
        node: file.services["ground"].command.clone(),
        simulation: Vec::new(),
    };
    vehicles.chain(std::iter::once(plan(ground, false))).collect()
}

fn deploy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy")
}

impl Composed {
    /// The node's command. A namespace has no mounts, and a second network for the operator and the judge.
    pub(crate) fn node(&self, key: &Path, air: Ipv4Addr, manage: Ipv4Addr, number: u8) -> Vec<String> {
        let [latitude, longitude, altitude] = ORIGIN;
        let words = self.node.iter().map(|word| match word.strip_prefix(MOUNTED) {
            Some(file) => deploy().join("vehicles").join(file).display().to_string(),
            None => word.clone(),
        });
        let folder = key.parent().expect("a folder").display();
        let besides = [
            format!("swarm.node={number}"),
            format!("swarm.secret_file={}", key.display()),
            format!("swarm.state_file={folder}/term.json"),
            format!("resume.file={folder}/node.resume"),
            format!("swarm.zenoh.listen=[\"udp/{air}:7447\"]"),
            format!(
                "swarm.origin={{ latitude_deg = {latitude}, longitude_deg = {longitude}, altitude_amsl_m = {altitude} }}"
            ),
            format!("web.listen={manage}:8080"),
            format!("plugins.directories=[{:?}]", plugins_dir()),
        ];
        words
            .chain(besides.into_iter().flat_map(|set| ["--set".to_owned(), set]))
            .collect()
    }

    /// The simulation's command.
    pub(crate) fn simulation(&self) -> &[String] {
        &self.simulation
    }
}
