//! Which libraries are taken, and with what reason the others are not.

use skein_plugin_host::{Catalog, LoadError, Plugin, PluginKind, Trust};
use skein_tests_plugin_boundary::{fixture, fixture_built_with, fixture_names, shipped};
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Every fixture, with what the host says of it; nothing for those it takes.
const EXPECTED: [(&str, &str); 22] = [
    ("no_symbol", "does not export SKEIN_PLUGIN"),
    ("nothing_wrong", ""),
    ("wrong_magic", "is not a handshake"),
    ("wrong_abi_version", "ABI version 3, this host has 2"),
    ("wrong_handshake_size", "its handshake has 64 bytes instead of 72"),
    ("wrong_table_size", "its table has 48 bytes instead of 40"),
    ("wrong_target", "built for ?"),
    ("null_table", "lacks an entry point"),
    ("null_entry", "lacks an entry point"),
    ("unknown_kind", "kind 4000, which this host does not know"),
    ("other_kind", ""),
    ("garbage_manifest", "not decodable"),
    ("empty_manifest", "not decodable"),
    ("bad_name", "the name \"../Bad Name\""),
    ("unknown_effect", "effect 23 is not known"),
    ("manifest_refused", "no manifest today"),
    ("bad_utf8_manifest", "not decodable"),
    ("steering_camera", "a camera plugin may not have the effect setpoint"),
    ("bad_schema", "the schema of the configuration"),
    ("failing_model", ""),
    ("manifest_panics", "panicked while it made its manifest: on purpose"),
    ("failing_camera", ""),
];

#[test]
fn every_fixture_is_judged_as_it_should_be() {
    let names: Vec<_> = EXPECTED.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(
        fixture_names(),
        names,
        "a fixture without an expectation, or the other way round"
    );
    for (name, said) in EXPECTED {
        match Plugin::load(&fixture(name)) {
            Ok(plugin) => assert!(said.is_empty(), "{name} was taken as {}", plugin.manifest().name),
            Err(error) => {
                let text = error.to_string();
                assert!(
                    !said.is_empty() && text.contains(said),
                    "{name}: {text:?} does not say {said:?}"
                );
            }
        }
    }
}

#[test]
fn the_plugins_that_ship_are_taken() {
    let plugin = shipped("generic-uav");
    let manifest = plugin.manifest();
    assert_eq!(manifest.kind, PluginKind::UAV_MODEL);
    assert_eq!(manifest.version, env!("CARGO_PKG_VERSION"));
    assert_eq!(manifest.effects.len(), 10);
    let schema: serde_json::Value = serde_json::from_str(&manifest.config_schema_json).expect("is JSON");
    let properties = schema["properties"].as_object().expect("is an object");
    assert!(properties.contains_key("cruise_speed_m_s") && schema["additionalProperties"] == false);
    for (key, property) in properties {
        assert!(
            property["description"].is_string() && property.get("default").is_some(),
            "{key} is not documented"
        );
    }
}

/// A directory with copies of fixtures.
fn directory(libraries: &[(&str, &Path)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    for (name, from) in libraries {
        std::fs::copy(from, directory.path().join(name)).expect("copied");
    }
    directory
}

#[test]
fn a_catalogue_takes_the_good_and_names_the_bad() {
    let (good, bad) = (fixture("nothing_wrong"), fixture("wrong_abi_version"));
    let first = directory(&[
        ("liba.so", &good),
        ("libb.so", &bad),
        ("libc.so", &good),
        ("other.so", &good),
    ]);
    let second = directory(&[("libd.so", &good), ("libe.so", &fixture("failing_model"))]);
    let catalog = Catalog::discover(&[first.path().to_owned(), second.path().to_owned()], Trust::default());
    let names: Vec<_> = catalog.plugins().iter().map(|p| p.manifest().name.clone()).collect();
    assert_eq!(names, ["failing-model", "misbehaving"]);
    let taken = catalog.get("misbehaving").expect("is there");
    assert_eq!(taken.path(), first.path().join("liba.so"));
    assert!(catalog.get("other").is_none());
    let problems = catalog.problems();
    assert_eq!(problems.len(), 3, "{problems:?}");
    assert!(problems[0].path.ends_with("libb.so") && matches!(problems[0].error, LoadError::Handshake(_)));
    for (problem, name) in [(&problems[1], "libc.so"), (&problems[2], "libd.so")] {
        assert!(problem.path.ends_with(name));
        assert!(matches!(&problem.error, LoadError::DuplicateName { first, .. } if first.ends_with("liba.so")));
    }
}

#[test]
fn a_library_that_others_may_write_is_not_loaded() {
    let directory = directory(&[("liba.so", &fixture("nothing_wrong"))]);
    let path = directory.path().join("liba.so");
    std::fs::set_permissions(&path, Permissions::from_mode(0o757)).expect("mode is set");
    assert!(matches!(
        Plugin::load(&path),
        Err(LoadError::WritableByOthers { mode: 0o757, .. })
    ));
    std::fs::set_permissions(&path, Permissions::from_mode(0o644)).expect("mode is set");
    assert!(Plugin::load(&path).is_ok(), "no right to execute is needed");
}

#[test]
fn a_broken_library_is_refused_by_the_loader() {
    let whole = std::fs::read(fixture("nothing_wrong")).expect("is there");
    let directory = tempfile::tempdir().expect("a directory");
    for (name, bytes) in [
        ("libempty.so", &whole[..0]),
        ("libhead.so", &whole[..40]),
        ("libhalf.so", &whole[..2_000]),
    ] {
        let path = directory.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let error = Plugin::load(&path).expect_err("is refused");
        assert!(matches!(error, LoadError::NotLoadable { .. }), "{name}: {error}");
        assert!(
            !error.to_string().contains("skein-plugin-"),
            "the copy's path helps nobody: {error}"
        );
    }
}

#[test]
fn another_build_of_the_same_abi_is_taken_unless_its_panics_abort() {
    // Optimised otherwise than the host: what crosses is bytes and C-shaped structs, so that this does not matter.
    let release = fixture_built_with(&["--release"], "release", "nothing_wrong");
    assert_eq!(Plugin::load(&release).expect("is taken").manifest().name, "misbehaving");
    let unoptimised = fixture_built_with(&["--config", "profile.dev.opt-level=0"], "unoptimised", "nothing_wrong");
    assert!(Plugin::load(&unoptimised).is_ok());
    let aborts = fixture_built_with(&["--config", "profile.dev.panic=\"abort\""], "abort", "nothing_wrong");
    let error = Plugin::load(&aborts).expect_err("is refused");
    assert!(error.to_string().contains("panic = \"abort\""), "{error}");
}

#[test]
fn nothing_is_left_behind_by_loading() {
    let path = fixture("nothing_wrong");
    let plugin = Plugin::load(&path).expect("is taken");
    let left = std::fs::read_dir(std::env::temp_dir())
        .expect("is there")
        .flatten()
        .filter(|entry| entry.path().join("libnothing_wrong.so").exists());
    assert_eq!(left.count(), 0, "a copy was left");
    drop(plugin);
}

#[test]
fn a_library_replaced_while_it_is_loaded_is_loaded_whole_or_refused() {
    let folder = tempfile::tempdir().expect("can be made");
    let path = folder.path().join("libreplaced.so");
    let versions = ["nothing_wrong", "other_kind"].map(|name| std::fs::read(fixture(name)).expect("is there"));
    std::fs::write(&path, &versions[0]).expect("can be written");
    let done = std::sync::atomic::AtomicBool::new(false);
    let (mut whole, mut refused) = (0, 0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for round in 0.. {
                if done.load(std::sync::atomic::Ordering::Relaxed) {
                    return;
                }
                let version = &versions[round % 2];
                if round % 3 == 0 {
                    // As an installer should do it.
                    let beside = path.with_extension("new");
                    std::fs::write(&beside, version).expect("can be written");
                    std::fs::rename(&beside, &path).expect("can be renamed");
                } else {
                    // As one should not: the file is cut off and grows again.
                    std::fs::write(&path, version).expect("can be written");
                }
            }
        });
        for _ in 0..60 {
            match Plugin::load(&path) {
                Ok(plugin) => {
                    assert_eq!(plugin.manifest().name, "misbehaving");
                    whole += 1;
                }
                Err(LoadError::ManifestPanicked { .. } | LoadError::TimedOut { .. }) => {
                    panic!("code of half a library ran")
                }
                Err(_) => refused += 1,
            }
        }
        done.store(true, std::sync::atomic::Ordering::Relaxed);
    });
    assert_eq!(whole + refused, 60);
    // Left in peace it loads.
    std::fs::write(&path, &versions[0]).expect("can be written");
    Plugin::load(&path).expect("is taken");
}
