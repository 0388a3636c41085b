//! Programs of Debian packages, taken out of the package without installing it: no service is started, nothing on the system changes.
//!
//! Must never do: install a package; add a source of packages.

use anyhow::{Context, Result, bail, ensure};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A program by its name: the system's, if it has one, else the one of a Debian package, which is downloaded once, into `tests/.debian-<package>`.
///
/// # Errors
/// When it is not there and cannot be downloaded: on other systems than Debian and its like.
pub fn program_of(package: &str, name: &str) -> Result<PathBuf> {
    if let Some(installed) = on_path(name) {
        return Ok(installed);
    }
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the crate lies in tests/")?;
    let folder = tests.join(format!(".debian-{package}"));
    let program = folder.join("usr/bin").join(name);
    // Several tests may come here at once, in one process or in many.
    let lock = File::create(tests.join(format!(".debian-{package}.lock"))).context("cannot create the lock")?;
    lock.lock().context("cannot lock the folder of the package")?;
    if !program.exists() {
        unpack(package, &folder).with_context(|| format!("{name} is needed: install the package {package}"))?;
    }
    ensure!(program.exists(), "the package {package} has no program {name}");
    Ok(program)
}

fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|program| program.is_file())
}

fn unpack(package: &str, folder: &Path) -> Result<()> {
    crate::say(&format!(
        "taking the Debian package {package} apart in {}",
        folder.display()
    ));
    let download = tempfile::tempdir().context("cannot make a folder")?;
    let fetch = || {
        run(Command::new("apt-get")
            .args(["download", "-qq", package])
            .current_dir(download.path()))
    };
    if fetch().is_err() {
        // The lists of packages may be missing or too old.
        run(Command::new("apt-get").args(["update", "-qq"]))?;
        fetch()?;
    }
    let files = fs::read_dir(download.path())?.collect::<Result<Vec<_>, _>>()?;
    let [file] = files.as_slice() else {
        bail!("apt-get downloaded {} files", files.len());
    };
    // Only what is whole gets the name under which it is used again.
    let begun = PathBuf::from(format!("{}.begun", folder.display()));
    if begun.exists() {
        fs::remove_dir_all(&begun)?;
    }
    run(Command::new("dpkg-deb").arg("-x").arg(file.path()).arg(&begun))?;
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::rename(&begun, folder).context("cannot name the folder")
}

fn run(command: &mut Command) -> Result<()> {
    let output = command.stdin(Stdio::null()).output();
    let output = output.with_context(|| format!("cannot run {command:?}"))?;
    if !output.status.success() {
        bail!("{command:?} failed:\n{}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(())
}
