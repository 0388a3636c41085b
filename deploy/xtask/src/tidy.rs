//! `tidy`: the habits of the house that neither rustc nor clippy can check. Runs by command and as a test.
//!
//! Must never do: pass an exception that `tidy-exceptions.toml` does not name with its reason, or keep one that is not needed.

mod documents;
mod exceptions;
mod layers;
mod manifests;
mod modules;
mod retired;
mod sources;
#[cfg(test)]
mod tests;
mod tiers;

use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::fmt;
use std::process::ExitCode;

/// One breach of one rule.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// Where, relative to the root.
    path: String,
    /// Line, from 1; 0 if it is about the whole file.
    line: usize,
    /// Short name of the rule, as in the exceptions.
    rule: &'static str,
    /// What is wrong and what to do.
    what: String,
}

impl Finding {
    /// About a whole file.
    fn of(path: impl Into<String>, rule: &'static str, what: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            line: 0,
            rule,
            what: what.into(),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = if self.line == 0 {
            String::new()
        } else {
            format!(":{}", self.line)
        };
        write!(f, "{}{line}: {} [{}]", self.path, self.what, self.rule)
    }
}

/// A text file of the repository.
pub struct File {
    /// Path relative to the root, with `/` between its parts.
    path: String,
    /// Its content.
    text: String,
}

impl File {
    /// Whether the path ends in that extension.
    fn is(&self, extension: &str) -> bool {
        self.path
            .strip_suffix(extension)
            .is_some_and(|rest| rest.ends_with('.'))
    }

    fn finding(&self, line: usize, rule: &'static str, what: impl Into<String>) -> Finding {
        Finding {
            line,
            ..Finding::of(&self.path, rule, what)
        }
    }
}

/// The `tidy` command.
pub fn run(workspace: &Workspace) -> Result<ExitCode> {
    check(workspace)?;
    println!("tidy");
    Ok(ExitCode::SUCCESS)
}

/// Checks every rule; an error if one is broken. Prints findings and notes.
pub fn check(workspace: &Workspace) -> Result<()> {
    let files = files(workspace)?;
    let mut findings = BTreeSet::new();
    for file in &files {
        findings.extend(sources::check(file));
        findings.extend(documents::words(file));
        findings.extend(retired::check(file));
    }
    findings.extend(sources::crate_roots(workspace, &files));
    findings.extend(sources::shims(&files));
    findings.extend(sources::messages(&files));
    findings.extend(manifests::check(workspace, &files));
    findings.extend(layers::check(workspace));
    findings.extend(modules::check(workspace, &files));
    findings.extend(modules::undeclared(&files));
    findings.extend(tiers::check(workspace));
    findings.extend(documents::check(workspace, &files));
    let findings = exceptions::apply(&workspace.root, findings)?;
    sources::long_files(&files)
        .iter()
        .for_each(|note| println!("note: {note}"));
    findings.iter().for_each(|finding| println!("{finding}"));
    ensure!(findings.is_empty(), "{} findings", findings.len());
    Ok(())
}

/// Checks the rules about documents alone; an error if one is broken.
pub fn check_documents(workspace: &Workspace) -> Result<()> {
    let findings = documents::check(workspace, &files(workspace)?);
    findings.iter().for_each(|finding| println!("{finding}"));
    ensure!(findings.is_empty(), "{} findings", findings.len());
    Ok(())
}

/// Packages with a block of code in their documentation: only these are asked for examples that run, since each asked costs a second.
pub fn with_examples(workspace: &Workspace) -> Result<Vec<&str>> {
    let files = files(workspace)?;
    let is_fence = |line: &str| {
        ["/// ```", "//! ```"]
            .iter()
            .any(|fence| line.trim().starts_with(fence))
    };
    let with_fence: Vec<&str> = (files.iter())
        .filter(|file| file.is("rs") && file.text.lines().any(is_fence))
        .map(|file| file.path.as_str())
        .collect();
    let has = |folder: &str| {
        with_fence
            .iter()
            .any(|path| path.starts_with(&format!("{folder}/src/")))
    };
    let packages = workspace.packages.iter().filter(|package| has(&package.folder));
    Ok(packages.map(|package| package.name.as_str()).collect())
}

/// Folders that builds and tests make. The list follows `.gitignore`; git itself may be missing where this runs.
const MADE: [&str; 6] = ["target", "node_modules", "dist", "test-results", "corpus", "artifacts"];

/// Every text file of the repository.
fn files(workspace: &Workspace) -> Result<Vec<File>> {
    let mut files = Vec::new();
    let mut folders = vec![workspace.root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let hidden = name.starts_with('.') && name != ".ci" && name != ".cargo";
            if path.is_dir() {
                if !hidden && !MADE.contains(&name.as_ref()) && path != workspace.target {
                    folders.push(path);
                }
            } else if let Ok(text) = std::fs::read_to_string(&path) {
                let path = path
                    .strip_prefix(&workspace.root)
                    .unwrap_or(&path)
                    .to_string_lossy()
                    .replace('\\', "/");
                files.push(File { path, text });
            }
        }
    }
    files.sort_by(|one, other| one.path.cmp(&other.path));
    Ok(files)
}
