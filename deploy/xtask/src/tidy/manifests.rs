//! Rules about manifests: names that follow from the path, dependencies that a role rules out, shared lints.

use super::{File, Finding};
use crate::workspace::{Package, Workspace};

/// What a pure crate or the ABI may depend on besides crates of ours. Longer lists need a reason in review, not a rule.
const ALLOWED: [(&str, &[&str]); 6] = [
    (
        "core/coordination",
        &["nalgebra", "parking_lot", "schemars", "serde", "ts-rs"],
    ),
    (
        "core/domain",
        &["minicbor", "nalgebra", "schemars", "serde", "thiserror", "ts-rs"],
    ),
    ("core/failover", &["minicbor", "serde", "thiserror"]),
    (
        "core/flight",
        &[
            "minicbor",
            "nalgebra",
            "pathfinding",
            "serde",
            "serde_json",
            "thiserror",
        ],
    ),
    ("core/safety", &["nalgebra", "serde", "thiserror"]),
    ("core/plugin-abi", &[]),
];

/// Every rule about manifests but the order of the crates.
pub fn check(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in &workspace.packages {
        let path = format!("{}/Cargo.toml", package.folder);
        let mut broken = |rule, what: String| findings.push(Finding::of(&path, rule, what));
        if let Some(name) = wanted_name(&package.folder).filter(|name| *name != package.name) {
            broken("crate-name", format!("is {}; by its folder it is {name}", package.name));
        }
        if let Some(what) = forbidden(workspace, package) {
            broken("dependencies", what);
        }
        for name in unused(package, files) {
            broken("dependencies", format!("depends on {name}, which no file here names"));
        }
        if let Some(file) = tests_that_never_run(package, files) {
            broken("test", format!("says `test = false`, and {file} has tests"));
        }
        let manifest = files.iter().find(|file| file.path == path);
        if !manifest.is_some_and(|file| file.text.contains("[lints]\nworkspace = true")) {
            broken("lints", "add `[lints]` with `workspace = true`".to_owned());
        }
    }
    findings
}

/// Dependencies whose names stand in no file of the package.
fn unused<'p>(package: &'p Package, files: &[File]) -> Vec<&'p str> {
    let beside = format!("{}/", package.folder);
    let own: Vec<&File> = files
        .iter()
        .filter(|file| file.is("rs") && file.path.starts_with(&beside))
        .collect();
    let names = package.dependencies.iter().map(|on| on.name.as_str());
    let is_named = |name: &str| {
        let word = name.replace('-', "_");
        own.iter().any(|file| file.text.contains(&word))
    };
    names.filter(|name| !is_named(name)).collect()
}

/// A file with tests of a library whose manifest says that it has none.
fn tests_that_never_run<'f>(package: &Package, files: &'f [File]) -> Option<&'f str> {
    let is_library = |kind: &String| kind.ends_with("lib");
    let library = package
        .targets
        .iter()
        .find(|target| target.kind.iter().any(is_library))?;
    let beside = format!("{}/src/", package.folder);
    let mut own = files.iter().filter(|file| file.path.starts_with(&beside));
    let with_tests = own.find(|file| file.text.lines().any(|line| line.trim() == "#[cfg(test)]"));
    with_tests.filter(|_| !library.test).map(|file| file.path.as_str())
}

/// Path = name = role.
pub fn wanted_name(folder: &str) -> Option<String> {
    let parts: Vec<&str> = folder.split('/').collect();
    match *parts.as_slice() {
        ["core", "skein"] => Some("skein".to_owned()),
        ["core", name] | ["tests", name @ ("testkit" | "bench" | "seeded")] => Some(format!("skein-{name}")),
        ["tests", name] => Some(format!("skein-tests-{name}")),
        ["tests", _, "fixtures", name] => Some(format!("fixture-{name}")),
        ["plugins", name] | ["deploy", name] => Some(name.to_owned()),
        ["plugins", name, "cdylib"] => Some(format!("{name}-plugin")),
        _ => None,
    }
}

fn forbidden(workspace: &Workspace, package: &Package) -> Option<String> {
    let mut ships = package.dependencies.iter().filter(|on| on.ships());
    let may_use_anyhow = ["core/skein", "core/demo"].contains(&package.folder.as_str())
        || ["tests/", "deploy/"].iter().any(|f| package.folder.starts_with(f));
    if !may_use_anyhow && ships.clone().any(|on| on.name == "anyhow") {
        return Some("depends on anyhow: errors here are typed facts (thiserror)".to_owned());
    }
    let (_, allowed) = ALLOWED.iter().find(|(folder, _)| *folder == package.folder)?;
    let stranger = ships.find(|on| workspace.package(&on.name).is_none() && !allowed.contains(&on.name.as_str()))?;
    Some(format!(
        "depends on {}, which a crate without effects does not need (list in tidy/manifests.rs)",
        stranger.name
    ))
}
