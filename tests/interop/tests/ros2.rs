//! Real ROS 2 meets the swarm: an rclpy program sees nodes, topics and services, reads where the vehicles really are, commands them, steers one by
//! velocity, and is refused with reasons. Standard messages are those of its packages.

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{PositionNed, SwarmFrame};
use skein_ros2::interfaces::{self, Interface};
use skein_sim::{SimSettings, VehicleStart, VehicleTruth};
use skein_testkit::Swarm;
use skein_tests_interop::{Ros2, Script, say};
use std::f64::consts::FRAC_PI_2;
use std::process::Command;
use std::time::Duration;

/// Domains are not used again: what has ended in one is remembered by others for a minute.
fn fresh_domain() -> u16 {
    use std::sync::atomic::{AtomicU32, Ordering};
    static GIVEN: AtomicU32 = AtomicU32::new(0);
    let number = std::process::id() * 7 + GIVEN.fetch_add(1, Ordering::Relaxed);
    u16::try_from(number % 100).unwrap_or_default() + 1
}

/// So many vehicles away from the origin and on a hill, so that no frame can be taken for another.
async fn swarm(vehicles: u8, domain_id: u16) -> Swarm {
    Swarm::start_with(usize::from(vehicles), |config, simulation: &mut SimSettings| {
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
    })
    .await
}

fn citizen(ros2: &Ros2, domain_id: u16, mode: &str, vehicles: u8, limit: Duration) -> Result<Script> {
    let mut python = Command::new(ros2.python());
    ros2.prepare(&mut python, domain_id);
    let names = (1..=vehicles).map(|number| format!("uav_{number}"));
    let arguments: Vec<String> = std::iter::once(mode.to_owned()).chain(names).collect();
    Script::start_by(python, "ros2_citizen.py", &arguments, limit)
}

fn number(value: &Value) -> Result<f64> {
    value.as_f64().with_context(|| format!("a number: {value}"))
}

fn place(value: &Value) -> Result<PositionNed> {
    let axis = |i: usize| number(&value[i]);
    // East, north, up.
    Ok(PositionNed::new(axis(1)?, axis(0)?, -axis(2)?))
}

/// What ROS 2 says of a vehicle must be what is the case, but for the estimate's small error and a moment's delay.
fn agrees(told: &Value, truth: &VehicleTruth, frame: &SwarmFrame) -> Result<()> {
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

fn all_agree(report: &Value, swarm: &Swarm, vehicles: u8) -> Result<()> {
    let frame = SwarmFrame::new(SimSettings::default().origin);
    let truth = swarm.simulation().truth();
    for id in 1..=vehicles {
        let truth = truth.vehicle(id).context("the vehicle")?;
        agrees(&report["poses"][format!("uav_{id}")], truth, &frame)?;
    }
    say("  truth agrees");
    Ok(())
}

/// Name and type of everything that is to be seen of one vehicle and of the swarm.
const OF_A_VEHICLE: &[(&str, &str)] = &[
    ("pose", "geometry_msgs/msg/PoseStamped"),
    ("odometry", "nav_msgs/msg/Odometry"),
    ("nav_sat_fix", "sensor_msgs/msg/NavSatFix"),
    ("battery", "sensor_msgs/msg/BatteryState"),
    ("state", "skein_msgs/msg/VehicleState"),
    ("cmd_vel", "geometry_msgs/msg/Twist"),
];
const OF_THE_SWARM: &[(&str, &str)] = &[
    ("/skein/formation", "skein_msgs/msg/Formation"),
    ("/skein/tracks", "vision_msgs/msg/Detection3DArray"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
];
const SERVICES_OF_A_VEHICLE: &[(&str, &str)] = &[
    ("arm", "std_srvs/srv/SetBool"),
    ("take_off", "std_srvs/srv/Trigger"),
    ("land", "std_srvs/srv/Trigger"),
    ("hold", "std_srvs/srv/Trigger"),
    ("return_home", "std_srvs/srv/Trigger"),
    ("take_off_to", "skein_msgs/srv/TakeOff"),
    ("go_to", "skein_msgs/srv/GoTo"),
    ("point_gimbal", "skein_msgs/srv/PointGimbal"),
];
const SERVICES_OF_THE_SWARM: &[(&str, &str)] = &[
    ("take_off", "std_srvs/srv/Trigger"),
    ("land", "std_srvs/srv/Trigger"),
    ("hold", "std_srvs/srv/Trigger"),
    ("return_home", "std_srvs/srv/Trigger"),
    ("dissolve_formation", "std_srvs/srv/Trigger"),
    ("set_formation", "skein_msgs/srv/SetFormation"),
    ("follow", "skein_msgs/srv/Follow"),
];

fn everything_is_seen(report: &Value, vehicles: u8) -> Result<()> {
    let seen = |kind: &str, name: &str, of: &str| {
        let types = &report[kind][name];
        ensure!(types == &serde_json::json!([of]), "{kind}: {name} is {types}, not {of}");
        Ok(())
    };
    for id in 1..=vehicles {
        for (topic, kind) in OF_A_VEHICLE {
            seen("topics", &format!("/skein/uav_{id}/{topic}"), kind)?;
        }
        for (service, kind) in SERVICES_OF_A_VEHICLE {
            seen("services", &format!("/skein/uav_{id}/{service}"), kind)?;
        }
    }
    for (topic, kind) in OF_THE_SWARM {
        seen("topics", topic, kind)?;
    }
    for (service, kind) in SERVICES_OF_THE_SWARM {
        seen("services", &format!("/skein/{service}"), kind)?;
    }
    Ok(())
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
        (7.0..18.0).contains(&forward_m) && aside_m.abs() < 1.5 && gone.z.abs() < 1.0,
        "{gone:?}"
    );
    ensure!((1.2..2.5).contains(&number(&report["forward"])?), "{report}");
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

/// The script's next report; none when it has ended well.
async fn next(mut script: Script) -> Result<(Script, Option<Value>)> {
    let (script, report) = tokio::task::spawn_blocking(move || {
        let report = script.report();
        (script, report)
    })
    .await?;
    Ok((script, report?))
}

#[tokio::test(flavor = "multi_thread")]
async fn rclpy_of_jazzy_sees_commands_and_steers_the_swarm() -> Result<()> {
    let (vehicles, domain_id) = (3, fresh_domain());
    let ros2 = tokio::task::spawn_blocking(Ros2::jazzy).await??;
    // The program is there before the swarm is.
    let mut script = citizen(&ros2, domain_id, "fly", vehicles, Duration::from_secs(600))?;
    let swarm = swarm(vehicles, domain_id).await;
    swarm.ready().await;
    let (mut phases, mut before) = (Vec::new(), Value::Null);
    loop {
        let (back, report) = next(script).await?;
        script = back;
        let Some(report) = report else { break };
        let phase = report["phase"].as_str().context("a phase")?.to_owned();
        judge(&phase, &report, &before, &swarm, vehicles).with_context(|| phase.clone())?;
        before = report;
        phases.push(phase);
    }
    ensure!(phases == PHASES, "{phases:?}");
    // Another program that comes when all is over sees everything too.
    let late = citizen(&ros2, domain_id, "look", vehicles, Duration::from_secs(120))?;
    let (mut late, seen) = next(late).await?;
    everything_is_seen(&seen.context("a report")?, vehicles)?;
    while let (back, Some(_)) = next(late).await? {
        late = back;
    }
    swarm.stop().await;
    Ok(())
}

/// Name and type of each field in a definition, with whole names of types.
fn defined(text: &str, package: &str) -> Vec<(String, String)> {
    let fields = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim());
    fields
        .filter(|line| !line.is_empty() && !line.contains('='))
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (kind, name) = (words.next()?, words.next()?);
            let is_own = !kind.contains('/') && kind.starts_with(|c: char| c.is_ascii_uppercase());
            let kind = if is_own {
                format!("{package}/{kind}")
            } else {
                kind.to_owned()
            };
            Some((name.to_owned(), kind.replace("byte", "uint8")))
        })
        .collect()
}

fn is_defined_so<T: Interface>(ros2: &Ros2) -> Result<()> {
    let path = ros2
        .share()
        .join(T::PACKAGE)
        .join("msg")
        .join(format!("{}.msg", T::NAME));
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let own: Vec<_> = T::fields()
        .into_iter()
        .map(|(name, kind)| (name.to_owned(), kind))
        .collect();
    ensure!(defined(&text, T::PACKAGE) == own, "{}: {text}\n{own:?}", path.display());
    Ok(())
}

#[test]
fn standard_messages_are_those_of_ros_2() -> Result<()> {
    use interfaces::{diagnostic, geometry, nav, sensor, standard};
    let ros2 = Ros2::jazzy()?;
    is_defined_so::<standard::Time>(&ros2)?;
    is_defined_so::<standard::Header>(&ros2)?;
    is_defined_so::<geometry::Point>(&ros2)?;
    is_defined_so::<geometry::Vector3>(&ros2)?;
    is_defined_so::<geometry::Quaternion>(&ros2)?;
    is_defined_so::<geometry::Pose>(&ros2)?;
    is_defined_so::<geometry::PoseStamped>(&ros2)?;
    is_defined_so::<geometry::PoseWithCovariance>(&ros2)?;
    is_defined_so::<geometry::Twist>(&ros2)?;
    is_defined_so::<geometry::TwistWithCovariance>(&ros2)?;
    is_defined_so::<geometry::Transform>(&ros2)?;
    is_defined_so::<geometry::TransformStamped>(&ros2)?;
    is_defined_so::<nav::Odometry>(&ros2)?;
    is_defined_so::<sensor::NavSatStatus>(&ros2)?;
    is_defined_so::<sensor::NavSatFix>(&ros2)?;
    is_defined_so::<sensor::BatteryState>(&ros2)?;
    is_defined_so::<sensor::CompressedImage>(&ros2)?;
    is_defined_so::<sensor::RegionOfInterest>(&ros2)?;
    is_defined_so::<sensor::CameraInfo>(&ros2)?;
    is_defined_so::<diagnostic::KeyValue>(&ros2)?;
    is_defined_so::<diagnostic::DiagnosticStatus>(&ros2)?;
    is_defined_so::<diagnostic::DiagnosticArray>(&ros2)
}
