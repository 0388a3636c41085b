//! The example configurations that people start from are right.

use skein_config::NodeConfig;
use std::path::{Path, PathBuf};

fn examples() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/config");
    let files = std::fs::read_dir(&folder)
        .expect("deploy/config is there")
        .map(|entry| entry.expect("readable").path());
    files
        .filter(|file| file.extension().is_some_and(|extension| extension == "toml"))
        .collect()
}

#[test]
fn every_example_parses_and_makes_sense() {
    let files = examples();
    assert!(files.len() >= 3, "the examples have moved: {files:?}");
    for file in files {
        let config = NodeConfig::load(&file).unwrap_or_else(|error| panic!("{error}"));
        // A ground station of a swarm flies nothing itself; it is where the others are seen.
        let watches = config.swarm.coordinator_priority.is_some() && config.web.enabled;
        assert!(
            watches || !config.endpoints.is_empty() && !config.adopt.is_empty(),
            "{} flies nothing",
            file.display()
        );
        assert!(
            config.web.listen.ip().is_loopback(),
            "{} opens the API to a network",
            file.display()
        );
    }
}

#[test]
fn the_documentation_shows_a_configuration_that_works() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/docs/src/install.md");
    let page = std::fs::read_to_string(page).expect("install.md");
    let shown = page
        .split("```toml")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .expect("a toml block");
    let config = NodeConfig::parse(shown).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((config.endpoints.len(), config.adopt.len()), (1, 1));
}
