//! Compiles the plugin libraries and puts them where the program looks for them: `plugins/` beside the binary.
//!
//! Must never do: overwrite a library in place, since a running program may have it mapped.

use crate::artifacts::{self, Artifact};
use crate::packages::Architecture;
use crate::workspace::{Package, Workspace};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What of the release profile is another for what is shipped, from the root.
const SMALLER: &str = "deploy/debian/smaller.toml";

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

/// Builds every plugin of the workspace and returns the folder they are in.
pub fn build(workspace: &Workspace, profile: Profile) -> Result<PathBuf> {
    build_with(workspace, profile, &[])
}

/// As [`build`], together with other packages, so that what they share is compiled once.
pub fn build_with(workspace: &Workspace, profile: Profile, others: &[&str]) -> Result<PathBuf> {
    let command = of_all(workspace, profile, others, &[])?;
    let made = artifacts::build(workspace, command)?;
    collect(workspace, profile, &made)
}

/// A program without its default features, and the plugins without some: those that are there already stay.
pub fn build_lean(workspace: &Workspace, program: &str, without: &[&str]) -> Result<()> {
    let mut command = of_all(workspace, Profile::Release, &[program], without)?;
    command.arg("--no-default-features");
    let made = artifacts::build(workspace, command)?;
    let folder = workspace.target.join(Profile::Release.folder()).join("plugins");
    collect_into(workspace, &folder, &made, without)?;
    Ok(())
}

/// Program and plugins for a package. For another computer than this one if `cross` says so.
pub fn build_to_ship(workspace: &Workspace, cross: Option<Architecture>) -> Result<PathBuf> {
    let mut command = of_all(workspace, Profile::Release, &["skein"], &[])?;
    command.arg("--config").arg(workspace.root.join(SMALLER));
    let mut folder = workspace.target.clone();
    if let Some(architecture) = cross {
        command
            .args(["--target", architecture.triple()])
            .envs(architecture.environment());
        folder.push(architecture.triple());
    }
    let made = artifacts::build(workspace, command)?;
    collect_into(workspace, &folder.join("release/plugins"), &made, &[])
}

/// The cargo command that builds every plugin but for some, and other packages.
fn of_all(workspace: &Workspace, profile: Profile, others: &[&str], without: &[&str]) -> Result<Command> {
    let plugins = members(workspace).map(|package| package.name.as_str());
    let plugins = plugins.filter(|name| !without.contains(name));
    let names: Vec<&str> = plugins.chain(others.iter().copied()).collect();
    let compiler = std::env::var_os("CXX").unwrap_or_else(|| "c++".into());
    ensure!(
        Command::new(&compiler)
            .arg("--version")
            .output()
            .is_ok_and(|output| output.status.success()),
        "the camera plugin's video decoder is built with a C++ compiler, and {} does not run: install one (Debian: apt install g++)",
        compiler.to_string_lossy()
    );
    println!("building {}", names.join(", "));
    let mut command = workspace.cargo();
    command
        .arg("build")
        .args(profile.arguments())
        .args(names.iter().flat_map(|name| ["-p", name]));
    Ok(command)
}

/// Puts the plugin libraries among `made` into the folder, takes others out of it, and returns it.
pub fn collect(workspace: &Workspace, profile: Profile, made: &[Artifact]) -> Result<PathBuf> {
    collect_into(
        workspace,
        &workspace.target.join(profile.folder()).join("plugins"),
        made,
        &[],
    )
}

fn collect_into(workspace: &Workspace, folder: &Path, made: &[Artifact], without: &[&str]) -> Result<PathBuf> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    fs::set_permissions(folder, fs::Permissions::from_mode(0o755))?;
    let mut placed = BTreeSet::new();
    for package in members(workspace) {
        if without.contains(&package.name.as_str()) {
            placed.insert(format!("lib{}.so", package.name.replace('-', "_")).into());
            continue;
        }
        let library = library(package, made)?;
        let name = library.file_name().context("a library has a file name")?.to_owned();
        place(library, &folder.join(&name))?;
        placed.insert(name);
    }
    ensure!(!placed.is_empty(), "no member under plugins/*/cdylib builds a cdylib");
    remove_others(folder, &placed)?;
    Ok(folder.to_path_buf())
}

fn members(workspace: &Workspace) -> impl Iterator<Item = &Package> {
    workspace.packages.iter().filter(|package| package.is_plugin_library())
}

fn library<'m>(package: &Package, made: &'m [Artifact]) -> Result<&'m PathBuf> {
    let ours = made
        .iter()
        .filter(|artifact| artifact.folder == package.folder && !artifact.is_test);
    let libraries = ours.filter(|artifact| artifact.kind.iter().any(|kind| kind == "cdylib"));
    let mut files = libraries.flat_map(|artifact| &artifact.files);
    let library = files.find(|file| file.extension().is_some_and(|extension| extension == "so"));
    library.with_context(|| format!("cargo built no shared library of {}", package.name))
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
