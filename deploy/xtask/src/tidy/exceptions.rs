//! The one list of exceptions, each with its reason.

use super::Finding;
use anyhow::{Context, Result};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;

/// Where the list is, relative to the root.
const LIST: &str = "deploy/xtask/tidy-exceptions.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(default)]
    exception: Vec<Exception>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Exception {
    rule: String,
    path: String,
    reason: String,
}

/// Takes away what is excepted, and adds what is wrong with the list itself.
pub fn apply(root: &Path, findings: BTreeSet<Finding>) -> Result<Vec<Finding>> {
    let text = std::fs::read_to_string(root.join(LIST)).with_context(|| format!("cannot read {LIST}"))?;
    without(&text, findings)
}

/// As [`apply`], on a list's text.
pub fn without(list: &str, findings: BTreeSet<Finding>) -> Result<Vec<Finding>> {
    let list: List = toml::from_str(list).with_context(|| format!("{LIST} is not as expected"))?;
    let mut left: Vec<Finding> = findings.into_iter().collect();
    for exception in &list.exception {
        let before = left.len();
        left.retain(|finding| !(finding.rule == exception.rule && finding.path == exception.path));
        let complaint = |what: String| Finding::of(LIST, "exceptions", what);
        if left.len() == before {
            let what = format!(
                "the exception from {} for {} is not needed any more",
                exception.rule, exception.path
            );
            left.push(complaint(what));
        } else if exception.reason.split_whitespace().count() < 4 {
            left.push(complaint(format!(
                "say why {} is excepted from {}",
                exception.path, exception.rule
            )));
        }
    }
    Ok(left)
}
