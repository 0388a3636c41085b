//! `demo`: from source to a flying swarm in one command.
//!
//! Must never do: fly something else than what `skein demo` flies.

use crate::plugins::{self, Profile};
use crate::ui;
use crate::workspace::Workspace;
use anyhow::{Context, Result};
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

/// The scenario in which vehicles detect others in their pictures.
const DETECTS: &str = "observe";
/// The plugin that does it. Its runtime for models is the largest library of all.
const DETECTOR: &str = "detector-plugin";

/// Builds what is flown and becomes `skein demo`, so that Ctrl-C and the exit code are the program's own.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    build_for(workspace, arguments)?;
    let binary = workspace.target.join("release/skein");
    println!("flying: {} demo {}", binary.display(), arguments.join(" "));
    let error = Command::new(&binary).arg("demo").args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", binary.display()))
}

/// Dashboard, program and plugins, optimised, with everything. The dashboard first: the program embeds it.
pub fn build(workspace: &Workspace) -> Result<()> {
    dashboard(workspace)?;
    program("ten to fifteen");
    plugins::build_with(workspace, Profile::Release, &["skein"])?;
    Ok(())
}

/// What these arguments of the demonstration fly with, which is built in less time: no Zenoh, no benches, and the detector only where it looks.
pub fn build_for(workspace: &Workspace, arguments: &[String]) -> Result<()> {
    dashboard(workspace)?;
    program("eight to twelve");
    let detects = arguments.iter().any(|argument| argument.contains(DETECTS));
    let without: &[&str] = if detects { &[] } else { &[DETECTOR] };
    plugins::build_lean(workspace, "skein", without)
}

fn dashboard(workspace: &Workspace) -> Result<()> {
    println!("[1/2] dashboard");
    ui::build(workspace)
}

fn program(minutes: &str) {
    println!("[2/2] program and plugins (the first build takes {minutes} minutes on two cores)");
}
