//! A whole flight by a program of ROS 2: it sees nodes, topics and services, reads where the vehicles really are, commands them, steers one by
//! velocity, and is refused with reasons.
//!
//! Must never do: take the program's word for what the simulator knows better.

use crate::graph::everything_is_seen;
use crate::rig::{Watched, all_agree, fresh_domain, names, number, place, program, swarm};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use skein_testkit::Swarm;
use skein_tests_interop::{Ros2, say};
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

fn citizen(ros2: &Ros2, domain_id: u16, mode: &str, vehicles: u8, limit: Duration) -> Result<Watched> {
    let arguments: Vec<String> = std::iter::once(mode.to_owned()).chain(names(vehicles)).collect();
    Ok(Watched::new(program(
        ros2,
        domain_id,
        "ros2_citizen.py",
        &arguments,
        limit,
    )?))
}

fn refusals_have_reasons(report: &Value) -> Result<()> {
    let answers = &report["answers"];
    for (what, code) in [
        ("nan", "invalid_value"),
        ("huge", "invalid_value"),
        ("shape", "invalid_value"),
        ("nobody", "invalid_value"),
        ("no_gimbal", "invalid_value"),
        ("on_ground", "wrong_state"),
    ] {
        ensure!(answers[what] == code, "{what}: {answers}");
    }
    let flood = answers["flood"].as_array().context("the answers to the flood")?;
    ensure!(flood.contains(&"too_many_requests".into()), "{answers}");
    ensure!(
        flood
            .iter()
            .all(|code| code == "too_many_requests" || code == "wrong_state"),
        "{answers}"
    );
    Ok(())
}

/// Forward as fast as asked, and not far beyond the last word.
fn was_steered(before: &Value, report: &Value) -> Result<()> {
    let first = |report: &Value| place(&report["poses"]["uav_1"]["position"]);
    let gone = first(report)?.vector() - first(before)?.vector();
    let yaw_cw_rad = FRAC_PI_2 - number(&before["poses"]["uav_1"]["yaw"])?;
    let forward_m = gone.x * yaw_cw_rad.cos() + gone.y * yaw_cw_rad.sin();
    let aside_m = -gone.x * yaw_cw_rad.sin() + gone.y * yaw_cw_rad.cos();
    say(&format!(
        "  {forward_m:.1} m forward, {aside_m:.1} m aside at {} m/s",
        report["forward"]
    ));
    ensure!(
        (9.0..18.0).contains(&forward_m) && aside_m.abs() < 1.5 && gone.z.abs() < 1.0,
        "{gone:?}"
    );
    ensure!((1.6..2.3).contains(&number(&report["forward"])?), "{report}");
    Ok(())
}

fn garbage_moved_nothing(before: &Value, report: &Value) -> Result<()> {
    let first = |report: &Value| place(&report["poses"]["uav_1"]["position"]);
    let moved_m = first(before)?.distance_m(&first(report)?);
    // It may still have been settling.
    ensure!(moved_m < 1.5, "moved by {moved_m:.2} m");
    let told = &report["diagnostics"];
    ensure!(told["cmd_vel_engaged"] == "false", "{told}");
    let refused: u64 = told["cmd_vel_refused"].as_str().context("a count")?.parse()?;
    ensure!(refused > 0, "{told}");
    let reason = told["cmd_vel_reason"].as_str().context("a reason")?;
    ensure!(reason.starts_with("invalid_value"), "{told}");
    Ok(())
}

/// What the script reports in this order; each is held against what is the case.
const PHASES: [&str; 13] = [
    "graph",
    "rates",
    "ground",
    "refusals",
    "up",
    "there",
    "steering",
    "steered",
    "expired",
    "garbage",
    "formed",
    "following",
    "down",
];

fn rates_are_as_set(report: &Value, vehicles: u8) -> Result<()> {
    let rate = |topic: &str| number(&report["rates"][format!("/skein/uav_1/{topic}")]);
    // 20 and 2 a second; a busy machine may give less.
    ensure!((5.0..25.0).contains(&rate("pose")?), "{report}");
    ensure!((0.6..3.0).contains(&rate("battery")?), "{report}");
    ensure!(report["diagnostics"] == u64::from(vehicles) + 1, "{report}");
    Ok(())
}

fn is_there(report: &Value) -> Result<()> {
    let there = place(&report["poses"]["uav_1"]["position"])?;
    let off_m = there.distance_m(&place(&report["goal"])?);
    ensure!(off_m < 1.0, "{off_m:.2} m off its goal: {report}");
    Ok(())
}

fn is_formed(report: &Value) -> Result<()> {
    ensure!(report["members"].as_array().is_some_and(|m| m.len() == 3), "{report}");
    let told = &report["told"];
    ensure!(told[0] == "wedge" && told[1] == report["members"], "{report}");
    Ok(())
}

/// Holds what is reported of one phase against what is the case.
fn judge(phase: &str, report: &Value, before: &Value, swarm: &Swarm, vehicles: u8) -> Result<()> {
    match phase {
        "graph" => everything_is_seen(report, vehicles),
        "rates" => rates_are_as_set(report, vehicles),
        "refusals" => refusals_have_reasons(report),
        "ground" | "up" | "down" => all_agree(report, swarm, vehicles),
        "there" => all_agree(report, swarm, vehicles).and_then(|()| is_there(report)),
        "steered" => was_steered(before, report),
        "garbage" => garbage_moved_nothing(before, report),
        "formed" => is_formed(report),
        "expired" => {
            ensure!(number(&report["after_s"])? < 10.0, "{report}");
            Ok(())
        }
        "following" => {
            let behind_2 = report["members"] == serde_json::json!([2, 1]) && report["leader"] == 2;
            ensure!(behind_2, "{report}");
            Ok(())
        }
        // Where it begins from.
        _ => Ok(()),
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn rclpy_of_jazzy_sees_commands_and_steers_the_swarm() -> Result<()> {
    flown_by(Ros2::jazzy).await
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn rclpy_of_kilted_sees_commands_and_steers_the_swarm() -> Result<()> {
    flown_by(Ros2::kilted).await
}

async fn flown_by(release: fn() -> Result<Ros2>) -> Result<()> {
    let (vehicles, domain_id) = (3, fresh_domain());
    let ros2 = tokio::task::spawn_blocking(release).await??;
    // The program is there before the swarm is.
    let mut script = citizen(&ros2, domain_id, "fly", vehicles, Duration::from_secs(600))?;
    let swarm = swarm(vehicles, domain_id).await;
    swarm.ready().await;
    let mut before = Value::Null;
    while let Some((phase, report)) = script.next().await? {
        judge(&phase, &report, &before, &swarm, vehicles).context(phase)?;
        before = report;
    }
    ensure!(script.phases() == PHASES, "{:?}", script.phases());
    // Another program that comes when all is over sees everything too.
    let mut late = citizen(&ros2, domain_id, "look", vehicles, Duration::from_secs(120))?;
    while let Some((phase, report)) = late.next().await? {
        if phase == "graph" {
            everything_is_seen(&report, vehicles)?;
        }
    }
    ensure!(late.phases() == ["graph", "rates", "ground"], "{:?}", late.phases());
    swarm.stop().await;
    Ok(())
}
