//! `demo`: from source to a flying swarm in one command.
//!
//! Must never do: fly something else than what `skein demo` flies.

use crate::plugins::{self, Profile};
use crate::step::Step;
use crate::tally::Tally;
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

/// Dashboard, plugins and program, optimised. The dashboard first: the program embeds it.
pub fn build(workspace: &Workspace) -> Result<()> {
    println!("[1/3] dashboard");
    ui::build(workspace)?;
    println!("[2/3] plugins");
    plugins::build(workspace, Profile::Release)?;
    println!("[3/3] program (the first build takes some minutes)");
    let mut build = workspace.cargo();
    build.args(["build", "--release", "-p", "skein"]);
    Step::new(build)
        .run(&mut Tally::default())
        .context("the program does not compile: see the messages above")
}
