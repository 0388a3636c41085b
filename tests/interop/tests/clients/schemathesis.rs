//! schemathesis as an independent judge of the API: it reads the published document, sends what that permits and what it forbids, and holds
//! every answer against it.

use skein_domain::FlightState;
use skein_testkit::{Process, eventually, free_tcp_port, patience, plugins_dir};
use skein_tests_interop::{Environment, python_of};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const SCHEMATHESIS: Environment = Environment {
    name: "schemathesis",
    requirements: &["schemathesis==4.32.5"],
    modules: "schemathesis",
};

/// Requests drawn for each operation, beside those that its limits call for.
const DRAWN: &str = "40";

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn all_checks_of_schemathesis_find_nothing() {
    let python = python_of(&SCHEMATHESIS).expect("schemathesis is there");
    let port = free_tcp_port().to_string();
    let plugins = plugins_dir();
    let plugins = plugins.to_str().expect("is text");
    let mut node = Process::skein(&[
        "demo",
        "--manual",
        "--vehicles",
        "2",
        "--port",
        &port,
        "--plugins",
        plugins,
    ]);
    let fleet = format!("http://127.0.0.1:{port}/api/v1/fleet");
    eventually(patience() + Duration::from_secs(30), "two vehicles", async || {
        let answer = reqwest::get(&fleet).await.ok()?;
        let fleet: serde_json::Value = answer.json().await.ok()?;
        let idle = serde_json::to_value(FlightState::Idle).ok()?;
        let vehicles = fleet["vehicles"].as_array()?;
        (vehicles.len() == 2 && vehicles.iter().all(|vehicle| vehicle["flight_state"] == idle)).then_some(())
    })
    .await;
    let mut command = Command::new(python.with_file_name("schemathesis"));
    let hooks = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemathesis");
    command.arg("--config-file").arg(hooks.join("schemathesis.toml"));
    command
        .env("SCHEMATHESIS_HOOKS", "skein_hooks")
        .env("PYTHONPATH", &hooks);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    command.args(["run", &format!("http://127.0.0.1:{port}/api/v1/openapi.json")]);
    command.args(["--checks", "all", "--max-examples", DRAWN]);
    command.args(["--seed", "1", "--no-shrink", "--continue-on-failure", "--no-color"]);
    let folder = tempfile::tempdir().expect("a folder");
    command.current_dir(folder.path());
    let found = tokio::task::spawn_blocking(move || command.output()).await;
    let found = found.expect("is not interrupted").expect("schemathesis runs");
    let said = String::from_utf8_lossy(&found.stdout);
    assert!(
        found.status.success(),
        "{said}\n{}",
        String::from_utf8_lossy(&found.stderr)
    );
    assert!(said.contains("Test cases:"), "it has tried something: {said}");
    node.signal("INT").await;
    assert_eq!(node.exit_code(Duration::from_secs(30)).await, 0, "{}", node.output());
}
