//! `skein plugin check` and `list` on libraries that are right and on ones that are not.

use skein_tests_plugin_boundary::fixture;
use std::path::Path;
use std::process::{Command, Output};

fn skein(arguments: &[&str], files: &[&Path]) -> (Option<i32>, String) {
    let Output { status, stdout, .. } = Command::new(skein_testkit::skein_binary())
        .arg("plugin")
        .args(arguments)
        .args(files)
        .output()
        .expect("is started");
    (status.code(), String::from_utf8_lossy(&stdout).into_owned())
}

#[test]
fn check_takes_what_is_right_and_says_what_is_wrong_with_the_rest() {
    let (code, said) = skein(&["check"], &[&fixture("failing_model"), &fixture("failing_camera")]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("failing-model") && said.contains("(camera)"), "{said}");
    assert_eq!(said.matches("in a process of its own").count(), 2, "{said}");
    for (name, sentence) in [
        ("no_symbol", "does not export SKEIN_PLUGIN"),
        ("wrong_abi_version", "it has ABI version 3, this host has 2"),
        ("steering_camera", "a camera plugin may not have the effect setpoint"),
        ("bad_schema", "the schema of the configuration"),
        ("manifest_panics", "it panicked while it made its manifest"),
    ] {
        let (code, said) = skein(&["check"], &[&fixture(name)]);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("not right: ") && said.contains(sentence), "{said}");
    }
}

#[test]
fn check_says_at_which_step_an_instance_fails() {
    for (fail, sentence) in [
        ("panic_in_create", "an instance was not made: panicked"),
        ("abort", "its first call: its process ended"),
        ("effect_not_in_manifest", "its first call: returned the effect setpoint"),
        ("no_such_way", "is not as its schema has it"),
    ] {
        let config = format!(r#"{{"fail": "{fail}"}}"#);
        let (code, said) = skein(&["check", "--config", &config], &[&fixture("failing_model")]);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains(sentence), "{fail}: {said}");
    }
}

#[test]
fn list_names_the_good_and_the_bad() {
    let folder = tempfile::tempdir().expect("can be made");
    for name in ["failing_model", "no_symbol"] {
        std::fs::copy(fixture(name), folder.path().join(format!("lib{name}.so"))).expect("can be copied");
    }
    let place = folder.path().to_str().expect("is text");
    let (code, said) = skein(&["list", "--plugins", place, "--json"], &[]);
    assert_eq!(code, Some(0), "{said}");
    let list: serde_json::Value = serde_json::from_str(&said).expect("is JSON");
    assert_eq!(list["plugins"][0]["name"], "failing-model");
    assert_eq!(list["plugins"][0]["kind"], "uav_model");
    assert_eq!(list["plugins"][0]["sha256"].as_str().map(str::len), Some(64));
    let error = list["problems"][0]["error"].as_str().expect("is text");
    assert!(error.contains("does not export"), "{error}");
    assert_eq!(list["problems"].as_array().map(Vec::len), Some(1));
}
