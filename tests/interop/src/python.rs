//! The Python environment `tests/.venv-mavsdk`: made once, used again as long as the pinned versions stay the same.

use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is installed, pinned.
pub const REQUIREMENTS: &[&str] = &["mavsdk==4.1.0", "pymavlink==2.4.50"];

/// The environment's Python; makes the environment if there is none with these versions.
///
/// # Errors
/// When Python 3 or its `venv` module is missing, or a package cannot be installed.
pub fn python() -> Result<PathBuf> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the crate lies in tests/")?;
    let environment = tests.join(".venv-mavsdk");
    let interpreter = environment.join("bin/python");
    let marker = environment.join("requirements.installed");
    let wanted = REQUIREMENTS.join("\n");
    // Several tests may come here at once, in one process or in many.
    let lock = File::create(tests.join(".venv-mavsdk.lock")).context("cannot create the lock of the environment")?;
    lock.lock().context("cannot lock the environment")?;
    if fs::read_to_string(&marker).is_ok_and(|found| found == wanted) && works(&interpreter) {
        return Ok(interpreter);
    }
    crate::say(&format!(
        "making the Python environment {} with {REQUIREMENTS:?}",
        environment.display()
    ));
    if environment.exists() {
        fs::remove_dir_all(&environment).context("cannot remove the outdated Python environment")?;
    }
    run(Command::new("python3").args(["-m", "venv"]).arg(&environment))
        .context("python3 with its venv module is needed")?;
    run(Command::new(&interpreter)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
        .args(REQUIREMENTS))?;
    fs::write(&marker, wanted).context("cannot note the installed versions")?;
    Ok(interpreter)
}

/// Whether both packages can be imported.
fn works(interpreter: &Path) -> bool {
    Command::new(interpreter)
        .args(["-c", "import mavsdk, pymavlink"])
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
