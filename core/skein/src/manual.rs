//! What shells and `man` know of the program, made from the command line itself.
//!
//! Must never do: say anything that `--help` does not.

use crate::args::Arguments;
use anyhow::Context;
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::Path;
use std::process::ExitCode;

/// Prints the completions of a shell.
#[must_use]
pub fn completions(shell: Shell) -> ExitCode {
    clap_complete::generate(shell, &mut Arguments::command(), "skein", &mut std::io::stdout());
    ExitCode::SUCCESS
}

/// Writes `skein.1` and a page for each command.
///
/// # Errors
/// The directory cannot be written to.
pub fn man_pages(directory: &Path) -> anyhow::Result<()> {
    let written = clap_mangen::generate_to(Arguments::command(), directory);
    written.with_context(|| format!("cannot write man pages to {}", directory.display()))?;
    println!(
        "The pages are in {}. Read them by `man -l {}`.",
        directory.display(),
        directory.join("skein.1").display()
    );
    Ok(())
}
