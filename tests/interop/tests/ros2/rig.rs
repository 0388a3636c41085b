//! Both sides of a test: a swarm that ROS 2 sees, a program of ROS 2 under watch, and what one says held against what is the case with the other.
//!
//! Must never do: use a domain of another test; judge by what the swarm itself believes.

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use skein_config::NodeConfig;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{PositionNed, SwarmFrame};
use skein_sim::{SimSettings, VehicleStart, VehicleTruth};
use skein_testkit::Swarm;
use skein_tests_interop::{Ros2, Script, say};
use std::f64::consts::FRAC_PI_2;
use std::process::Command;
use std::time::Duration;

/// Domains are not used again: what has ended in one is remembered by others for a minute.
pub fn fresh_domain() -> u16 {
    use std::sync::atomic::{AtomicU32, Ordering};
    static GIVEN: AtomicU32 = AtomicU32::new(0);
    let number = std::process::id() * 7 + GIVEN.fetch_add(1, Ordering::Relaxed);
    u16::try_from(number % 100).unwrap_or_default() + 1
}

/// So many vehicles away from the origin and on a hill, so that no frame can be taken for another.
pub async fn swarm(vehicles: u8, domain_id: u16) -> Swarm {
    swarm_with(vehicles, domain_id, |_, _| ()).await
}

/// The same, after `adapt` has changed what it wants of both settings.
pub async fn swarm_with(vehicles: u8, domain_id: u16, adapt: impl FnOnce(&mut NodeConfig, &mut SimSettings)) -> Swarm {
    Swarm::start_with(usize::from(vehicles), |config, simulation| {
        config.swarm.origin = Some(simulation.origin);
        config.ros2.enabled = true;
        config.dds.domain_id = domain_id;
        config.ros2.take_off_height_m = 10.0;
        simulation.starts = (1..=vehicles)
            .map(|number| VehicleStart {
                system_id: Some(number),
                position: PositionNed::new(40.0 + 8.0 * f64::from(number), -25.0, -12.0),
                yaw_rad: 0.3,
                ..VehicleStart::default()
            })
            .collect();
        adapt(config, simulation);
    })
    .await
}

/// Names of so many vehicles.
pub fn names(vehicles: u8) -> Vec<String> {
    (1..=vehicles).map(|number| format!("uav_{number}")).collect()
}

/// Starts one of the scripts by the Python of a ROS 2.
pub fn program(ros2: &Ros2, domain_id: u16, script: &str, arguments: &[String], limit: Duration) -> Result<Script> {
    let mut python = Command::new(ros2.python());
    ros2.prepare(&mut python, domain_id);
    Script::start_by(python, script, arguments, limit)
}

/// A number of a report.
pub fn number(value: &Value) -> Result<f64> {
    value.as_f64().with_context(|| format!("a number: {value}"))
}

/// A place of a report.
pub fn place(value: &Value) -> Result<PositionNed> {
    let axis = |i: usize| number(&value[i]);
    // East, north, up.
    Ok(PositionNed::new(axis(1)?, axis(0)?, -axis(2)?))
}

/// A program whose reports are waited for, and what it has reported.
pub struct Watched {
    script: Option<Script>,
    phases: Vec<String>,
}

impl Watched {
    pub fn new(script: Script) -> Self {
        Self {
            script: Some(script),
            phases: Vec::new(),
        }
    }

    /// Its next report, with the phase of it; none when it has ended well.
    pub async fn next(&mut self) -> Result<Option<(String, Value)>> {
        let mut script = self.script.take().context("it has failed before")?;
        let (script, report) = tokio::task::spawn_blocking(move || {
            let report = script.report();
            (script, report)
        })
        .await?;
        self.script = Some(script);
        let Some(report) = report? else { return Ok(None) };
        let phase = report["phase"].as_str().context("a phase")?.to_owned();
        self.phases.push(phase.clone());
        Ok(Some((phase, report)))
    }

    /// What it has reported so far, in this order.
    pub fn phases(&self) -> &[String] {
        &self.phases
    }
}

/// What ROS 2 says of a vehicle must be what is the case, but for the estimate's small error and a moment's delay.
pub fn agrees(told: &Value, truth: &VehicleTruth, frame: &SwarmFrame) -> Result<()> {
    let tolerance_m = 0.5 + 0.5 * truth.velocity.norm();
    ensure!(told["frame"] == "map", "{told}");
    let off_m = place(&told["position"])?.distance_m(&truth.position);
    ensure!(off_m < tolerance_m, "off by {off_m:.2} m: {told} {truth:?}");
    let off_rad = wrap_angle_rad(FRAC_PI_2 - number(&told["yaw"])? - truth.yaw_rad).abs();
    ensure!(off_rad < 0.15, "turned by {off_rad:.2} rad: {told} {truth:?}");
    let age_s = number(&told["stamp_age_s"])?;
    ensure!((-0.1..2.0).contains(&age_s), "{age_s} s old: {told}");
    let off_m_s = (number(&told["speed"])? - truth.velocity.norm()).abs();
    ensure!(off_m_s < 0.6, "{off_m_s:.2} m/s off: {told} {truth:?}");
    let fix = &told["fix"];
    let fix = skein_domain::Geodetic {
        latitude_deg: number(&fix[0])?,
        longitude_deg: number(&fix[1])?,
        altitude_amsl_m: number(&fix[2])?,
    };
    // Told twice a second.
    let off_m = frame.position(&fix).distance_m(&truth.position);
    ensure!(
        off_m < tolerance_m + truth.velocity.norm(),
        "fix off by {off_m:.2} m: {told} {truth:?}"
    );
    ensure!(number(&told["battery"][0])? > 1.0, "{told}");
    Ok(())
}

/// The same of all vehicles.
pub fn all_agree(report: &Value, swarm: &Swarm, vehicles: u8) -> Result<()> {
    let frame = SwarmFrame::new(SimSettings::default().origin);
    let truth = swarm.simulation().truth();
    for id in 1..=vehicles {
        let truth = truth.vehicle(id).context("the vehicle")?;
        agrees(&report["poses"][format!("uav_{id}")], truth, &frame)?;
    }
    say("  truth agrees");
    Ok(())
}
