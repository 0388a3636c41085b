//! What a compose file gives a container, given to a program here: a control group with so much memory and so much of a processor.
//!
//! Must never do: stay behind. The group ends with its value.

use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Memory of a node, in bytes.
pub(super) const MEMORY_BYTES: u64 = 256 << 20;
/// Share of one core that a node gets, in microseconds of each [`PERIOD_US`].
const PROCESSOR_US: u64 = 50_000;
/// The period of that.
const PERIOD_US: u64 = 100_000;

/// Where the system has its groups.
const GROUPS: &str = "/sys/fs/cgroup";
/// The name of ours.
const NAME: &str = "skein-images";
/// Joins the groups that come first, and becomes what comes after `--`.
const JOIN: &str = r#"while [ "$1" != -- ]; do echo $$ > "$1/cgroup.procs"; shift; done; shift; exec "$@""#;

/// A control group; of version 1, one for each of the two resources.
pub(super) struct Limits(Vec<PathBuf>);

impl Limits {
    /// Makes it. It needs root.
    pub(super) fn new() -> Result<Self> {
        let top = Path::new(GROUPS);
        let cpu = format!("{PROCESSOR_US} {PERIOD_US}");
        let memory = MEMORY_BYTES.to_string();
        if top.join("cgroup.controllers").exists() {
            std::fs::write(top.join("cgroup.subtree_control"), "+memory +cpu").context("memory and cpu")?;
            return Ok(Self(vec![group(
                top.join(NAME),
                &[("memory.max", &memory), ("memory.swap.max", "0"), ("cpu.max", &cpu)],
            )?]));
        }
        let period = ("cpu.cfs_period_us", PERIOD_US.to_string());
        let quota = ("cpu.cfs_quota_us", PROCESSOR_US.to_string());
        Ok(Self(vec![
            group(top.join("memory").join(NAME), &[("memory.limit_in_bytes", &memory)])?,
            group(
                top.join("cpu").join(NAME),
                &[(period.0, &period.1), (quota.0, &quota.1)],
            )?,
        ]))
    }

    /// The same command, in the group from its start.
    pub(super) fn within(&self, command: &Command) -> Command {
        let mut joined = Command::new("/bin/sh");
        joined.args(["-ec", JOIN, "sh"]).args(&self.0).arg("--");
        joined.arg(command.get_program()).args(command.get_args());
        for (key, value) in command.get_envs() {
            match value {
                Some(value) => joined.env(key, value),
                None => joined.env_remove(key),
            };
        }
        joined
    }
}

impl Drop for Limits {
    fn drop(&mut self) {
        for folder in &self.0 {
            if let Err(error) = std::fs::remove_dir(folder) {
                eprintln!("{}: {error}", folder.display());
            }
        }
    }
}

fn group(folder: PathBuf, limits: &[(&str, &str)]) -> Result<PathBuf> {
    if !folder.exists() {
        std::fs::create_dir(&folder).with_context(|| format!("{}: no group can be made", folder.display()))?;
    }
    for (limit, value) in limits {
        let file = folder.join(limit);
        ensure!(file.exists(), "{}: the system has no such limit", file.display());
        std::fs::write(&file, value).with_context(|| file.display().to_string())?;
    }
    Ok(folder)
}
