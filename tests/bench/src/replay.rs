//! A long recording opened and wound back and forth, beside reading it once from its beginning to its end: what a person waits for who looks at
//! a flight again.
//!
//! Must never do: time anything but the recording; the flight in it is made up.

use crate::error::BenchError;
use serde::Serialize;
use serde_json::json;
use skein_domain::exchange::Severity;
use skein_domain::{Geodetic, NodeTime, PositionNed, Setpoint, SwarmFrame, VehicleId, VelocityNed};
use skein_recording::{
    Encoded, FORMAT, Header, Recording, Select, SetpointRecord, TimeBase, Topic, VehicleTelemetry, Writer, scene,
};
use skein_replay::{Replay, ReplayChange, ReplayError};
use skein_view::{EventKind, EventRecord, FleetSnapshot, VehicleSnapshot};
use std::fmt;
use std::path::Path;
use std::time::{Duration, Instant};

const ORIGIN: Geodetic = Geodetic {
    latitude_deg: 47.397_742,
    longitude_deg: 8.545_594,
    altitude_amsl_m: 488.0,
};
/// Telemetry of a flying vehicle is recorded so often in a second, setpoints less so.
const TELEMETRY: u32 = 5;
/// Jumps that are timed.
const JUMPS: u64 = 200;

/// What to run.
#[derive(Debug, Clone, Copy)]
pub struct ReplayBenchArgs {
    /// How many vehicles.
    pub vehicles: u16,
    /// How long the flight is, in minutes.
    pub minutes: u32,
}

/// What it came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayBenchReport {
    /// How many vehicles.
    pub vehicles: u16,
    /// How long the flight is, in minutes.
    pub minutes: u32,
    /// Size of its recording in bytes.
    pub bytes: u64,
    /// From opening it to the first picture, in milliseconds.
    pub open_ms: f64,
    /// From opening it to its whole timeline, in milliseconds.
    pub timeline_ms: f64,
    /// A jump to any moment until its picture is there, in milliseconds: the median, 99 of 100, the longest.
    pub jump_ms: [f64; 3],
    /// Reading every message of it once, in milliseconds.
    pub through_ms: f64,
    /// The median of a jump as a share of that.
    pub jump_ratio: f64,
}

impl fmt::Display for ReplayBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p50, p99, max] = self.jump_ms;
        writeln!(
            f,
            "Replay of {} minutes of {} vehicles ({:.1} MB):",
            self.minutes,
            self.vehicles,
            self.bytes as f64 * 1e-6
        )?;
        writeln!(f, "  opened and shown after      {:>9.1} ms", self.open_ms)?;
        writeln!(f, "  its timeline is there after {:>9.1} ms", self.timeline_ms)?;
        writeln!(
            f,
            "  a jump to any moment        {p50:>9.1} ms (99 of 100: {p99:.1}, longest: {max:.1})"
        )?;
        writeln!(f, "  every message read once     {:>9.1} ms", self.through_ms)?;
        writeln!(f, "  a jump is {:.5} of that", self.jump_ratio)
    }
}

fn of_recording(error: impl fmt::Display) -> BenchError {
    BenchError::Child {
        part: "recording",
        detail: error.to_string(),
    }
}

/// Makes a flight up, records it, and looks at it again.
///
/// # Errors
/// When the recording cannot be written or read.
pub fn run_replay_bench(args: ReplayBenchArgs) -> Result<ReplayBenchReport, BenchError> {
    let system = |what| move |source| BenchError::System { what, source };
    let folder = tempfile::tempdir().map_err(system("making a folder"))?;
    let path = folder.path().join("flight.mcap");
    record(args, &path).map_err(of_recording)?;
    let recording = Recording::open(&path).map_err(of_recording)?;
    let begun = Instant::now();
    let read = recording.messages(Select::default()).filter(Result::is_ok).count();
    let through_ms = ms(begun);
    if read == 0 {
        return Err(of_recording("nothing of it can be read"));
    }
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let looked_at = looked_at(&path, args.vehicles);
    let (open_ms, timeline_ms, mut jumps_ms) = runtime.map_err(system("making a runtime"))?.block_on(looked_at)?;
    jumps_ms.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (jumps_ms.len() - 1) as f64).round() as usize;
        jumps_ms.get(index).copied().unwrap_or_default()
    };
    Ok(ReplayBenchReport {
        vehicles: args.vehicles,
        minutes: args.minutes,
        bytes: recording.bytes(),
        open_ms,
        timeline_ms,
        jump_ms: [at(0.5), at(0.99), at(1.0)],
        through_ms,
        jump_ratio: at(0.5) / through_ms,
    })
}

fn ms(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

async fn looked_at(path: &Path, vehicles: u16) -> Result<(f64, f64, Vec<f64>), BenchError> {
    let failed = |error: ReplayError| of_recording(error);
    let begun = Instant::now();
    let replay = Replay::open(path).map_err(failed)?;
    let to = |position_s| ReplayChange {
        position_s: Some(position_s),
        ..ReplayChange::default()
    };
    replay.change(to(0.0)).await.map_err(failed)?;
    let open_ms = ms(begun);
    while !replay.timeline().complete {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    let timeline_ms = ms(begun);
    let duration_s = replay.state().duration_s;
    let mut jumps_ms = Vec::new();
    for jump in 0..JUMPS {
        // Spread over the flight, each far from the one before.
        let position_s = (jump * 83 % JUMPS) as f64 / JUMPS as f64 * duration_s;
        let begun = Instant::now();
        replay.change(to(position_s)).await.map_err(failed)?;
        jumps_ms.push(ms(begun));
        let shown = replay.node().snapshot().vehicles.len();
        if shown != usize::from(vehicles) {
            return Err(of_recording(format!("{shown} vehicles at {position_s} s")));
        }
    }
    Ok((open_ms, timeline_ms, jumps_ms))
}

/// Records it as a node does: thinned to what is recorded by default, a chunk each second.
fn record(args: ReplayBenchArgs, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let base = TimeBase {
        node: NodeTime(0),
        unix_ns: 1_795_860_000_000_000_000,
    };
    let header = Header {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        node: None,
        name: "bench".to_owned(),
        swarm: String::new(),
        base,
    };
    let mut writer = Writer::create(path, header)?;
    let mut fleet = fleet(args.vehicles)?;
    for second in 0..args.minutes * 60 {
        for tick in 0..TELEMETRY {
            let after_s = f64::from(second) + f64::from(tick) / f64::from(TELEMETRY);
            let at = NodeTime::from_seconds(after_s);
            moved(&mut fleet, after_s);
            let mut messages = Vec::new();
            if tick == 0 {
                if second.is_multiple_of(2) {
                    messages.push(Encoded::json(Topic::Fleet, at, &fleet)?);
                }
                let unix_ns = base.unix_ns(at);
                for vehicle in &fleet.vehicles {
                    let location = scene::location(vehicle, unix_ns);
                    messages
                        .extend(location.map(|location| Encoded::theirs(Topic::Location(vehicle.id), at, &location)));
                }
                messages.push(Encoded::theirs(Topic::Scene, at, &scene::scene(&fleet, unix_ns)));
                messages.extend(happened(second, at, args.vehicles)?);
            }
            for vehicle in &fleet.vehicles {
                let telemetry = VehicleTelemetry::of(vehicle, at);
                messages.push(Encoded::json(Topic::Telemetry(vehicle.id), at, &telemetry)?);
                if tick.is_multiple_of(2) {
                    messages.push(Encoded::json(Topic::Setpoint(vehicle.id), at, &setpoint(vehicle, at))?);
                }
            }
            let unix_ns = base.unix_ns(at);
            messages.push(Encoded::theirs(
                Topic::Transforms,
                at,
                &scene::transforms(&fleet, unix_ns),
            ));
            for message in &messages {
                writer.write(message, at)?;
            }
        }
        writer.flush()?;
    }
    writer.finish()?;
    Ok(())
}

/// Something every ten seconds.
fn happened(second: u32, at: NodeTime, vehicles: u16) -> Result<Option<Encoded>, serde_json::Error> {
    if !second.is_multiple_of(10) {
        return Ok(None);
    }
    let vehicle = VehicleId(1 + (second / 10 % u32::from(vehicles)) as u16);
    let event = EventRecord {
        seq: u64::from(second / 10 + 1),
        time: at,
        node: None,
        vehicle: Some(vehicle),
        severity: if second.is_multiple_of(60) {
            Severity::Warning
        } else {
            Severity::Info
        },
        kind: EventKind::Notice,
        text: format!("uav-{vehicle}: something happened in second {second}"),
    };
    Encoded::json(Topic::Events, at, &event).map(Some)
}

fn fleet(vehicles: u16) -> Result<FleetSnapshot, serde_json::Error> {
    let made = (1..=vehicles).map(|id| {
        serde_json::from_value::<VehicleSnapshot>(json!({
            "id": id, "node": null, "name": format!("uav-{id}"), "simulated": true, "system_id": id, "plugin": "generic-uav",
            "plugin_version": "0.1.0", "flight_state": "following", "state_detail": "", "mode": "offboard", "armed": true,
            "landed": "in_air", "ready_to_arm": true, "global": ORIGIN, "kinematics": skein_domain::telemetry::VehicleKinematics::default(),
            "roll_rad": 0.0, "pitch_rad": 0.0, "home": ORIGIN, "battery": { "remaining": 0.8, "voltage_v": 15.2, "current_a": 11.5 },
            "gnss": skein_domain::Gnss::default(), "link": skein_domain::LinkHealth { connected: true, ..Default::default() },
            "age_s": 0.02, "slot": null, "tracking_error_m": 0.2, "is_leader": id == 1,
            "actor": skein_view::ActorHealth::default(), "model": skein_view::PluginHealth::default(), "model_state": null,
            "avoiding": null, "failsafe": null, "energy": null, "stopped": false, "limits": null, "capability": null,
            "payloads": [], "degraded": [],
        }))
    });
    Ok(FleetSnapshot {
        frame: Some(SwarmFrame::new(ORIGIN)),
        vehicles: made.collect::<Result<_, _>>()?,
        ..FleetSnapshot::default()
    })
}

/// Each on a circle of its own, at its own height.
fn moved(fleet: &mut FleetSnapshot, after_s: f64) {
    let at = NodeTime::from_seconds(after_s);
    fleet.time = at;
    let frame = fleet.frame;
    for vehicle in &mut fleet.vehicles {
        let number = f64::from(vehicle.id.0);
        let (sin, cos) = (after_s * 0.1 + number).sin_cos();
        let place = PositionNed::new((20.0 + 3.0 * number) * cos, (20.0 + 3.0 * number) * sin, -10.0 - number);
        if let Some(kinematics) = &mut vehicle.kinematics {
            kinematics.position = place;
            kinematics.velocity = VelocityNed::new(-3.0 * sin, 3.0 * cos, 0.0);
            kinematics.yaw_rad = (after_s * 0.1).sin();
            kinematics.measured = at;
        }
        vehicle.global = frame.map(|frame| frame.geodetic(&place));
        vehicle.slot = Some(place);
        vehicle.link.last_heard = at;
    }
}

fn setpoint(vehicle: &VehicleSnapshot, at: NodeTime) -> SetpointRecord {
    let asked = Setpoint {
        position: vehicle.slot,
        velocity: vehicle.kinematics.map(|now| now.velocity),
        ..Setpoint::default()
    };
    SetpointRecord {
        time: at,
        vehicle: vehicle.id,
        peers: None,
        gate: 0,
        asked,
        flown: Some(asked),
        slowed: None,
        refusal: None,
        change: None,
    }
    .thinned()
}
