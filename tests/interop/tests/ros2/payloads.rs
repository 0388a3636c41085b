//! A program of ROS 2 looks through a vehicle's camera, turns its gimbal, follows its transforms and what is tracked.
//!
//! Must never do: judge a direction by anything but the simulator's gimbal.

use crate::graph::{everything_is_seen, payloads_are_seen};
use crate::rig::{Watched, all_agree, fresh_domain, names, number, place, program, swarm_with};
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use skein_config::{AdoptionRule, Escalation, Isolation, PayloadRule};
use skein_domain::PositionNed;
use skein_domain::payload::Track;
use skein_sim::{GimbalTruth, Mover, PayloadPlan, VehicleTruth};
use skein_testkit::{Swarm, example_library};
use skein_tests_interop::{Ros2, say};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::time::Duration;

/// How far a direction may be off, in radians: the gimbal still settles, and its vehicle sways.
const OFF_RAD: f64 = 0.08;
const TRACK: u64 = 7;
const TRACK_TOLD: &str = "7";
/// Finds in each picture the whole of it.
const DETECTOR: &str = "frame-counter";

fn carried(name: &str, config: Value) -> PayloadRule {
    PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: Escalation::Hold,
        config,
    }
}

/// One vehicle with a camera on a gimbal and a detector of whole pictures, and somebody else who drives past, far away.
async fn carrying(domain_id: u16, plugins: &Path) -> Swarm {
    let plan = PayloadPlan {
        radio: None,
        ..PayloadPlan::all()
    };
    // Pictures of the simulated scene are drawn by the plugin: as wide as the simulated camera sees.
    let seen_rad = plan.camera.unwrap_or_default().field_of_view_rad;
    let camera = json!({ "source": "synthetic", "field_of_view_rad": seen_rad });
    let payloads = vec![
        carried("gimbal", json!({})),
        carried("camera", camera),
        carried(DETECTOR, json!({})),
    ];
    let directory = plugins.to_owned();
    swarm_with(1, domain_id, move |config, simulation| {
        config.plugins.directories.push(directory);
        config.adopt = vec![AdoptionRule {
            payloads,
            ..AdoptionRule::default()
        }];
        config.ros2.take_off_height_m = 6.0;
        simulation.payloads = plan;
        simulation.movers = vec![Mover {
            path: vec![
                PositionNed::new(150.0, 120.0, -3.0),
                PositionNed::new(250.0, 60.0, -3.0),
            ],
            circuit: true,
            ..Mover::default()
        }];
    })
    .await
}

fn triple(value: &Value) -> Result<[f64; 3]> {
    Ok([number(&value[0])?, number(&value[1])?, number(&value[2])?])
}

/// The angle between two directions, in radians.
fn between_rad(one: [f64; 3], other: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    (dot(one, other) / (dot(one, one) * dot(other, other)).sqrt())
        .clamp(-1.0, 1.0)
        .acos()
}

/// East, north, up.
fn axis(gimbal: &GimbalTruth) -> [f64; 3] {
    let level = gimbal.pitch_rad.cos();
    [
        level * gimbal.yaw_north_rad.sin(),
        level * gimbal.yaw_north_rad.cos(),
        gimbal.pitch_rad.sin(),
    ]
}

fn is_along(what: &str, told: &Value, wanted: [f64; 3]) -> Result<()> {
    let off_rad = between_rad(triple(told)?, wanted);
    ensure!(
        off_rad < OFF_RAD,
        "{what} off by {off_rad:.3} rad: {told}, not {wanted:?}"
    );
    Ok(())
}

/// `map` to `odom` to `base_link` is the pose; the axes of `odom` are those of `map`, and it lies where the vehicle was launched.
fn transforms_agree(frames: &Value, launched: &PositionNed) -> Result<()> {
    let off_m = place(&frames["composed"])?.distance_m(&place(&frames["pose"])?);
    ensure!(off_m < 1e-6, "composed off by {off_m} m: {frames}");
    ensure!(number(&frames["odom_yaw"])?.abs() < 1e-9, "{frames}");
    ensure!(
        (number(&frames["yaw"])? - number(&frames["pose_yaw"])?).abs() < 1e-9,
        "{frames}"
    );
    // Altitude of the launch place is that of the estimate, too.
    let off_m = place(&frames["odom_at"])?.distance_m(launched);
    ensure!(off_m < 1.5, "odom off by {off_m:.2} m: {frames}, {launched:?}");
    Ok(())
}

fn picture_is_whole(picture: &Value, vehicle: &VehicleTruth) -> Result<()> {
    ensure!(
        picture["format"] == "jpeg" && picture["size"] == picture["info_size"],
        "{picture}"
    );
    ensure!(number(&picture["bytes"])? > 2_000.0, "{picture}");
    for frame in ["image_frame", "info_frame"] {
        ensure!(picture[frame] == "uav_1/camera_optical", "{picture}");
    }
    ensure!(picture["model"] == "plumb_bob", "{picture}");
    let camera = vehicle.camera.context("a camera")?;
    let half_px = [number(&picture["size"][0])? / 2.0, number(&picture["size"][1])? / 2.0];
    let focal_px = half_px[0] / (camera.field_of_view_rad / 2.0).tan();
    let k = picture["k"].as_array().context("K")?;
    let wanted = [focal_px, 0.0, half_px[0], 0.0, focal_px, half_px[1], 0.0, 0.0, 1.0];
    for (told, wanted) in k.iter().zip(wanted) {
        ensure!(
            (number(told)? - wanted).abs() < 1e-3 * focal_px,
            "{picture}, not {wanted}"
        );
    }
    ensure!(
        picture["p"][0] == picture["k"][0] && picture["p"][6] == picture["k"][5],
        "{picture}"
    );
    Ok(())
}

/// The gimbal looks where it was told to, says so, and what the camera takes is taken from there.
fn looks_there(report: &Value, wanted: [f64; 3], vehicle: &VehicleTruth) -> Result<()> {
    let gimbal = vehicle.gimbal.context("a gimbal")?;
    is_along("what was wanted", &json!(wanted), axis(&gimbal))?;
    is_along("the state", &report["axis"], axis(&gimbal))?;
    ensure!(report["mode"] == "angles", "{report}");
    let picture = &report["picture"];
    picture_is_whole(picture, vehicle)?;
    is_along("the picture's axis", &picture["axis"], axis(&gimbal))?;
    // To the right of the picture is level, and a quarter turn clockwise from its axis.
    let (sin, cos) = gimbal.yaw_north_rad.sin_cos();
    is_along("the picture's right", &picture["right"], [cos, -sin, 0.0])?;
    let off_m = place(&picture["at"])?.distance_m(&vehicle.position);
    ensure!(off_m < 1.5, "taken {off_m:.2} m off: {picture} {vehicle:?}");
    Ok(())
}

/// Who is tracked is where he really is, but for what he has gone since he was told of.
fn track_agrees(report: &Value, swarm: &Swarm) -> Result<()> {
    let truth = swarm.simulation().truth();
    let mover = truth.movers.first().context("a mover")?;
    let [told] = report["tracks"].as_array().context("tracks")?.as_slice() else {
        anyhow::bail!("not one track: {report}");
    };
    ensure!(told["id"] == TRACK_TOLD && told["frame"] == "map", "{told}");
    ensure!(told["position"] == told["center"], "{told}");
    let age_s = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)?
        .as_secs_f64()
        - number(&told["stamp_s"])?;
    ensure!((-0.1..10.0).contains(&age_s), "{age_s} s old: {told}");
    let off_m = place(&told["position"])?.distance_m(&mover.position);
    let gone_m = mover.velocity.norm() * age_s;
    ensure!(
        off_m < 1.0 + gone_m,
        "off by {off_m:.2} m after {gone_m:.2} m: {told} {mover:?}"
    );
    Ok(())
}

/// What was found in a picture is the whole of it.
fn detection_agrees(told: &Value) -> Result<()> {
    ensure!(told["frame"] == "uav_1/camera_optical", "{told}");
    ensure!(told["class"] == "picture" && told["score"] == 1.0, "{told}");
    ensure!(!told["id"].as_str().context("an id")?.is_empty(), "{told}");
    let [width_px, height_px] = [number(&told["size"][0])?, number(&told["size"][1])?];
    ensure!(width_px > 100.0 && height_px > 100.0, "{told}");
    ensure!(told["center"] == json!([width_px / 2.0, height_px / 2.0]), "{told}");
    Ok(())
}

/// Tells the node where the other is, as a detector does.
async fn detect(swarm: &Swarm) -> Result<()> {
    let node = swarm.node();
    loop {
        let truth = swarm.simulation().truth();
        if let Some(mover) = truth.movers.first() {
            let track = Track {
                track: TRACK,
                position: mover.position,
                velocity: mover.velocity,
                time: node.now(),
                error_m: None,
            };
            node.set_tracks(vec![track])?;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

fn judge(phase: &str, report: &Value, swarm: &Swarm) -> Result<()> {
    let truth = swarm.simulation().truth();
    let vehicle = truth.vehicle(1).context("the vehicle")?;
    let launched = PositionNed::new(48.0, -25.0, -12.0);
    if phase != "graph" {
        all_agree(report, swarm, 1)?;
    }
    match phase {
        "graph" => everything_is_seen(report, 1).and_then(|()| payloads_are_seen(report)),
        "ground" | "up" => {
            transforms_agree(&report["frames"], &launched)?;
            is_along("the state", &report["axis"], axis(&vehicle.gimbal.context("a gimbal")?))?;
            track_agrees(report, swarm)?;
            detection_agrees(&report["detection"])
        }
        "pointed" => {
            // Forward, left and up of the vehicle, taken level.
            let [forward, left, up] = triple(&report["wanted"])?;
            let (sin, cos) = (FRAC_PI_2 - vehicle.yaw_rad).sin_cos();
            looks_there(
                report,
                [forward * cos - left * sin, forward * sin + left * cos, up],
                vehicle,
            )
        }
        "pointed_in_map" => looks_there(report, triple(&report["wanted"])?, vehicle),
        _ => Ok(()),
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn rclpy_sees_through_a_camera_turns_its_gimbal_and_follows_tracks() -> Result<()> {
    let domain_id = fresh_domain();
    let ros2 = tokio::task::spawn_blocking(Ros2::jazzy).await??;
    let plugins = tempfile::tempdir()?;
    let library = tokio::task::spawn_blocking(|| example_library("fixture-frame-counter", "frame_counter")).await?;
    std::fs::copy(library, plugins.path().join("libframe_counter.so"))?;
    let swarm = carrying(domain_id, plugins.path()).await;
    swarm.ready().await;
    let script = program(
        &ros2,
        domain_id,
        "ros2_payloads.py",
        &names(1),
        Duration::from_secs(600),
    )?;
    let mut watched = Watched::new(script);
    let flight = async {
        while let Some((phase, report)) = watched.next().await? {
            judge(&phase, &report, &swarm).context(phase)?;
        }
        Ok::<_, anyhow::Error>(())
    };
    tokio::select! {
        flown = flight => flown?,
        failed = detect(&swarm) => failed?,
    }
    let phases = ["graph", "ground", "up", "pointed", "pointed_in_map"];
    ensure!(watched.phases() == phases, "{:?}", watched.phases());
    say("  camera, gimbal, transforms and tracks agree with the truth");
    swarm.stop().await;
    Ok(())
}
