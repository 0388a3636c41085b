//! Every node that a compose file starts has a configuration that is right, with what the file sets over it; each simulation or autopilot sends to
//! where its node listens.

use serde::Deserialize;
use skein_config::{NodeConfig, Overlay};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
struct Compose {
    services: BTreeMap<String, Service>,
}

#[derive(Deserialize)]
struct Service {
    image: String,
    #[serde(default)]
    command: Vec<String>,
    #[serde(default)]
    network_mode: String,
    #[serde(default)]
    environment: BTreeMap<String, String>,
    #[serde(default)]
    read_only: bool,
    #[serde(default)]
    cap_drop: Vec<String>,
}

/// As the shell would have it: the class and the number of a vehicle in the field.
const IN_THE_FIELD: [(&str, &str); 2] = [
    ("${CLASS:?pi4 or x650}", "x650"),
    ("${NODE:?the number of this vehicle}", "7"),
];

fn deploy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy")
}

/// What a board with cameras of its own needs beside that is laid over a file.
const OVER: &str = "board-";

fn named(wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let files = std::fs::read_dir(deploy().join("compose"))
        .expect("deploy/compose")
        .flatten();
    let names = |file: &PathBuf| file.file_name().is_some_and(|name| wanted(&name.to_string_lossy()));
    files.map(|file| file.path()).filter(names).collect()
}

fn files() -> Vec<(String, Compose)> {
    let files = named(|name| name.ends_with(".yml") && !name.starts_with(OVER));
    files
        .into_iter()
        .map(|file| {
            let mut text = std::fs::read_to_string(&file).expect("readable");
            for (name, value) in IN_THE_FIELD {
                text = text.replace(name, value);
            }
            let compose = serde_saphyr::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            (
                file.file_name().expect("a name").to_string_lossy().into_owned(),
                compose,
            )
        })
        .collect()
}

/// The configuration that a service runs, if it runs a node.
fn configuration(service: &Service) -> Option<NodeConfig> {
    let mut words = service.command.iter().map(String::as_str);
    (words.next() == Some("run")).then_some(())?;
    let (mut file, mut overlay) = (None, Overlay::default());
    while let Some(word) = words.next() {
        let (name, value) = match word.split_once('=') {
            Some((name, value)) if name.starts_with("--") => (name, value),
            _ => (word, words.next().expect("a value")),
        };
        match name {
            "--config" => file = Some(value.to_owned()),
            "--set" => overlay.set.push(value.to_owned()),
            other => panic!("{other}"),
        }
    }
    let file = file.expect("--config");
    let file = deploy()
        .join("vehicles")
        .join(file.strip_prefix("/etc/skein/").expect("in /etc/skein"));
    Some(NodeConfig::load_with(&file, &overlay).unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn every_node_of_every_compose_file_is_configured_rightly() {
    let files = files();
    assert!(files.len() >= 6, "the files have moved");
    for (name, compose) in files {
        let nodes: BTreeMap<_, _> = compose
            .services
            .iter()
            .filter_map(|(service, what)| Some((service, configuration(what)?)))
            .collect();
        assert!(!nodes.is_empty(), "{name}");
        let numbers: BTreeSet<_> = nodes.values().map(|node| node.swarm.node).collect();
        assert_eq!(numbers.len(), nodes.len(), "{name}: each node has a number of its own");
        for (service, node) in &nodes {
            let secret = node.swarm.secret_file.as_deref();
            assert_eq!(secret, Some(Path::new("/run/skein/swarm.key")), "{name}: {service}");
        }
    }
}

#[test]
fn every_vehicle_hears_its_autopilot_and_has_its_number() {
    for (name, compose) in files() {
        for (service, what) in compose
            .services
            .iter()
            .filter(|(service, _)| service.starts_with("vehicle-"))
        {
            let number = service.trim_start_matches("vehicle-");
            let node = configuration(what).expect("a node");
            assert_eq!(
                node.swarm.node.map(|node| node.to_string()).as_deref(),
                Some(number),
                "{name}"
            );
            let listens = &node.endpoints[0].address;
            let autopilot = ["sim", "px4"]
                .iter()
                .find_map(|kind| compose.services.get(&format!("{kind}-{number}")));
            let autopilot = autopilot.unwrap_or_else(|| panic!("{name}: {service} has no autopilot"));
            let beside = [format!("service:{service}"), what.network_mode.clone()];
            assert!(
                beside.contains(&autopilot.network_mode),
                "{name}: {service}: another network"
            );
            let words = autopilot.command.join(" ");
            let instance: u16 = words
                .strip_prefix("-i ")
                .map_or(0, |instance| instance.parse().expect("a number"));
            assert!(
                listens.ends_with(&format!("127.0.0.1:{}", 14540 + instance)),
                "{name}: {listens}"
            );
            let id = autopilot.environment.get("PX4_PARAM_MAV_SYS_ID").cloned();
            let id = id.unwrap_or_else(|| {
                let at = autopilot.command.iter().position(|word| word == "--first-system-id");
                autopilot.command[at.expect("a system id") + 1].clone()
            });
            assert_eq!(id, number, "{name}: {service}");
        }
    }
}

#[test]
fn what_a_board_needs_is_laid_over_the_vehicle_alone_and_asks_for_no_privileges() {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Over {
        services: BTreeMap<String, Beside>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields, rename_all = "snake_case")]
    #[expect(dead_code, reason = "what may stand there is what is tested")]
    struct Beside {
        runtime: Option<String>,
        #[serde(default)]
        environment: BTreeMap<String, String>,
        #[serde(default)]
        volumes: Vec<String>,
        #[serde(default)]
        device_cgroup_rules: Vec<String>,
    }
    let files = named(|name| name.starts_with(OVER));
    assert_eq!(files.len(), 2, "{files:?}");
    for file in files {
        let text = std::fs::read_to_string(&file).expect("readable");
        let over: Over = serde_saphyr::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert_eq!(
            over.services.keys().collect::<Vec<_>>(),
            ["vehicle"],
            "{}",
            file.display()
        );
    }
}

#[test]
fn our_own_containers_have_no_rights_and_a_root_that_is_read_only() {
    for (name, compose) in files() {
        for (service, what) in &compose.services {
            let ours = what.image.contains("skein-");
            assert!(!ours || what.read_only && what.cap_drop == ["ALL"], "{name}: {service}");
        }
    }
}
