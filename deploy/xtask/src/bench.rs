//! `bench`: the whole program beside a bare loop that only receives, parses and sends, in one run.
//!
//! Must never do: judge. It prints figures; the tests hold the limits.

use crate::demo;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

/// Builds the release program, measures a call into a plugin and a swarm's decisions, and becomes `skein bench fleet`.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    demo::build(workspace)?;
    let built = workspace
        .cargo()
        .args(["build", "--release", "-p", "bench-echo"])
        .status()?;
    ensure!(built.success(), "bench-echo was not built");
    let binary = workspace.target.join("release/skein");
    let measured = Command::new(&binary).args(["plugin", "bench"]).status()?;
    ensure!(measured.success(), "skein plugin bench failed");
    let measured = Command::new(&binary).args(["bench", "swarm"]).status()?;
    ensure!(measured.success(), "skein bench swarm failed");
    let error = Command::new(&binary).args(["bench", "fleet"]).args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", binary.display()))
}
