//! The real MAVSDK flies a simulated vehicle: what MAVSDK reports is held against the simulator's truth.

use anyhow::{Context, Result, bail, ensure};
use nalgebra::Vector3;
use serde_json::Value;
use skein_domain::{FlightMode, Geodetic, LandedState, PositionNed, SwarmFrame};
use skein_sim::{ModeCause, PortPlan, Px4Ports, SimSettings, Simulation, VehicleStart, VehicleTruth};
use skein_tests_interop::{Script, say};
use std::net::UdpSocket;
use std::time::Duration;

/// A port that was free a moment ago.
fn free_port() -> Result<u16> {
    Ok(UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port())
}

fn simulation(onboard_partner: u16, ground_partner: u16) -> Result<Simulation> {
    let ports = Px4Ports {
        onboard_local: 0,
        onboard_partner,
        ground_local: 0,
        ground_partner,
    };
    // Away from the origin and on a hill, so that no frame can be taken for another.
    let start = VehicleStart {
        system_id: Some(1),
        position: PositionNed::new(40.0, -25.0, -12.0),
        yaw_rad: 0.3,
        ..VehicleStart::default()
    };
    let settings = SimSettings {
        starts: vec![start],
        ports: PortPlan::Px4At(ports),
        ..SimSettings::default()
    };
    Ok(Simulation::start(settings)?)
}

fn triple(report: &Value, key: &str) -> Result<Vector3<f64>> {
    let numbers = report[key].as_array().with_context(|| format!("{key} in {report}"))?;
    let number = |i: usize| {
        numbers
            .get(i)
            .and_then(Value::as_f64)
            .with_context(|| format!("{key} in {report}"))
    };
    Ok(Vector3::new(number(0)?, number(1)?, number(2)?))
}

/// What MAVSDK says of place and speed must be what is the case, but for the estimate's small error and a moment's delay.
fn agrees(report: &Value, truth: &VehicleTruth, frame: &SwarmFrame) -> Result<()> {
    let speed = truth.velocity.norm();
    let tolerance = 0.3 + 0.3 * speed;
    let own = triple(report, "ned")? + truth.local_origin.vector();
    let off = (own - truth.position.vector()).norm();
    ensure!(off < tolerance, "local position off by {off:.2} m: {report} {truth:?}");
    let place = triple(report, "geodetic")?;
    let place = Geodetic {
        latitude_deg: place.x,
        longitude_deg: place.y,
        altitude_amsl_m: place.z,
    };
    let off = frame.position(&place).distance_m(&truth.position);
    ensure!(off < tolerance, "global position off by {off:.2} m: {report} {truth:?}");
    let off = (triple(report, "velocity")? - truth.velocity.vector()).norm();
    ensure!(off < 0.5, "velocity off by {off:.2} m/s: {report} {truth:?}");
    say(&format!(
        "  truth agrees: {:?}, {:.2} m/s, {}",
        truth.position, speed, truth.mode
    ));
    Ok(())
}

fn at_phase(report: &Value, truth: &VehicleTruth, start: &PositionNed) -> Result<()> {
    let gone = truth.position.vector() - start.vector();
    let phase = report["phase"].as_str().context("a phase")?;
    match phase {
        "ready" => {
            ensure!(report["version"] == serde_json::json!([1, 18]), "{report}");
            ensure!(!truth.armed && truth.landed == LandedState::OnGround);
        }
        "hovering" => {
            ensure!(truth.armed && truth.mode == FlightMode::Hold, "{truth:?}");
            ensure!((truth.height_m - 5.0).abs() < 0.5, "height {}", truth.height_m);
        }
        "north" => {
            ensure!(truth.mode == FlightMode::Offboard, "{truth:?}");
            ensure!((gone - Vector3::new(10.0, 0.0, -5.0)).norm() < 0.8, "{gone:?}");
        }
        "eastward" => ensure!((truth.velocity.east_m_s - 2.0).abs() < 0.4, "{truth:?}"),
        "stopped" => ensure!(gone.y > 5.0 && truth.velocity.norm() < 0.4, "{gone:?} {truth:?}"),
        "landed" => {
            ensure!(
                !truth.armed && truth.touches_ground && truth.landed == LandedState::OnGround,
                "{truth:?}"
            );
            ensure!(
                truth.touch_down_max_m_s < 0.7,
                "touched down at {} m/s",
                truth.touch_down_max_m_s
            );
            ensure!(
                truth.offboard_gap_sender_max_s < 1.0,
                "gap of {} s",
                truth.offboard_gap_sender_max_s
            );
        }
        other => bail!("unknown phase {other}"),
    }
    Ok(())
}

#[test]
fn mavsdk_connects_arms_takes_off_flies_offboard_and_lands() -> Result<()> {
    // Made before the vehicle is switched on: the script wants to see it refuse to be armed.
    skein_tests_interop::python()?;
    let port = free_port()?;
    let mut script = Script::start(
        "fly_offboard.py",
        &[format!("udpin://127.0.0.1:{port}")],
        Duration::from_secs(240),
    )?;
    let simulation = simulation(port, free_port()?)?;
    let start = simulation.truth().vehicle(1).context("vehicle 1")?.position;
    let frame = SwarmFrame::new(SimSettings::default().origin);
    let mut phases = Vec::new();
    while let Some(report) = script.report()? {
        let truth = simulation.truth();
        let truth = truth.vehicle(1).context("vehicle 1")?;
        agrees(&report, truth, &frame)?;
        at_phase(&report, truth, &start)?;
        phases.push(report["phase"].as_str().unwrap_or_default().to_owned());
    }
    ensure!(
        phases == ["ready", "hovering", "north", "eastward", "stopped", "landed"],
        "{phases:?}"
    );
    let truth = simulation.truth();
    let modes: Vec<_> = truth.vehicles[0].mode_changes.iter().map(|c| (c.to, c.cause)).collect();
    let expected = [
        (FlightMode::TakeOff, ModeCause::Commanded),
        (FlightMode::Hold, ModeCause::TakeOffEnded),
        (FlightMode::Offboard, ModeCause::Commanded),
        (FlightMode::Hold, ModeCause::Commanded),
        (FlightMode::Land, ModeCause::Commanded),
        (FlightMode::Hold, ModeCause::Disarmed),
    ];
    ensure!(modes == expected, "{modes:?}");
    simulation.stop();
    Ok(())
}
