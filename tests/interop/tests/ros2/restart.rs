//! A program of ROS 2 that commands is killed in flight, and another one takes its place: what it steered holds, nobody else notices.
//!
//! Must never do: forgive a vehicle that left OFFBOARD unasked.

use crate::graph::everything_is_seen;
use crate::rig::{Watched, all_agree, fresh_domain, names, number, place, program, swarm};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use skein_domain::{FlightMode, FlightState, PositionNed, VelocityNed};
use skein_sim::ModeCause;
use skein_testkit::{LONGEST_GAP_S, Swarm};
use skein_tests_interop::{Ros2, Script, say};
use std::time::{Duration, Instant};

const VEHICLES: u8 = 4;
/// Who is steered; the others follow each other.
const ALONE: u8 = 4;

fn commander(ros2: &Ros2, domain_id: u16, mode: &str) -> Result<Watched> {
    let arguments: Vec<String> = std::iter::once(mode.to_owned()).chain(names(VEHICLES)).collect();
    let script: Script = program(
        ros2,
        domain_id,
        "ros2_commander.py",
        &arguments,
        Duration::from_secs(600),
    )?;
    Ok(Watched::new(script))
}

fn steered(swarm: &Swarm) -> Result<(PositionNed, VelocityNed)> {
    let truth = swarm.simulation().truth();
    let vehicle = truth.vehicle(ALONE).context("the steered vehicle")?;
    Ok((vehicle.position, vehicle.velocity))
}

/// Nobody but who was asked has left OFFBOARD, and setpoints went on.
async fn nothing_disturbed(swarm: &Swarm) -> Result<()> {
    for vehicle in &swarm.truth_now().await.vehicles {
        let unasked = vehicle
            .mode_changes
            .iter()
            .find(|change| change.from == FlightMode::Offboard && change.cause != ModeCause::Commanded);
        ensure!(unasked.is_none(), "{} left OFFBOARD: {unasked:?}", vehicle.system_id);
        let gap_s = vehicle.offboard_gap_sender_max_s;
        ensure!(
            gap_s < LONGEST_GAP_S,
            "{}: {gap_s:.3} s without a setpoint",
            vehicle.system_id
        );
    }
    Ok(())
}

/// What the vehicle does once nobody steers it any more: it stands and holds, still in OFFBOARD, the others still in formation.
async fn holds_unsteered(swarm: &Swarm) -> Result<()> {
    let killed = Instant::now();
    let (from, _) = steered(swarm)?;
    let holds = |fleet: &skein_view::FleetSnapshot| {
        let state = |id: u8| {
            fleet
                .vehicles
                .iter()
                .find(|v| v.system_id.0 == id)
                .map(|v| v.flight_state)
        };
        state(ALONE) == Some(FlightState::Holding) && steered(swarm).is_ok_and(|(_, velocity)| velocity.norm() < 0.3)
    };
    let fleet = swarm
        .until("the vehicle that nobody steers holds", Duration::ZERO, holds)
        .await;
    let (to, _) = steered(swarm)?;
    let gone_m = from.distance_m(&to);
    say(&format!(
        "  held {:.1} s and {gone_m:.1} m after the kill",
        killed.elapsed().as_secs_f64()
    ));
    // Five seconds lie ahead at most; it was as fast as 2 m/s.
    ensure!(gone_m < 12.0, "went on for {gone_m:.1} m");
    let formation = fleet.formation.context("the column is still there")?;
    ensure!(formation.members.len() == 3, "{formation:?}");
    let truth = swarm.truth_now().await;
    for vehicle in &truth.vehicles {
        ensure!(vehicle.mode == FlightMode::Offboard && vehicle.armed, "{vehicle:?}");
    }
    nothing_disturbed(swarm).await
}

fn judge(phase: &str, report: &Value, swarm: &Swarm) -> Result<()> {
    match phase {
        "graph" => everything_is_seen(report, VEHICLES),
        "steering" => {
            let (_, velocity) = steered(swarm)?;
            ensure!(velocity.norm() > 1.0, "{velocity:?}");
            Ok(())
        }
        "seen" => {
            all_agree(report, swarm, VEHICLES)?;
            ensure!(report["members"] == serde_json::json!([1, 2, 3]), "{report}");
            ensure!(report["states"]["uav_4"] == "holding", "{report}");
            Ok(())
        }
        "steered" => {
            let gone_m =
                place(&report["before"]["position"])?.distance_m(&place(&report["poses"]["uav_4"]["position"])?);
            ensure!((3.0..14.0).contains(&gone_m), "{gone_m} m: {report}");
            Ok(())
        }
        "there" => {
            all_agree(report, swarm, VEHICLES)?;
            let off_m = steered(swarm)?.0.distance_m(&place(&report["goal"])?);
            ensure!(off_m < 1.5, "{off_m:.2} m off its goal: {report}");
            Ok(())
        }
        "down" => {
            all_agree(report, swarm, VEHICLES)?;
            let speed = number(&report["poses"]["uav_4"]["speed"])?;
            ensure!(speed < 0.3, "{report}");
            Ok(())
        }
        "stands" => all_agree(report, swarm, VEHICLES),
        _ => Ok(()),
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn a_killed_program_leaves_a_holding_vehicle_and_its_successor_commands_it() -> Result<()> {
    let domain_id = fresh_domain();
    let ros2 = tokio::task::spawn_blocking(Ros2::jazzy).await??;
    let swarm = swarm(VEHICLES, domain_id).await;
    swarm.ready().await;
    let mut first = commander(&ros2, domain_id, "lead")?;
    while let Some((phase, report)) = first.next().await? {
        judge(&phase, &report, &swarm).context(phase.clone())?;
        if phase == "steering" {
            break;
        }
    }
    ensure!(first.phases() == ["graph", "steering"], "{:?}", first.phases());
    // It has no time to say goodbye.
    drop(first);
    holds_unsteered(&swarm).await?;
    let mut second = commander(&ros2, domain_id, "resume")?;
    while let Some((phase, report)) = second.next().await? {
        judge(&phase, &report, &swarm).context(phase)?;
    }
    let phases = ["graph", "seen", "steered", "stands", "there", "down"];
    ensure!(second.phases() == phases, "{:?}", second.phases());
    nothing_disturbed(&swarm).await?;
    swarm.stop().await;
    Ok(())
}
