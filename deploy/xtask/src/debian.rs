//! Installs packages through apt-get, where that is possible: on Debian and its like, as root.
//!
//! Must never do: add a source of packages.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::{Command, Stdio};

/// Installs a package.
pub fn install(package: &str) -> Result<()> {
    if !Path::new("/usr/bin/apt-get").exists() {
        bail!("there is no apt-get on this system");
    }
    apt(&["update", "-qq"])?;
    apt(&["install", "-y", "-qq", "--no-install-recommends", package])
}

fn apt(arguments: &[&str]) -> Result<()> {
    let mut command = Command::new("apt-get");
    command
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        .stdout(Stdio::null());
    let status = command.status().context("cannot start apt-get")?;
    if status.success() {
        Ok(())
    } else {
        bail!("apt-get {} failed (is this user root?)", arguments.join(" "))
    }
}
