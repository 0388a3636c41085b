//! `bench`: what the program takes, each figure beside something plain that is measured in the same run: a bare loop that only
//! receives, parses and sends; distances of all pairs; SciPy's assignments; rclpy beside rclpy.
//!
//! Must never do: judge. It prints figures; the tests hold the limits.

use crate::workspace::Workspace;
use crate::{browser, demo, ui};
use anyhow::{Context, Result, ensure};
use skein_tests_interop::Ros2;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// How many vehicles the decisions of a whole swarm are measured for.
const SWARMS: [&str; 2] = ["200", "1000"];

/// The first argument that asks for the figures of ROS 2 alone.
const ROS2: &str = "ros2";
/// The first argument that asks for those of live video alone.
const VIDEO: &str = "video";

/// Builds the release program, measures a call into a plugin, a swarm's decisions, its bus, assignments, ROS 2 and the dashboard, and becomes
/// `skein bench fleet`. With `ros2` or `video` first it measures that alone, and what follows goes on to `skein bench ros2` or `video`.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    demo::build(workspace)?;
    if let Some((_, arguments)) = arguments.split_first().filter(|(first, _)| *first == ROS2) {
        let python = Ros2::jazzy()?.python();
        ros2(&workspace.target.join("release/skein"), &python, arguments)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some((_, arguments)) = arguments.split_first().filter(|(first, _)| *first == VIDEO) {
        video(workspace, &workspace.target.join("release/skein"), arguments)?;
        return Ok(ExitCode::SUCCESS);
    }
    let built = workspace
        .cargo()
        .args(["build", "--release", "-p", "bench-echo"])
        .status()?;
    ensure!(built.success(), "bench-echo was not built");
    let binary = workspace.target.join("release/skein");
    measure(&binary, &["plugin", "bench"])?;
    for vehicles in SWARMS {
        measure(&binary, &["bench", "swarm", "--vehicles", vehicles])?;
    }
    measure(&binary, &["bench", "bus"])?;
    measure(&binary, &["bench", "replay"])?;
    match scipy(&workspace.target) {
        Ok(python) => {
            let python = python.to_string_lossy();
            measure(&binary, &["bench", "assignment", "--python", &python])?;
        }
        Err(error) => println!("no assignments beside SciPy's: {error:#}"),
    }
    match Ros2::jazzy() {
        Ok(found) => ros2(&binary, &found.python(), &[])?,
        Err(error) => println!("no figures of ROS 2: {error:#}"),
    }
    ui(workspace, &binary, "bench")?;
    match Command::new("ffmpeg").arg("-version").output() {
        Ok(_) => video(workspace, &binary, &[])?,
        Err(error) => println!("no figures of video: ffmpeg: {error}"),
    }
    let error = Command::new(&binary).args(["bench", "fleet"]).args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", binary.display()))
}

/// The dashboard in a real browser, fed by the program; left out where there is no browser.
fn ui(workspace: &Workspace, binary: &Path, script: &str) -> Result<()> {
    let chromium = match browser::chromium() {
        Ok(found) => found,
        Err(error) => {
            println!("no figures of the dashboard: {error:#}");
            return Ok(());
        }
    };
    let measured = ui::npm(workspace, &["run", script])
        .env("SKEIN_BINARY", binary)
        .env(browser::VARIABLE, chromium)
        .status()?;
    ensure!(measured.success(), "the dashboard could not be measured: see above");
    Ok(())
}

/// Relayed beside FFmpeg; then from glass to glass in a real browser.
fn video(workspace: &Workspace, binary: &Path, arguments: &[String]) -> Result<()> {
    let more = arguments.iter().map(String::as_str);
    let all: Vec<&str> = ["bench", VIDEO].into_iter().chain(more).collect();
    measure(binary, &all)?;
    ui(workspace, binary, "bench:video")
}

/// Between rclpy programs and through Skein.
fn ros2(binary: &Path, python: &Path, arguments: &[String]) -> Result<()> {
    let python = python.to_string_lossy();
    let more = arguments.iter().map(String::as_str);
    let all: Vec<&str> = ["bench", ROS2, "--python", &python].into_iter().chain(more).collect();
    measure(binary, &all)
}

fn measure(binary: &Path, arguments: &[&str]) -> Result<()> {
    let measured = Command::new(binary).args(arguments).status()?;
    ensure!(measured.success(), "skein {} failed", arguments.join(" "));
    Ok(())
}

/// A Python with SciPy, in a virtual environment within the build directory.
fn scipy(target: &Path) -> Result<PathBuf> {
    let folder = target.join("bench-python");
    let python = folder.join("bin/python");
    let works = || {
        let asked = Command::new(&python)
            .args(["-c", "import numpy, scipy.optimize"])
            .output();
        asked.is_ok_and(|answer| answer.status.success())
    };
    if works() {
        return Ok(python);
    }
    println!("installing SciPy into {}", folder.display());
    let made = Command::new("python3").args(["-m", "venv"]).arg(&folder).status();
    let made = made.context("cannot start python3")?;
    ensure!(made.success(), "python3 cannot make a virtual environment");
    let installed = Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "scipy", "numpy"])
        .status();
    let installed = installed.context("cannot start pip")?;
    ensure!(installed.success() && works(), "pip cannot install SciPy");
    Ok(python)
}
