//! Which tests run in which tier: cargo selects tests by name alone, so that one name in two tiers would run both in each; and a name that no
//! test program has would leave one in the wrong tier.

use super::Finding;
use crate::artifacts::is_tier_or_fixture;
use crate::workspace::{Package, Workspace};
use std::collections::BTreeMap;

/// Names every test file of an ordinary crate that has the name of a tier's, and every name of a test in real time that nothing has.
pub fn check(workspace: &Workspace) -> Vec<Finding> {
    let (tiers, others): (Vec<_>, Vec<_>) = workspace
        .packages
        .iter()
        .partition(|package| is_tier_or_fixture(&package.folder));
    let taken: BTreeMap<&str, &Package> = tiers
        .into_iter()
        .flat_map(|package| tests(package).map(move |name| (name, package)))
        .collect();
    let mut findings = Vec::new();
    for package in others {
        let alike = tests(package).filter_map(|name| taken.get(name).map(|tier| finding(package, name, tier)));
        findings.extend(alike);
        let unknown = package
            .in_real_time
            .iter()
            .filter(|name| !tests(package).any(|test| test == *name));
        findings.extend(unknown.map(|name| {
            let what = format!("`in-real-time` names {name}, and no test program has that name");
            Finding::of(format!("{}/Cargo.toml", package.folder), "tiers", what)
        }));
    }
    findings
}

fn tests(package: &Package) -> impl Iterator<Item = &str> {
    let tests = package
        .targets
        .iter()
        .filter(|target| target.kind.iter().any(|kind| kind == "test"));
    tests.map(|target| target.name.as_str())
}

fn finding(package: &Package, name: &str, tier: &Package) -> Finding {
    let what = format!(
        "{} has a test of this name too: call it otherwise, or both run in both tiers",
        tier.folder
    );
    Finding::of(format!("{}/tests/{name}.rs", package.folder), "tiers", what)
}
