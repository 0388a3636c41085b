//! `fast`: lints of the workspace, tests of the crates that changed; about a minute when warm. Tests of the crates that use them are left to
//! `test`: compiling these takes several minutes.
//!
//! Must never do: check something that `test` does not.

#[cfg(test)]
mod tests;

use crate::artifacts::is_tier_or_fixture;
use crate::report::Report;
use crate::step::Step;
use crate::tally::Runner;
use crate::workspace::Workspace;
use crate::{lints, tidy, ui};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, ExitCode};

/// Files at the root that concern every crate.
const CONCERN_ALL: [&str; 4] = ["Cargo.toml", "Cargo.lock", "rust-toolchain.toml", "clippy.toml"];

/// Runs the checks.
pub fn run(workspace: &Workspace, since: Option<&str>) -> Result<ExitCode> {
    let base = base(workspace, since)?;
    let files = changed_files(workspace, &base)?;
    let changed = changed_packages(workspace, &files);
    println!("{} files changed since {base}: {}", files.len(), list(&changed));

    let mut report = Report::new();
    let mut format = workspace.cargo();
    format.args(["fmt", "--all", "--check"]);
    report.step("formatting", "run `cargo fmt --all`", Step::new(format));
    report.check("tidy", "each finding says what to do", || tidy::check(workspace));
    // cargo itself knows what is fresh: only what changed, and what uses it, is looked at again
    lints::check(workspace, &mut report);
    unit_tests(workspace, &mut report, &changed);
    if files.iter().any(|file| file.starts_with("web-ui/")) {
        dashboard(workspace, &mut report);
    }
    Ok(report.close())
}

/// The tests of these crates alone. The members without tests of their own are named too, though nothing of them is built: with them cargo
/// takes the features of the whole workspace, and what `test` has compiled is not compiled once more with fewer.
fn unit_tests(workspace: &Workspace, report: &mut Report, changed: &BTreeSet<&str>) {
    let (tested, untested): (Vec<_>, Vec<_>) = workspace
        .packages
        .iter()
        .partition(|package| package.targets.iter().any(|target| target.test));
    let selected: Vec<_> = tested
        .into_iter()
        .filter(|package| changed.contains(package.name.as_str()) && !is_tier_or_fixture(&package.folder))
        .collect();
    if selected.is_empty() {
        report.left_out("unit tests", "no crate with unit tests has changed");
        return;
    }
    let mut tests = workspace.cargo();
    tests
        .arg("test")
        .args(
            selected
                .iter()
                .chain(&untested)
                .flat_map(|package| ["--package", &package.name]),
        )
        .args(["--tests", "--no-fail-fast", "--", "--test-threads", "4"]);
    let tests = Step::perhaps_tests(tests, Runner::CargoTest);
    report.step("unit tests", "the failing tests are named above", tests);
}

fn dashboard(workspace: &Workspace, report: &mut Report) {
    report.check("dashboard: packages", "is Node there, and the network?", || {
        ui::install(workspace)
    });
    let types = Step::new(ui::npm(workspace, &["run", "check"]));
    report.step("dashboard: types", "run `npm run check` in web-ui", types);
    let tests = Step::tests(ui::npm(workspace, &["run", "test"]), Runner::Vitest);
    report.step("dashboard: tests", "run `npm test` in web-ui", tests);
}

/// Where this branch left main; on main itself, the last commit.
fn base(workspace: &Workspace, since: Option<&str>) -> Result<String> {
    let wanted = match since {
        Some(revision) => git(workspace, &["rev-parse", "--verify", revision])?,
        None => git(workspace, &["merge-base", "HEAD", "main"]).or_else(|_| git(workspace, &["rev-parse", "HEAD"]))?,
    };
    Ok(wanted.trim().chars().take(12).collect())
}

fn changed_files(workspace: &Workspace, base: &str) -> Result<Vec<String>> {
    let tracked = git(workspace, &["diff", "--name-only", base])?;
    let new = git(workspace, &["ls-files", "--others", "--exclude-standard"])?;
    Ok(tracked.lines().chain(new.lines()).map(str::to_owned).collect())
}

fn git(workspace: &Workspace, arguments: &[&str]) -> Result<String> {
    let output = Command::new("git")
        .current_dir(&workspace.root)
        .args(arguments)
        .output()
        .context("cannot start git")?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success(),
        "git {}: {}",
        arguments.join(" "),
        complaint.trim()
    );
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn changed_packages<'w>(workspace: &'w Workspace, files: &[String]) -> BTreeSet<&'w str> {
    if files.iter().any(|file| CONCERN_ALL.contains(&file.as_str())) {
        return workspace.packages.iter().map(|package| package.name.as_str()).collect();
    }
    files.iter().filter_map(|file| owner(workspace, file)).collect()
}

/// The member whose folder holds the file; the innermost, since plugins hold their library's folder.
fn owner<'w>(workspace: &'w Workspace, file: &str) -> Option<&'w str> {
    let holders = workspace
        .packages
        .iter()
        .filter(|package| Path::new(file).starts_with(&package.folder));
    holders
        .max_by_key(|package| package.folder.len())
        .map(|package| package.name.as_str())
}

fn list(names: &BTreeSet<&str>) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.iter().copied().collect::<Vec<_>>().join(", ")
    }
}
