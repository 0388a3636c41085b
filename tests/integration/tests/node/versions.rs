//! A plugin exchanged for another version in flight: with its state, back if the new one does not come up, and back on request. The
//! vehicle's link notices nothing.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use skein_config::Isolation;
use skein_domain::{FormationRequest, Shape};
use skein_runtime::{NodeHandle, PluginRefusal, UpgradeReceipt};
use skein_testkit::{LONGEST_GAP_S, Swarm, example_library};
use skein_view::{FleetSnapshot, Restored};
use std::path::{Path, PathBuf};
use std::time::Duration;

const LIBRARY: &str = "libgeneric_uav_plugin.so";

/// A folder of its own with the shipped plugins, and the libraries of later versions.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let plugins = folder.path().join("plugins");
    std::fs::create_dir(&plugins).unwrap();
    std::fs::copy(skein_testkit::plugins_dir().join(LIBRARY), plugins.join(LIBRARY)).unwrap();
    (folder, plugins)
}

/// As a person installs it: beside, then over the old one in one step.
fn install(library: &Path, plugins: &Path) {
    let beside = plugins.join("new");
    std::fs::copy(library, &beside).unwrap();
    std::fs::rename(beside, plugins.join(LIBRARY)).unwrap();
}

fn versions(fleet: &FleetSnapshot) -> Vec<&str> {
    fleet.vehicles.iter().map(|v| v.model.version.as_str()).collect()
}

fn restored(receipt: &UpgradeReceipt) -> Vec<Option<Restored>> {
    receipt.instances.iter().map(|i| i.restored).collect()
}

fn active(node: &NodeHandle) -> String {
    let plugins = node.plugins();
    plugins
        .iter()
        .find(|p| p.name == "generic-uav")
        .unwrap()
        .version
        .clone()
}

/// Two vehicles with their model in the node's process, one in a child.
async fn three_of(plugins: &Path) -> Swarm {
    let directory = plugins.to_owned();
    Swarm::start_with(3, move |config, _| {
        config.plugins.directories = vec![directory];
        let mut child = config.adopt[0].clone();
        child.system_ids = "3".parse().unwrap();
        child.model_isolation = Isolation::Child;
        config.adopt.insert(0, child);
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_model_is_exchanged_in_flight_and_goes_back_if_it_must() {
    let (_folder, plugins) = folder();
    let swarm = three_of(&plugins).await;
    swarm.take_off(6.0).await;
    let node = swarm.node();
    node.set_formation(FormationRequest::new(Shape::Line, 5.0))
        .await
        .unwrap();
    let first = active(&node);
    assert!(matches!(
        node.upgrade_plugin("generic-uav").await,
        Err(PluginRefusal::NothingNewer { .. })
    ));

    install(&example_library("fixture-next-version", "good_version"), &plugins);
    let receipt = node.upgrade_plugin("generic-uav").await.unwrap();
    assert!(!receipt.rolled_back, "{receipt:?}");
    assert_eq!(restored(&receipt), [Some(Restored::Exactly); 3]);
    assert_eq!(active(&node), "9.1.0");
    swarm
        .until("the new version flying", Duration::ZERO, |fleet| {
            versions(fleet) == ["9.1.0"; 3]
        })
        .await;

    install(&example_library("fixture-next-version", "bad_version"), &plugins);
    let receipt = node.upgrade_plugin("generic-uav").await.unwrap();
    assert!(receipt.rolled_back, "{receipt:?}");
    assert!(receipt.instances.iter().any(|i| i.error.is_some()), "{receipt:?}");
    assert_eq!(active(&node), "9.1.0", "the good one stays");

    let receipt = node.roll_back_plugin("generic-uav").await.unwrap();
    assert_eq!((receipt.to.as_str(), receipt.rolled_back), (first.as_str(), false));
    swarm
        .until(
            "the first version flying again, in its slots",
            Duration::from_secs(20),
            |fleet| {
                versions(fleet) == [first.as_str(); 3]
                    && fleet
                        .vehicles
                        .iter()
                        .all(|v| v.is_leader || v.tracking_error_m.is_some_and(|m| m < 0.6))
            },
        )
        .await;
    for vehicle in &swarm.truth_now().await.vehicles {
        assert!(
            vehicle.offboard_gap_sender_max_s < LONGEST_GAP_S,
            "{}",
            vehicle.offboard_gap_sender_max_s
        );
    }
    assert!(matches!(
        node.remove_plugin("generic-uav"),
        Err(PluginRefusal::InUse { .. })
    ));
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_uploaded_plugin_stays_off_until_it_is_enabled_and_none_is_taken_unasked() {
    let (_folder, plugins) = folder();
    let uploads = tempfile::tempdir().unwrap();
    let (directory, upload_directory) = (plugins.clone(), uploads.path().to_owned());
    let swarm = Swarm::start_with(0, move |config, _| {
        config.plugins.directories = vec![directory];
        config.plugins.upload_directory = Some(upload_directory);
    })
    .await;
    let url = |path: &str| format!("http://{}/api/v1/plugins/{path}", swarm.web_address());
    let names = || swarm.node().plugins().into_iter().map(|p| p.name).collect::<Vec<_>>();
    let library = std::fs::read(skein_testkit::plugins_dir().join("libgimbal_plugin.so")).unwrap();
    let http = reqwest::Client::new();
    let upload = |file: &str| {
        http.post(url(&format!("uploads?file={file}")))
            .body(library.clone())
            .send()
    };

    assert_eq!(upload("../escape.so").await.unwrap().status(), 409);
    assert_eq!(upload("libgimbal_plugin.so").await.unwrap().status(), 202);
    http.post(url("rescan")).send().await.unwrap();
    assert_eq!(names(), ["generic-uav"], "it is off");
    let enabled = http
        .post(url("uploads/enable?file=libgimbal_plugin.so"))
        .send()
        .await
        .unwrap();
    assert_eq!(enabled.status(), 200);
    assert_eq!(names(), ["generic-uav", "gimbal"]);
    let removed = http.delete(url("gimbal")).send().await.unwrap();
    assert_eq!(removed.status(), 204);
    assert_eq!(names(), ["generic-uav"]);
    swarm.stop().await;

    let closed = Swarm::start_with(0, |_, _| ()).await;
    let address = format!("http://{}/api/v1/plugins/uploads?file=libx.so", closed.web_address());
    assert_eq!(http.post(address).body(library).send().await.unwrap().status(), 403);
    closed.stop().await;
}
