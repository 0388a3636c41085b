//! Python environments `tests/.venv-*`: made once, used again as long as the pinned versions stay the same.

use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// One environment: packages that are used together.
#[derive(Debug)]
pub struct Environment {
    /// Part of its folder's name.
    pub name: &'static str,
    /// What is installed, pinned.
    pub requirements: &'static [&'static str],
    /// What must be there then.
    pub modules: &'static str,
}

/// Clients of MAVLink.
pub const MAVSDK: Environment = Environment {
    name: "mavsdk",
    requirements: &["mavsdk==4.1.0", "pymavlink==2.4.50"],
    modules: "mavsdk, pymavlink",
};

/// DDS beside ROS 2.
pub const CYCLONE: Environment = Environment {
    name: "cyclonedds",
    requirements: &["cyclonedds==11.0.1"],
    modules: "cyclonedds.domain",
};

/// The configuration of Cyclone DDS (its `CYCLONEDDS_URI`) by which it uses loopback alone and finds others without multicast.
pub const CYCLONE_ON_LOOPBACK: &str = r#"<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"#;

/// The Python of the environment for MAVLink; see [`python_of`].
///
/// # Errors
/// As there.
pub fn python() -> Result<PathBuf> {
    python_of(&MAVSDK)
}

/// The environment's Python; makes the environment if there is none with these versions.
///
/// # Errors
/// When Python 3 or its `venv` module is missing, or a package cannot be installed.
pub fn python_of(wanted: &Environment) -> Result<PathBuf> {
    let Environment { name, requirements, .. } = wanted;
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the crate lies in tests/")?;
    let environment = tests.join(format!(".venv-{name}"));
    let interpreter = environment.join("bin/python");
    let marker = environment.join("requirements.installed");
    let pinned = requirements.join("\n");
    // Several tests may come here at once, in one process or in many.
    let lock =
        File::create(tests.join(format!(".venv-{name}.lock"))).context("cannot create the lock of the environment")?;
    lock.lock().context("cannot lock the environment")?;
    if fs::read_to_string(&marker).is_ok_and(|found| found == pinned) && works(&interpreter, wanted.modules) {
        return Ok(interpreter);
    }
    crate::say(&format!(
        "making the Python environment {} with {requirements:?}",
        environment.display()
    ));
    if environment.exists() {
        fs::remove_dir_all(&environment).context("cannot remove the outdated Python environment")?;
    }
    run(Command::new("python3").args(["-m", "venv"]).arg(&environment))
        .context("python3 with its venv module is needed")?;
    run(Command::new(&interpreter)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
        .args(*requirements))?;
    fs::write(&marker, pinned).context("cannot note the installed versions")?;
    Ok(interpreter)
}

/// Whether the modules can be imported.
fn works(interpreter: &Path, modules: &str) -> bool {
    Command::new(interpreter)
        .args(["-c", &format!("import {modules}")])
        .status()
        .is_ok_and(|status| status.success())
}

fn run(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot run {command:?}"))?;
    if !output.status.success() {
        bail!("{command:?} failed:\n{}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(())
}
