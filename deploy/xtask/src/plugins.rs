//! Compiles the plugin libraries and puts them where the program looks for them: `plugins/` beside the binary.
//!
//! Must never do: overwrite a library in place, since a running program may have it mapped.

use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Which cargo profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// `dev`, in `debug/`.
    Dev,
    /// `release`.
    Release,
}

impl Profile {
    /// From a `--release` flag.
    pub fn from_release(release: bool) -> Self {
        if release { Self::Release } else { Self::Dev }
    }

    /// The folder under the build directory.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Dev => "debug",
            Self::Release => "release",
        }
    }

    /// The arguments cargo needs for it.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::Dev => &[],
            Self::Release => &["--release"],
        }
    }
}

/// One line of cargo's machine-readable output, as far as it matters here.
#[derive(Deserialize)]
struct Message {
    reason: String,
    #[serde(default)]
    filenames: Vec<PathBuf>,
    #[serde(default)]
    package_id: String,
}

/// Builds every plugin of the workspace and returns the folder they are in.
pub fn build(workspace: &Workspace, profile: Profile) -> Result<PathBuf> {
    let names: Vec<&str> = workspace
        .packages
        .iter()
        .filter(|p| p.is_plugin_library())
        .map(|p| p.name.as_str())
        .collect();
    ensure!(!names.is_empty(), "no member under plugins/*/cdylib builds a cdylib");
    println!("building plugins: {}", names.join(", "));
    let mut command = workspace.cargo();
    command
        .args(["build", "--message-format", "json-render-diagnostics"])
        .args(profile.arguments());
    names.iter().for_each(|name| {
        command.args(["-p", name]);
    });
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .context("cannot start cargo")?;
    ensure!(
        output.status.success(),
        "the plugins do not compile: see the messages above"
    );

    let folder = workspace.target.join(profile.folder()).join("plugins");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755))?;
    let mut placed = BTreeSet::new();
    for library in libraries(&output.stdout, &names) {
        let name = library.file_name().context("a library has a file name")?.to_owned();
        place(&library, &folder.join(&name))?;
        placed.insert(name);
    }
    ensure!(
        placed.len() == names.len(),
        "cargo built {} libraries for {} plugins",
        placed.len(),
        names.len()
    );
    remove_others(&folder, &placed)?;
    Ok(folder)
}

fn libraries(messages: &[u8], names: &[&str]) -> Vec<PathBuf> {
    let lines = messages.split(|byte| *byte == b'\n');
    let artifacts = lines.filter_map(|line| serde_json::from_slice::<Message>(line).ok());
    let ours = artifacts.filter(|m| m.reason == "compiler-artifact" && names.iter().any(|n| m.package_id.contains(n)));
    ours.flat_map(|message| message.filenames)
        .filter(|file| file.extension().is_some_and(|e| e == "so"))
        .collect()
}

/// Copies beside the final place and renames, so that whoever has the old file open keeps it whole.
fn place(from: &Path, to: &Path) -> Result<()> {
    let staged = to.with_extension("so.new");
    fs::copy(from, &staged).with_context(|| format!("cannot copy {} to {}", from.display(), staged.display()))?;
    fs::set_permissions(&staged, fs::Permissions::from_mode(0o644))?;
    fs::rename(&staged, to).with_context(|| format!("cannot put {} in its place", to.display()))
}

/// A library of a plugin that was renamed or removed would still be loaded.
fn remove_others(folder: &Path, placed: &BTreeSet<OsString>) -> Result<()> {
    for entry in fs::read_dir(folder)?.flatten() {
        let stale = entry.path().extension().is_some_and(|e| e == "so") && !placed.contains(&entry.file_name());
        if stale {
            println!(
                "removing {}: no plugin of the workspace builds it",
                entry.path().display()
            );
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}
