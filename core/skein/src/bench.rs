//! `skein bench`: hands over to the bench library, which measures this program from outside, as its own child processes.

use crate::args::Bench;
use serde::Serialize;
use skein_bench::{
    AssignmentBenchArgs, BusBenchArgs, FleetBenchArgs, ReplayBenchArgs, Ros2BenchArgs, SwarmBenchArgs, VideoBenchArgs,
    VisionBenchArgs, run_assignment_bench, run_bus_bench, run_fleet_bench, run_replay_bench, run_ros2_bench,
    run_swarm_bench, run_video_bench, run_vision_bench,
};
use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;

/// The benches make their own runtimes: each measures one of its own.
///
/// # Errors
/// When something cannot be measured.
pub fn bench(what: Bench) -> anyhow::Result<ExitCode> {
    match what {
        Bench::Fleet {
            vehicles,
            seconds,
            json,
        } => fleet(vehicles, seconds, json),
        Bench::Assignment { python, json } => assignment(python, json),
        Bench::Replay {
            vehicles,
            minutes,
            json,
        } => replay(vehicles, minutes, json),
        Bench::Swarm { vehicles, json } => swarm(vehicles, json),
        Bench::Bus { nodes, seconds, json } => bus(nodes, seconds, json),
        Bench::Ros2 { python, seconds, json } => ros2(python, seconds, json),
        Bench::Video { ffmpeg, seconds, json } => video(ffmpeg, seconds, json),
        Bench::Vision {
            clips,
            python,
            ffmpeg,
            models,
            json,
        } => vision(clips, (python, ffmpeg, models), json),
        Bench::VideoViewer { settings } => video_viewer(&settings),
        Bench::LoadGenerator { settings } => load_generator(&settings),
        Bench::BareLoop { settings } => bare_loop(&settings),
    }
}

/// The whole program against a load generator, beside a bare loop.
///
/// # Errors
/// When a child process cannot be started or does not come up.
pub fn fleet(vehicles: u8, seconds: u32, json: bool) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let report = run_fleet_bench(&FleetBenchArgs::new(u16::from(vehicles), seconds, program))?;
    show(&report, json)
}

/// Assignments of vehicles to slots, beside SciPy's.
///
/// # Errors
/// When Python cannot be started or lacks SciPy, or when the two sides' totals differ.
pub fn assignment(python: PathBuf, json: bool) -> anyhow::Result<ExitCode> {
    let report = run_assignment_bench(&AssignmentBenchArgs { python })?;
    show(&report, json)
}

/// A whole swarm's decisions in one process.
///
/// # Errors
/// When the swarm's formation cannot be planned.
pub fn swarm(vehicles: u16, json: bool) -> anyhow::Result<ExitCode> {
    let report = run_swarm_bench(&SwarmBenchArgs::new(usize::from(vehicles)))?;
    show(&report, json)
}

/// A long recording looked at again.
///
/// # Errors
/// When it cannot be written or read.
pub fn replay(vehicles: u16, minutes: u32, json: bool) -> anyhow::Result<ExitCode> {
    let report = run_replay_bench(ReplayBenchArgs { vehicles, minutes })?;
    show(&report, json)
}

/// The swarm's bus over each of its transports.
///
/// # Errors
/// When a transport does not open, or its nodes do not find each other.
pub fn bus(nodes: u16, seconds: u32, json: bool) -> anyhow::Result<ExitCode> {
    let report = run_bus_bench(&BusBenchArgs { nodes, seconds })?;
    show(&report, json)
}

/// Latencies through ROS 2 and DDS, and what ROS 2 takes.
///
/// # Errors
/// When a child process cannot be started, ends, or does not find the others.
pub fn ros2(python: PathBuf, seconds: u32, json: bool) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let report = run_ros2_bench(&Ros2BenchArgs::new(python, seconds, program))?;
    show(&report, json)
}

/// Live video relayed, beside FFmpeg.
///
/// # Errors
/// When a child process cannot be started, ends, or shows no picture.
pub fn video(ffmpeg: PathBuf, seconds: u32, json: bool) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let report = run_video_bench(&VideoBenchArgs::new(ffmpeg, seconds, program))?;
    show(&report, json)
}

/// What a detector takes, beside FFmpeg and onnxruntime. The programs are Python and FFmpeg, and the folder that of the models.
///
/// # Errors
/// When a child process cannot be started, or says something else than it should.
pub fn vision(
    clips: PathBuf,
    (python, ffmpeg, models): (PathBuf, PathBuf, PathBuf),
    json: bool,
) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let report = run_vision_bench(&VisionBenchArgs {
        program,
        python,
        ffmpeg,
        clips,
        models,
    })?;
    show(&report, json)
}

/// A viewer of live video, as its own process.
///
/// # Errors
/// When its settings do not parse.
pub fn video_viewer(settings: &str) -> anyhow::Result<ExitCode> {
    Ok(skein_bench::run_video_viewer(settings).map(|()| ExitCode::SUCCESS)?)
}

/// As JSON, or for a person.
fn show<R: Serialize + Display>(report: &R, json: bool) -> anyhow::Result<ExitCode> {
    let text = if json {
        serde_json::to_string_pretty(report)?
    } else {
        report.to_string()
    };
    println!("{}", text.trim_end());
    Ok(ExitCode::SUCCESS)
}

/// The load generator, as its own process.
///
/// # Errors
/// When its settings do not parse or a socket cannot be bound.
pub fn load_generator(settings: &str) -> anyhow::Result<ExitCode> {
    Ok(skein_bench::run_load_generator(settings).map(|()| ExitCode::SUCCESS)?)
}

/// The bare loop, as its own process.
///
/// # Errors
/// When its settings do not parse or its socket cannot be bound.
pub fn bare_loop(settings: &str) -> anyhow::Result<ExitCode> {
    Ok(skein_bench::run_bare_loop(settings).map(|()| ExitCode::SUCCESS)?)
}
