//! `fast`: the checks for the crates that changed, and those that use them; about a minute when warm.
//!
//! Must never do: check something that `test` does not.

#[cfg(test)]
mod tests;

use crate::artifacts::{self, is_tier_or_fixture};
use crate::report::Report;
use crate::step::Step;
use crate::tally::Runner;
use crate::tidy;
use crate::workspace::{Dependency, Package, Workspace};
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
    let concerned = with_dependants(workspace, &changed);
    println!("{} files changed since {base}: {}", files.len(), list(&changed));
    println!("checked with those that use them: {}", list(&concerned));

    let mut report = Report::new();
    let mut format = workspace.cargo();
    format.args(["fmt", "--all", "--check"]);
    report.step("formatting", "run `cargo fmt --all`", Step::new(format));
    report.check("tidy", "each finding says what to do", || tidy::check(workspace));
    // cargo itself knows what is fresh: only what changed, and what uses it, is looked at again
    let mut lints = workspace.cargo();
    lints.args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]);
    report.step("clippy", "mend what clippy names above", Step::new(lints));
    unit_tests(workspace, &mut report, &concerned);
    Ok(report.close())
}

/// Runs the test programs of the crates concerned, each in its crate's folder as cargo does.
fn unit_tests(workspace: &Workspace, report: &mut Report, concerned: &BTreeSet<&str>) {
    let tested = |folder: &str| {
        let package = workspace.packages.iter().find(|package| package.folder == folder);
        package.is_some_and(|package| concerned.contains(package.name.as_str()) && !is_tier_or_fixture(folder))
    };
    let mut programs = Vec::new();
    report.check("tests built", "mend the compile error above", || {
        let mut build = workspace.cargo();
        build
            .args(["test", "--no-run"])
            .args(artifacts::unit_targets(workspace));
        let made = artifacts::build(workspace, build)?;
        let tests = made
            .into_iter()
            .filter(|artifact| artifact.is_test && tested(&artifact.folder));
        programs = tests
            .filter_map(|artifact| Some((artifact.folder, artifact.executable?)))
            .collect();
        Ok(())
    });
    if programs.is_empty() {
        report.left_out("unit tests", "no crate with unit tests is concerned");
    }
    for (folder, program) in programs {
        let mut tests = Command::new(program);
        let home = workspace.root.join(&folder);
        tests.current_dir(&home).env("CARGO_MANIFEST_DIR", &home);
        let advice = "the failing tests are named above";
        report.step(
            &format!("unit: {folder}"),
            advice,
            Step::perhaps_tests(tests, Runner::CargoTest),
        );
    }
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

/// What a crate is built from concerns whatever is built from the crate; what only its tests use concerns these alone.
fn with_dependants<'w>(workspace: &'w Workspace, changed: &BTreeSet<&'w str>) -> BTreeSet<&'w str> {
    let users = |of: &BTreeSet<&str>, tests_too: bool| -> Vec<&'w str> {
        let uses = |package: &&'w Package| {
            let on = |on: &Dependency| (tests_too || on.ships()) && of.contains(on.name.as_str());
            !of.contains(package.name.as_str()) && package.dependencies.iter().any(on)
        };
        let packages = workspace.packages.iter().filter(uses);
        packages.map(|package| package.name.as_str()).collect()
    };
    let mut concerned = changed.clone();
    loop {
        let more = users(&concerned, false);
        if more.is_empty() {
            break;
        }
        concerned.extend(more);
    }
    let tested = users(&concerned, true);
    concerned.extend(tested);
    concerned
}

fn list(names: &BTreeSet<&str>) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.iter().copied().collect::<Vec<_>>().join(", ")
    }
}
