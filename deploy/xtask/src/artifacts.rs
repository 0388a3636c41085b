//! What a build made, as cargo tells it, and the targets that belong together.
//!
//! All builds of a test run select the whole workspace, and narrow it by target instead of by package: cargo unites the features of
//! what is selected, so another selection would compile half of the dependencies a second time.
//!
//! Must never do: guess a file name that cargo can tell.

use crate::workspace::{Package, Workspace};
use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// One target of a member that was built, or was there already.
#[derive(Debug, Clone)]
pub struct Artifact {
    /// Folder of its package, as in [`Package::folder`].
    pub folder: String,
    /// Name of the target.
    pub name: String,
    /// `lib`, `bin`, `cdylib`, `test`, …
    pub kind: Vec<String>,
    /// The files.
    pub files: Vec<PathBuf>,
    /// Whether it holds tests.
    pub is_test: bool,
    /// The program that runs them, or that it is.
    pub executable: Option<PathBuf>,
}

#[derive(Deserialize)]
struct Message {
    reason: String,
    manifest_path: Option<PathBuf>,
    target: Option<MessageTarget>,
    profile: Option<MessageProfile>,
    #[serde(default)]
    filenames: Vec<PathBuf>,
    executable: Option<PathBuf>,
}

#[derive(Deserialize)]
struct MessageTarget {
    name: String,
    kind: Vec<String>,
}

#[derive(Deserialize)]
struct MessageProfile {
    test: bool,
}

/// Runs a cargo build and returns what it made of the workspace's members. Its messages are shown.
pub fn build(workspace: &Workspace, mut command: Command) -> Result<Vec<Artifact>> {
    command.args(["--message-format", "json-render-diagnostics"]);
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let output = output.context("cannot start cargo")?;
    ensure!(output.status.success(), "it does not compile: see the messages above");
    let lines = output.stdout.split(|byte| *byte == b'\n');
    let messages = lines.filter_map(|line| serde_json::from_slice::<Message>(line).ok());
    Ok(messages.filter_map(|message| message.artifact(workspace)).collect())
}

impl Message {
    fn artifact(self, workspace: &Workspace) -> Option<Artifact> {
        if self.reason != "compiler-artifact" {
            return None;
        }
        let folder = self
            .manifest_path?
            .parent()?
            .strip_prefix(&workspace.root)
            .ok()?
            .to_path_buf();
        let target = self.target?;
        Some(Artifact {
            folder: folder.to_string_lossy().replace('\\', "/"),
            name: target.name,
            kind: target.kind,
            files: self.filenames,
            is_test: self.profile?.test,
            executable: self.executable,
        })
    }
}

/// The arguments of the builds that make what the tests run and load, one after the other. The examples that measure or draw something are left
/// out unless the run is a whole one: nothing loads them. The tests of tiers say `test = false`: cargo builds these only where they are named,
/// and not beside `--tests`.
pub fn builds(workspace: &Workspace, whole: bool, tiers: &[&Package]) -> Vec<Vec<String>> {
    let of = |selected: &[&str]| -> Vec<String> { selected.iter().map(|argument| (*argument).to_owned()).collect() };
    let tests = if whole { "--all-targets" } else { "--tests" };
    let everything = of(&["--workspace"]);
    let mut first = [everything.clone(), of(&["--lib", "--bins", tests])].concat();
    let loaded = workspace.packages.iter().filter(|package| has_loaded_examples(package));
    first.extend(loaded.flat_map(|package| targets(package, "example")));
    let named: Vec<String> = tiers.iter().flat_map(|package| targets(package, "test")).collect();
    if named.is_empty() {
        return vec![first];
    }
    vec![first, [everything, named].concat()]
}

fn has_loaded_examples(package: &Package) -> bool {
    package.folder.contains("/fixtures/") || package.folder == "core/plugin-host"
}

/// The arguments that name the package's targets of a kind: `test`, `example`.
fn targets(package: &Package, kind: &'static str) -> impl Iterator<Item = String> {
    let of_kind = package
        .targets
        .iter()
        .filter(move |target| target.kind.iter().any(|of| of == kind));
    of_kind.flat_map(move |target| [format!("--{kind}"), target.name.clone()])
}

/// Whether a package's folder is a tier of its own (or a fixture of one) and so no part of the unit tier.
pub fn is_tier_or_fixture(folder: &str) -> bool {
    folder.starts_with("tests/") && folder != "tests/testkit" && folder != "tests/bench"
}
