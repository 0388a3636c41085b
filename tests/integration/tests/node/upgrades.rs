//! Another version of the program at one node with a simulated vehicle: who may, what is refused, what is held back. That a version runs, and goes
//! back, takes several processes: `tests/multihost`.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_config::OperatorSettings;
use skein_domain::{VehicleCommand, VehicleId};
use skein_testkit::{Swarm, eventually, patience};
use skein_upgrade::{Expectations, Running, Slots, Swap, Trial, Upgrader, Version, Versions, pack};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// SHA-256 of "password".
const SECRET_SHA256: &str = "5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8";

/// Of "test".
const OTHER_SHA256: &str = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08";

/// A node that takes versions, with its vehicle ready; the folder is its state's.
async fn swarm(on_trial: bool) -> (Swarm, TempDir, Arc<Upgrader>) {
    let swarm = Swarm::start_with(1, |config, _| {
        config.upgrade.accept = true;
        let operator = |name: &str, token_sha256: &str| OperatorSettings {
            name: name.into(),
            token_sha256: token_sha256.into(),
            may_override_preflight: false,
            may_upgrade: name == "anna",
        };
        config.operators = vec![operator("anna", SECRET_SHA256), operator("ben", OTHER_SHA256)];
    })
    .await;
    let state = tempfile::tempdir().unwrap();
    let running = Running {
        version: Version::Package,
        on_trial,
        package_plugins: None,
    };
    let upgrader = swarm.node().keep_versions(state.path(), running).unwrap();
    swarm.ready().await;
    (swarm, state, upgrader)
}

/// An archive for a processor, of a program that is none.
fn archive(folder: &TempDir, machine: [u8; 2]) -> PathBuf {
    let stage = folder.path().join("stage");
    std::fs::create_dir_all(stage.join("plugins")).unwrap();
    let mut program = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0".to_vec();
    program.extend(machine);
    std::fs::write(stage.join("skein"), program).unwrap();
    let path = folder.path().join("archive.tar.gz");
    pack(&stage, "9.0.0", &path).unwrap();
    path
}

/// The number of this processor in an ELF file, and another one's.
const OWN: [u8; 2] = if cfg!(target_arch = "x86_64") {
    [0x3e, 0]
} else {
    [0xb7, 0]
};
const OTHER: [u8; 2] = if cfg!(target_arch = "x86_64") {
    [0xb7, 0]
} else {
    [0x3e, 0]
};

async fn ask(swarm: &Swarm, secret: Option<&str>, method: &str, path: &str, body: Option<Vec<u8>>) -> (u16, Value) {
    let url = format!("http://{}/api/v1/upgrades{path}", swarm.web_address());
    let mut request = reqwest::Client::new().request(method.parse().unwrap(), url);
    if let Some(secret) = secret {
        request = request.bearer_auth(secret);
    }
    if let Some(body) = body {
        request = request.header("content-type", "application/json").body(body);
    }
    let answer = request.send().await.unwrap();
    let status = answer.status().as_u16();
    (
        status,
        serde_json::from_str(&answer.text().await.unwrap()).unwrap_or_default(),
    )
}

/// Rolls what is kept out to this node; gives how that ended.
async fn roll_out(swarm: &Swarm) -> Value {
    let body = Some(json!({ "this_node": true }).to_string().into_bytes());
    let (status, begun) = ask(swarm, Some("password"), "POST", "", body).await;
    assert_eq!(status, 202, "{begun}");
    let ended = async || {
        let (_, report) = ask(swarm, None, "GET", "", None).await;
        (!report["rollout"]["ended"].is_null()).then(|| report["rollout"]["nodes"][0]["progress"].clone())
    };
    eventually(patience(), "the end of the roll-out", ended).await
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_damaged_or_for_another_processor_or_would_touch_an_armed_vehicle_is_refused() {
    let (swarm, state, upgrader) = swarm(false).await;
    let files = tempfile::tempdir().unwrap();
    let good = std::fs::read(archive(&files, OWN)).unwrap();
    for secret in [None, Some("guessed")] {
        let (status, answer) = ask(&swarm, secret, "POST", "/archives", Some(good.clone())).await;
        assert_eq!(
            (status, &answer["error"]["code"]),
            (401, &json!("no_operator")),
            "{answer}"
        );
    }
    let (status, answer) = ask(&swarm, Some("test"), "POST", "/archives", Some(good.clone())).await;
    assert_eq!(
        (status, &answer["error"]["code"]),
        (403, &json!("not_permitted")),
        "{answer}"
    );
    let damaged = good[..good.len() / 2].to_vec();
    let (status, answer) = ask(&swarm, Some("password"), "POST", "/archives", Some(damaged)).await;
    assert_eq!((status, &answer["error"]["code"]), (409, &json!("damaged")), "{answer}");
    let (status, answer) = ask(&swarm, Some("password"), "POST", "", Some(b"{}".to_vec())).await;
    assert_eq!(
        (status, &answer["error"]["code"]),
        (409, &json!("no_archive")),
        "{answer}"
    );

    let other = std::fs::read(archive(&files, OTHER)).unwrap();
    let (status, answer) = ask(&swarm, Some("password"), "POST", "/archives", Some(other)).await;
    assert_eq!(status, 200, "{answer}");
    let progress = roll_out(&swarm).await;
    assert_eq!(progress["refusal"]["reason"], json!("no_archive"), "{progress}");

    let (status, answer) = ask(&swarm, Some("password"), "POST", "/archives", Some(good)).await;
    assert_eq!((status, &answer["version"]), (200, &json!("9.0.0")), "{answer}");
    swarm.command_all(VehicleCommand::Arm).await;
    swarm
        .until("armed", Duration::ZERO, |fleet| fleet.vehicles.iter().all(|v| v.armed))
        .await;
    let progress = roll_out(&swarm).await;
    assert_eq!(
        progress["refusal"],
        json!({ "reason": "armed", "vehicle": 1 }),
        "{progress}"
    );
    let versions = upgrader.versions();
    assert_eq!(
        (versions.pending, versions.on_trial, versions.runs.digest),
        (None, false, None)
    );
    // Nothing of an archive was unpacked, and nothing lies beside the two folders.
    assert!(!state.path().join("versions/versions.json").exists());
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_armed_while_a_version_is_on_trial() {
    let (swarm, _state, upgrader) = swarm(true).await;
    let receipts = swarm
        .node()
        .command(&skein_runtime::Targets::All, VehicleCommand::Arm)
        .await;
    let refusal = receipts[0].refusal.clone().map(|refusal| refusal.to_string());
    assert!(
        refusal.as_ref().is_some_and(|text| text.contains("being exchanged")),
        "{refusal:?}"
    );
    // Nobody is expected, so that it is well at once; when it has been for long enough, it stays.
    let watched = upgrader.clone();
    let watch = tokio::spawn(async move { watched.run(None).await });
    eventually(patience(), "a confirmation", async || {
        (!upgrader.versions().on_trial).then_some(())
    })
    .await;
    swarm.command_all(VehicleCommand::Arm).await;
    swarm
        .until("armed", Duration::ZERO, |fleet| fleet.vehicles.iter().all(|v| v.armed))
        .await;
    watch.abort();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_that_does_not_hear_a_vehicle_again_goes_back_and_says_which() {
    let swarm = Swarm::start_with(1, |config, _| config.upgrade.confirm_within_s = 10.0).await;
    swarm.ready().await;
    let state = tempfile::tempdir().unwrap();
    let slots = Slots::under(state.path());
    let version = Version::Slot {
        version: "9.0.0".into(),
        digest: "ab".repeat(32),
    };
    let trial = Trial {
        version: version.clone(),
        begun: true,
        expects: Expectations {
            vehicles: vec![VehicleId(1), VehicleId(9)],
            ..Expectations::default()
        },
    };
    let kept = Versions {
        trial: Some(trial),
        ..Versions::default()
    };
    slots.save(&kept).unwrap();
    let running = Running {
        version,
        on_trial: true,
        package_plugins: None,
    };
    let upgrader = swarm.node().keep_versions(state.path(), running).unwrap();
    let Swap::GoneBack(why) = upgrader.run(None).await else {
        panic!("it does not go back")
    };
    assert!(why.contains("vehicle 9"), "{why}");
    // The next start knows it from the disk.
    let kept = slots.load().unwrap().unwrap();
    assert_eq!((kept.trial, kept.confirmed), (None, Version::Package));
    assert_eq!(kept.gone_back.map(|back| back.why), Some(why));
}
