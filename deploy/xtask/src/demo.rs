//! `demo`: from source to a flying swarm in one command.
//!
//! Must never do: fly something else than what `skein demo` flies.

use crate::plugins::{self, Profile};
use crate::ui;
use crate::workspace::Workspace;
use anyhow::{Context, Result};
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

/// Builds everything and becomes `skein demo`, so that Ctrl-C and the exit code are the program's own.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<ExitCode> {
    build(workspace)?;
    let binary = workspace.target.join("release/skein");
    println!("flying: {} demo {}", binary.display(), arguments.join(" "));
    let error = Command::new(&binary).arg("demo").args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", binary.display()))
}

/// Dashboard, program and plugins, optimised. The dashboard first: the program embeds it.
pub fn build(workspace: &Workspace) -> Result<()> {
    println!("[1/2] dashboard");
    ui::build(workspace)?;
    println!("[2/2] program and plugins (the first build takes ten to twenty minutes on two cores)");
    plugins::build_with(workspace, Profile::Release, &["skein"])?;
    Ok(())
}
