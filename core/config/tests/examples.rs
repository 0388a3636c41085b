//! The example configurations that people start from are right.

use skein_config::{NodeConfig, Overlay};
use std::path::{Path, PathBuf};

fn files_in(folder: &str, wanted: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy").join(folder);
    let files = std::fs::read_dir(&folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("readable").path());
    files
        .filter(|file| file.extension().is_some_and(|extension| extension == wanted))
        .collect()
}

#[test]
fn every_class_of_vehicle_parses_and_one_file_serves_all_of_it() {
    let files = files_in("vehicles", "toml");
    assert!(files.len() >= 5, "the classes have moved: {files:?}");
    for file in files {
        for number in [1, 7, 100] {
            let overlay = Overlay {
                set: vec![format!("swarm.node={number}")],
                ..Overlay::default()
            };
            let config = NodeConfig::load_with(&file, &overlay).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(config.swarm.node, Some(number));
            assert!(
                config.swarm.coordinator_priority.is_some(),
                "any of them can coordinate"
            );
            assert!(config.web.listen.ip().is_loopback(), "{}", file.display());
        }
    }
}

#[test]
fn the_ground_and_every_vehicle_are_in_one_swarm() {
    let swarms: Vec<_> = files_in("vehicles", "toml")
        .iter()
        .map(|file| std::fs::read_to_string(file).expect("readable"))
        .map(|text| toml::from_str::<toml::Table>(&text).expect("TOML")["swarm"]["id"].clone())
        .collect();
    assert!(swarms.windows(2).all(|pair| pair[0] == pair[1]), "{swarms:?}");
}

#[test]
fn every_example_parses_and_makes_sense() {
    let files = files_in("config", "toml");
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
