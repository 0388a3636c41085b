//! Another version of the program for a swarm, from the ground station: five hosts whose nodes are started again when they end, as systemd does.
//! The archive is the program itself under another name of a version; what tells versions apart is the digest.

use reqwest::Method;
use serde_json::{Value, json};
use skein_testkit::{Process, plugins_dir, skein_binary};
use skein_tests_multihost::field::{Field, GROUND, usual};
use skein_tests_multihost::host::{OPERATOR, Plan};
use skein_tests_multihost::mission::Mission;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use tempfile::TempDir;

const TOGETHER_S: f64 = 30.0;
/// Longest a roll-out may take before something is broken.
const ROLLED_OUT_WITHIN: Duration = Duration::from_secs(900);
/// What nodes may send, so that an archive is there soon, in bytes per second.
const FAST: f64 = 8e6;
/// The best suited.
const COORDINATOR: u8 = 2;
/// Its vehicle flies while the first roll-out goes on.
const FLIES: u8 = 3;
const ALL: [u8; 5] = [1, 2, 3, 4, 5];
/// Ends at once, whatever it is asked.
const ENDS_AT_ONCE: &str = "/bin/false";

fn supervised() -> Vec<Plan> {
    let mut plans = usual();
    plans.truncate(ALL.len());
    for plan in &mut plans {
        (plan.supervised, plan.max_bytes_per_s) = (true, Some(FAST));
    }
    plans
}

/// An archive of this program with the plugin that is flown, without what only a debugger reads.
fn pack(folder: &TempDir, version: &str, program: &Path) -> PathBuf {
    let (stage, plugin) = (folder.path().join(version), "libgeneric_uav_plugin.so");
    std::fs::create_dir_all(stage.join("plugins")).expect("a folder");
    for (from, to) in [
        (program.to_owned(), stage.join("skein")),
        (plugins_dir().join(plugin), stage.join("plugins").join(plugin)),
    ] {
        let stripped = Command::new("strip").arg("-o").arg(&to).arg(&from).status();
        assert!(stripped.is_ok_and(|status| status.success()), "strip (binutils) works");
    }
    let archive = folder.path().join(format!("{version}.tar.gz"));
    let mut pack = Command::new(skein_binary());
    pack.args(["upgrade", "pack", "--version", version])
        .arg(&stage)
        .arg(&archive);
    assert!(
        pack.status().is_ok_and(|status| status.success()),
        "the archive is made"
    );
    archive
}

/// What an operator types at the ground station. Gives the exit code and what was said.
async fn upgrade(field: &Field, arguments: &[&str]) -> (i32, String) {
    let node = format!("http://{}:8080", field.host(GROUND).namespace().manage);
    let mut command = Command::new(skein_binary());
    command
        .args(["upgrade", "--node", &node])
        .args(arguments)
        .env("SKEIN_OPERATOR", OPERATOR);
    let mut process = Process::start("skein upgrade", command.into());
    let code = process.exit_code(ROLLED_OUT_WITHIN).await;
    println!("skein upgrade {}:\n{}", arguments.join(" "), process.output());
    (code, process.output())
}

/// What a node says of its own versions.
async fn versions(field: &Field, number: u8) -> Value {
    let report = field.host(number).operator().get("/api/v1/upgrades").await;
    report["this_node"].clone()
}

/// The version that each node runs and keeps, by name; the package is "package".
async fn run(field: &Field) -> Vec<String> {
    let mut all = Vec::new();
    for number in ALL {
        let told = versions(field, number).await;
        assert_eq!(told["on_trial"], json!(false), "node {number}: {told}");
        let version = told["runs"]["version"].as_str().unwrap_or_default();
        let is_package = told["runs"]["digest"].is_null();
        all.push(if is_package { "package" } else { version }.to_owned());
    }
    all
}

#[tokio::test(flavor = "multi_thread")]
async fn one_after_the_other_and_back_where_a_version_does_not_come_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = pack(&folder, "9.1.0", &skein_binary());
    let broken = pack(&folder, "9.2.0-broken", Path::new(ENDS_AT_ONCE));
    let (good, broken) = (good.to_string_lossy(), broken.to_string_lossy());
    let mut field = Field::start(40, supervised());
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;

    // Vehicle 3 flies: its node is not touched, nor is the one that coordinates.
    let mut mission = Mission::of(&mut field, GROUND, vec![FLIES]);
    mission.take_off().await;
    let (code, said) = upgrade(&field, &[&good]).await;
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("node 3 (host-3): refused: vehicle 3 is armed"), "{said}");
    assert!(
        said.contains("node 2 (host-2): refused: the node coordinates the swarm, and vehicle 3"),
        "{said}"
    );
    assert_eq!(run(&field).await, ["package", "package", "package", "9.1.0", "9.1.0"]);
    assert_eq!(
        (
            field.host(FLIES).ends(),
            field.host(COORDINATOR).ends(),
            field.host(4).ends()
        ),
        (0, 0, 1)
    );
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::of(&mut field, GROUND, vec![FLIES]);
    mission.land().await;

    // A version that does not come up: the first node goes back by itself, and no other one gets it.
    until_on_ground(&mut field).await;
    let (code, said) = upgrade(&field, &[&broken]).await;
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("node 3 (host-3): WENT BACK by itself"), "{said}");
    assert!(said.contains("node 4 (host-4): left as it is"), "{said}");
    assert_eq!(run(&field).await, ["package", "package", "package", "9.1.0", "9.1.0"]);
    let told = versions(&field, FLIES).await;
    assert_eq!(told["gone_back"]["from"]["version"], json!("9.2.0-broken"), "{told}");
    assert_eq!((field.host(COORDINATOR).ends(), field.host(4).ends()), (0, 1));

    // Who has the good one is left alone; the others get it, the coordinator's node after them, the ground station's at the very end.
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    until_on_ground(&mut field).await;
    let (code, said) = upgrade(&field, &[&good, "--this-node"]).await;
    assert_eq!(code, 0, "{said}");
    let place = |what: &str| said.find(what).unwrap_or_else(|| panic!("no {what:?} in {said}"));
    assert!(
        place("node 3 (host-3): runs it, confirmed") < place("node 2 (host-2): unpacking"),
        "{said}"
    );
    let all = async |field: &mut Field| {
        let ground = versions(field, GROUND).await;
        ground["runs"]["version"] == json!("9.1.0") && ground["on_trial"] == json!(false)
    };
    field
        .until("the ground station's own version to be confirmed", 120.0, all)
        .await;
    assert_eq!(run(&field).await, ["9.1.0"; 5]);
    assert_eq!(field.host(4).ends(), 1);

    back_and_up(&mut field).await;
    field.end("one version after the other", &[]).await;
}

/// Back, one of them; and the swarm flies with both.
async fn back_and_up(field: &mut Field) {
    let (code, said) = upgrade(field, &["--back", "--only", "4"]).await;
    assert_eq!(code, 0, "{said}");
    assert_eq!(run(field).await, ["9.1.0", "9.1.0", "9.1.0", "package", "9.1.0"]);
    field.one_swarm(&ALL, TOGETHER_S).await;
    let mut mission = Mission::new(field, GROUND);
    mission.take_off().await;
    mission.land().await;
}

/// Until no vehicle is armed any more, as the ground station sees it, and an operator without the right to is refused.
async fn until_on_ground(field: &mut Field) {
    let disarmed = async |field: &mut Field| {
        let fleet = field.host(GROUND).operator().fleet().await;
        let vehicles = fleet["vehicles"].as_array().cloned().unwrap_or_default();
        vehicles.len() == ALL.len() - 1 && vehicles.iter().all(|v| v["armed"] == json!(false))
    };
    field.until("all vehicles disarmed", 60.0, disarmed).await;
    let body = Some(json!({ "this_node": true }));
    let answer = field
        .host(GROUND)
        .operator()
        .ask(Method::POST, "/api/v1/upgrades", body)
        .await;
    assert_eq!(answer.status, 401, "{answer:?}");
}
