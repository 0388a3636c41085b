//! `fast`: the checks for the crates that changed, and those that use them; about a minute when warm.
//!
//! Must never do: check something that `test` does not.

#[cfg(test)]
mod tests;

use crate::report::Report;
use crate::step::Step;
use crate::tally::Runner;
use crate::tidy;
use crate::workspace::Workspace;
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
    if !concerned.is_empty() {
        let mut lints = workspace.cargo();
        lints.arg("clippy").args(concerned.iter().flat_map(|name| ["-p", name]));
        lints.args(["--all-targets", "--", "-D", "warnings"]);
        report.step("clippy", "mend what clippy names above", Step::new(lints));
    }
    let tested: Vec<&str> = concerned
        .iter()
        .copied()
        .filter(|name| {
            workspace
                .package(name)
                .is_some_and(|package| !is_tier_or_fixture(&package.folder))
        })
        .collect();
    if tested.is_empty() {
        report.left_out("tests", "no crate with unit tests is concerned");
    } else {
        let mut tests = workspace.cargo();
        tests.arg("test").args(tested.iter().flat_map(|name| ["-p", name]));
        tests.args(["--lib", "--bins", "--tests", "--no-fail-fast"]);
        report.step(
            "unit tests",
            "the failing tests are named above",
            Step::tests(tests, Runner::CargoTest),
        );
    }
    Ok(report.close())
}

/// Whether a package's folder is a tier of its own (or a fixture of one) and so no part of the unit tier.
pub fn is_tier_or_fixture(folder: &str) -> bool {
    folder.starts_with("tests/") && folder != "tests/testkit" && folder != "tests/bench"
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

fn with_dependants<'w>(workspace: &'w Workspace, changed: &BTreeSet<&'w str>) -> BTreeSet<&'w str> {
    let mut concerned = changed.clone();
    loop {
        let more: Vec<&str> = workspace
            .packages
            .iter()
            .filter(|package| {
                package
                    .dependencies
                    .iter()
                    .any(|on| concerned.contains(on.name.as_str()))
            })
            .map(|package| package.name.as_str())
            .filter(|name| !concerned.contains(name))
            .collect();
        if more.is_empty() {
            return concerned;
        }
        concerned.extend(more);
    }
}

fn list(names: &BTreeSet<&str>) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.iter().copied().collect::<Vec<_>>().join(", ")
    }
}
