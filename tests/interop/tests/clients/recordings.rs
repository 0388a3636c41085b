//! Recordings and what is exported of them, read by the programs that people read such files with: the official MCAP reader, pandas over Apache Arrow,
//! fastkml, gpxpy, rosbags, mcap-ros2-support and pymavlink.

#[path = "../../../../core/export/src/tests/flight.rs"]
mod flight;

use anyhow::{Context, Result, ensure};
use flight::{BEGIN_UNIX_NS, Flight, ORIGIN, position};
use serde_json::{Value, json};
use skein_export::{Format, Overview, export, merge};
use skein_recording::Recording;
use skein_ros2::names::sanitised;
use skein_testkit::Process;
use skein_tests_interop::{Environment, Ros2, Script, python_of};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Readers of recordings and of everything that is made of them.
const READERS: Environment = Environment {
    name: "recordings",
    requirements: &[
        "mcap==1.6.0",
        "mcap-ros2-support==0.6.0",
        "pandas==3.1.1",
        "pyarrow==26.0.1",
        "rosbags==0.11.9",
        "pymavlink==2.4.50",
        "gpxpy==1.6.2",
        "fastkml==1.4.0",
    ],
    modules: "mcap, mcap_ros2, pandas, pyarrow, rosbags, pymavlink, gpxpy, fastkml",
};

fn made(folder: &Path) -> Result<[String; 3]> {
    let (first, _) = Flight::default().write(folder, "first.mcap");
    let second = Flight {
        node: Some(2),
        flies: Vec::new(),
        ..Flight::default()
    };
    let (second, _) = second.write(folder, "second.mcap");
    let recordings = [Recording::open(&first)?, Recording::open(&second)?];
    let merged = folder.join("merged.mcap");
    merge(&recordings, &merged, &mut |_| {})?;
    let out = exported(&recordings[0], folder)?;
    Ok([first, merged, out].map(|path| path.display().to_string()))
}

/// All that can be made of a recording, in a folder.
fn exported(recording: &Recording, folder: &Path) -> Result<PathBuf> {
    let out = folder.join("out");
    std::fs::create_dir(&out)?;
    for (format, name) in [
        (Format::Csv, "csv"),
        (Format::Parquet, "parquet"),
        (Format::Kml, "tracks.kml"),
        (Format::Gpx, "tracks.gpx"),
        (Format::Rosbag, "bag"),
        (Format::Tlog, "tlog"),
    ] {
        export(recording, format, &out.join(name), &mut |_| {})?;
    }
    Ok(out)
}

fn read(arguments: &[String; 3]) -> Result<Script> {
    let python = Command::new(python_of(&READERS)?);
    Script::start_by(python, "read_recordings.py", arguments, Duration::from_secs(180))
}

fn near(told: &Value, expected: f64, by: f64) -> bool {
    told.as_f64().is_some_and(|told| (told - expected).abs() <= by)
}

fn next(script: &mut Script, what: &str) -> Result<Value> {
    let report = script.report()?.with_context(|| format!("a report on {what}"))?;
    ensure!(report["what"] == what, "{report}");
    Ok(report)
}

fn check_recordings(script: &mut Script) -> Result<()> {
    let report = next(script, "recording")?;
    ensure!(report["metadata"] == json!(["skein"]), "{report}");
    ensure!(report["counts"]["/vehicles/2/telemetry"] == 200, "{report}");
    ensure!(report["schemas"]["/skein/events"] == "skein.EventRecord", "{report}");
    let report = next(script, "merged")?;
    ensure!(report["metadata"] == json!(["skein", "skein.merged"]), "{report}");
    let counts = &report["counts"];
    ensure!(counts["/vehicles/2/telemetry"] == 200, "{report}");
    ensure!(counts["/nodes/2/skein/events"] == 20, "{report}");
    ensure!(counts["/nodes/2/vehicles/3/telemetry"] == 200, "{report}");
    Ok(())
}

fn check_tables(script: &mut Script) -> Result<()> {
    let (text, by_column) = (next(script, "csv")?, next(script, "parquet")?);
    for report in [&text, &by_column] {
        let telemetry = &report["telemetry"];
        ensure!(telemetry["rows"] == 600 && telemetry["rows_of_2"] == 200, "{telemetry}");
        ensure!(telemetry["first"] == "2026-11-28T10:00:00+00:00", "{telemetry}");
        ensure!(near(&telemetry["time_s"], 1.0, 1e-9), "{telemetry}");
        let at = position(2, 1.0);
        let told = &telemetry["at"];
        ensure!(
            near(&told[0], at.north_m, 1e-9) && near(&told[2], at.down_m, 1e-9),
            "{telemetry}"
        );
        ensure!(
            report["setpoints"]["rows"] == 600 && report["events"]["rows"] == 20,
            "{report}"
        );
    }
    for kind in ["telemetry", "setpoints", "events"] {
        ensure!(text[kind]["columns"] == by_column[kind]["columns"], "{kind}");
    }
    Ok(())
}

fn check_tracks(script: &mut Script) -> Result<()> {
    let height_m = ORIGIN.altitude_amsl_m + 20.0;
    let (kml, gpx) = (next(script, "kml")?, next(script, "gpx")?);
    for report in [&kml, &gpx] {
        let track = &report["uav-2"];
        ensure!(
            track["points"] == 200 && near(&track["height_m"], height_m, 1e-3),
            "{report}"
        );
    }
    ensure!(kml["uav-1"]["first"] == "2026-11-28 10:00:00+00:00", "{kml}");
    // 6 m/s for 19.9 s; gpxpy's Earth has another radius.
    ensure!(near(&gpx["uav-2"]["length_m"], 119.4, 1.0), "{gpx}");
    ensure!(near(&gpx["uav-2"]["seconds"], 19.9, 1e-6), "{gpx}");
    Ok(())
}

fn check_bag(script: &mut Script) -> Result<()> {
    let report = next(script, "rosbag")?;
    // As the node itself calls it.
    let name = sanitised("uav-2");
    let topic = |part: &str| format!("/skein/{name}/{part}");
    for (part, kind) in [
        ("pose", "geometry_msgs/msg/PoseStamped"),
        ("velocity", "geometry_msgs/msg/TwistStamped"),
        ("nav_sat_fix", "sensor_msgs/msg/NavSatFix"),
        ("battery", "sensor_msgs/msg/BatteryState"),
        ("setpoint", "geometry_msgs/msg/PoseStamped"),
    ] {
        ensure!(report["counts"][topic(part)] == 200, "{part}: {report}");
        ensure!(report["types"][topic(part)] == kind, "{part}: {report}");
    }
    ensure!(
        report["counts"]["/tf"] == 200 && report["counts"]["/rosout"] == 20,
        "{report}"
    );
    let at = position(2, 19.9);
    let pose = &report["pose"];
    let is_there = near(&pose[0], at.east_m, 1e-9) && near(&pose[1], at.north_m, 1e-9) && near(&pose[2], 20.0, 1e-9);
    ensure!(is_there && report["frame"] == skein_ros2::frames::MAP, "{report}");
    let turned = skein_ros2::frames::orientation(f64::from(0.1_f32), f64::from(-0.05_f32), (19.9_f64 * 0.3).sin());
    for (index, part) in [turned.x, turned.y, turned.z, turned.w].into_iter().enumerate() {
        ensure!(near(&report["orientation"][index], part, 1e-9), "{report}");
    }
    let seconds = BEGIN_UNIX_NS / 1_000_000_000 + 19;
    ensure!(report["stamp"] == json!([seconds, 900_000_000]), "{report}");
    let base = skein_ros2::names::base_link("uav_3");
    let odom = skein_ros2::names::odom("uav_3");
    // Those of all vehicles of that moment.
    let transforms = report["transforms"].as_array().map_or(&[][..], Vec::as_slice);
    ensure!(transforms.len() == 6, "{report}");
    ensure!(
        transforms.ends_with(&[json!(["map", odom]), json!([odom, base])]),
        "{report}"
    );
    ensure!(near(&report["fix"][1], ORIGIN.altitude_amsl_m + 20.0, 1e-6), "{report}");
    ensure!(near(&report["voltage_v"], 15.2, 1e-6), "{report}");
    ensure!(
        report["log"][0] == 40 && report["log"][1] == "skein.uav_3.vehicle",
        "{report}"
    );
    Ok(())
}

fn check_logs(script: &mut Script) -> Result<()> {
    let report = next(script, "tlog")?;
    let log = &report["vehicle-2"];
    for (kind, count) in [
        ("GLOBAL_POSITION_INT", 200),
        ("POSITION_TARGET_LOCAL_NED", 200),
        ("HEARTBEAT", 20),
    ] {
        ensure!(log["counts"][kind] == count, "{kind}: {report}");
    }
    ensure!(near(&log["first"], BEGIN_UNIX_NS as f64 / 1e9, 1e-3), "{log}");
    ensure!(log["mode"] == "OFFBOARD" && log["armed"] == true, "{log}");
    let text = log["text"].as_str().unwrap_or_default();
    ensure!(text.starts_with("in second 2: <a> \"quoted\" text & more"), "{log}");
    ensure!(text.ends_with("two frames of MAVLink"), "{log}");
    ensure!(near(&log["alt_m"], ORIGIN.altitude_amsl_m + 20.0, 2e-3), "{log}");
    ensure!(
        near(&log["x_m"], position(2, 19.9).north_m, 1e-4) && near(&log["voltage_v"], 15.2, 1e-3),
        "{log}"
    );
    Ok(())
}

#[test]
fn everything_that_is_made_of_a_recording_is_read_by_the_programs_it_is_made_for() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let arguments = made(folder.path())?;
    let mut script = read(&arguments)?;
    check_recordings(&mut script)?;
    check_tables(&mut script)?;
    check_tracks(&mut script)?;
    check_bag(&mut script)?;
    check_logs(&mut script)?;
    ensure!(script.report()?.is_none(), "nothing after the end");
    Ok(())
}

/// Of what a vehicle told so often, these have as much: no row, point or message is lost on the way, and none is made up.
fn check_demonstration(script: &mut Script, recording: &Recording) -> Result<()> {
    let overview = Overview::of(recording);
    let messages = |topic: &str| {
        overview
            .topics
            .iter()
            .find(|of| of.topic == topic)
            .map(|of| of.messages)
    };
    let telemetry = |vehicle: u16| messages(&format!("/vehicles/{vehicle}/telemetry")).unwrap_or_default();
    let vehicles = &overview.vehicles;
    ensure!(vehicles.len() == 3 && telemetry(2) > 100, "{overview:?}");

    for what in ["recording", "merged"] {
        let report = next(script, what)?;
        for topic in &overview.topics {
            let counted = report["counts"][&topic.topic].as_u64().unwrap_or_default();
            ensure!(counted == topic.messages, "{}: {report}", topic.topic);
        }
    }
    let told: u64 = vehicles.iter().map(|vehicle| telemetry(*vehicle)).sum();
    for what in ["csv", "parquet"] {
        let report = next(script, what)?;
        ensure!(report["telemetry"]["rows"] == told, "{told}: {report}");
        ensure!(report["telemetry"]["rows_of_2"] == telemetry(2), "{report}");
    }
    // A vehicle's first telemetry may come before its first place.
    let kml = next(script, "kml")?;
    let placed = |vehicle: u16| kml[format!("uav-{vehicle}")]["points"].clone();
    for vehicle in vehicles {
        let points = placed(*vehicle).as_u64().unwrap_or_default();
        ensure!(points > 100 && points <= telemetry(*vehicle), "{vehicle}: {kml}");
    }
    let gpx = next(script, "gpx")?;
    let (bag, logs) = (next(script, "rosbag")?, next(script, "tlog")?);
    ensure!(bag["types"]["/tf"] == "tf2_msgs/msg/TFMessage", "{bag}");
    for vehicle in vehicles {
        ensure!(gpx[format!("uav-{vehicle}")]["points"] == placed(*vehicle), "{gpx}");
        let counts = &bag["counts"];
        ensure!(
            counts[format!("/skein/uav_{vehicle}/battery")] == telemetry(*vehicle),
            "{bag}"
        );
        ensure!(
            counts[format!("/skein/uav_{vehicle}/pose")] == placed(*vehicle),
            "{bag}"
        );
        let log = &logs[format!("vehicle-{vehicle}")];
        ensure!(
            log["counts"]["GLOBAL_POSITION_INT"] == placed(*vehicle),
            "{vehicle}: {log}"
        );
        ensure!(log["armed"] == false, "it has landed: {log}");
    }
    ensure!(script.report()?.is_none(), "nothing after the end");
    Ok(())
}

/// How many messages of each topic of a bag rclpy has deserialised; what it plays comes whole.
fn taken_by_ros2(bag: &Path) -> Result<Value> {
    let ros2 = Ros2::jazzy()?;
    let mut python = Command::new(ros2.python());
    ros2.prepare(&mut python, 0);
    let arguments = [bag.display().to_string()];
    let mut script = Script::start_by(python, "ros2_bag.py", &arguments, Duration::from_secs(300))?;
    let mut next = |phase: &str| {
        let report = script.report()?.with_context(|| format!("a report on {phase}"))?;
        ensure!(report["phase"] == phase, "{report}");
        Ok(report["counts"].clone())
    };
    let (deserialised, played) = (next("deserialised")?, next("played")?);
    ensure!(played == deserialised, "played {played} of {deserialised}");
    ensure!(script.report()?.is_none(), "nothing after the end");
    Ok(deserialised)
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn the_recording_of_the_demonstration_is_read_by_the_same_programs() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let flights = folder.path().join("flights");
    let into = flights.to_str().context("is text")?;
    let mut demonstration = Process::skein(&[
        "demo",
        "--headless",
        "--port",
        "0",
        "--vehicles",
        "3",
        "--seconds",
        "60",
        "--record",
        into,
    ]);
    // How well it flew is judged elsewhere.
    demonstration.exit_code(Duration::from_secs(300)).await;
    let files = std::fs::read_dir(&flights).with_context(|| demonstration.output())?;
    let mut files: Vec<PathBuf> = files.filter_map(Result::ok).map(|entry| entry.path()).collect();
    files.sort_by_key(|path| path.metadata().map(|of| of.len()).unwrap_or_default());
    let flight = files.last().context("it was recorded")?;
    let recording = Recording::open(flight)?;
    ensure!(recording.is_finished(), "{:?}", recording.damage());
    let out = exported(&recording, folder.path())?;
    let arguments = [flight, flight, &out].map(|path| path.display().to_string());
    check_demonstration(&mut read(&arguments)?, &recording)?;
    let bag = out.join("bag");
    let counts = tokio::task::spawn_blocking(move || taken_by_ros2(&bag)).await??;
    let of = |topic: &str| counts[topic].as_u64().unwrap_or_default();
    let overview = Overview::of(&recording);
    let told = |topic: &str| {
        overview
            .topics
            .iter()
            .find(|of| of.topic == topic)
            .map(|of| of.messages)
    };
    ensure!(overview.vehicles.len() == 3, "{overview:?}");
    for vehicle in overview.vehicles {
        let battery = of(&format!("/skein/uav_{vehicle}/battery"));
        ensure!(
            Some(battery) == told(&format!("/vehicles/{vehicle}/telemetry")),
            "{counts}"
        );
    }
    Ok(())
}
