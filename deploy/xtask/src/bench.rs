//! `bench`: the whole program beside a bare loop that only receives, parses and sends, in one run.
//!
//! Must never do: judge. It prints figures; the tests hold the limits.

use crate::demo;
use crate::workspace::Workspace;
use anyhow::{Context, Result};
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

/// Builds the release program and becomes `skein bench fleet`.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    demo::build(workspace)?;
    let binary = workspace.target.join("release/skein");
    let error = Command::new(&binary).args(["bench", "fleet"]).args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", binary.display()))
}
