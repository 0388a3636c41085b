//! What is set beside a file: where it goes, and what is refused.

use super::Overlay;
use crate::{ConfigError, NodeConfig};
use proptest::prelude::*;
use std::path::PathBuf;

const FILE: &str = "[node]\nname = \"uav\"\n[swarm]\nid = \"field\"\nnode = 1\nsecret_file = \"swarm.key\"\n";

fn load(text: &str, set: &[&str], state: Option<&str>) -> Result<NodeConfig, ConfigError> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("node.toml");
    std::fs::write(&file, text).expect("is written");
    let overlay = Overlay {
        set: set.iter().map(|&argument| argument.to_owned()).collect(),
        state: state.map(PathBuf::from),
    };
    NodeConfig::load_with(&file, &overlay)
}

#[test]
fn values_are_set_over_the_file() {
    let config = load(FILE, &["swarm.node=7", "node.name=uav-7", "web.enabled=false"], None).expect("is right");
    assert_eq!(config.swarm.node, Some(7));
    assert_eq!((config.node.name.as_str(), config.web.enabled), ("uav-7", false));
    assert_eq!(config.swarm.id.as_deref(), Some("field"), "the rest stays");
    let lists = load(FILE, &["swarm.transports=[\"dds\"]"], None).expect("is right");
    assert_eq!(lists.swarm.transports.len(), 1);
}

#[test]
fn what_the_node_writes_goes_where_it_may() {
    let config = load(FILE, &["swarm.node=7"], Some("/var/lib/skein")).expect("is right");
    let within = |path: Option<PathBuf>| path.is_some_and(|path| path.starts_with("/var/lib/skein"));
    assert!(within(config.swarm.state_file) && within(config.resume.file) && within(config.video.recordings));
    let read = config.swarm.secret_file.expect("is named");
    assert!(!read.starts_with("/var/lib/skein") && read.is_absolute(), "{read:?}");
}

#[test]
fn a_mistake_in_the_file_is_not_hidden_and_one_beside_it_is_named() {
    let file = load("[swarm]\nnod = 1\n", &["swarm.node=7"], None).expect_err("a mistake");
    assert!(file.to_string().contains("line 2"), "{file}");
    for (argument, said) in [
        ("swarm.node", "KEY=VALUE"),
        ("swarm.nod=7", "nod"),
        ("swarm.node=seven", "swarm.node=seven"),
        ("node.name.first=7", "no section"),
        ("=7", "names no key"),
    ] {
        let error = load(FILE, &["web.enabled=false", argument], None)
            .expect_err(argument)
            .to_string();
        assert!(error.contains("--set") && error.contains(said), "{argument}: {error}");
    }
    let senseless = load(FILE, &["node.snapshot_rate_hz=-1"], None)
        .expect_err("no rate")
        .to_string();
    assert!(senseless.contains("snapshot_rate_hz"), "{senseless}");
}

proptest! {
    #[test]
    fn nothing_that_is_set_breaks_the_program(argument in ".{0,60}") {
        // Right or refused.
        let _ = load(FILE, &[&argument], None);
    }
}
