//! Rules about documents: the map names every member, links lead somewhere, commands exist, no words of process.

use super::{File, Finding};
use crate::workspace::Workspace;
use clap::CommandFactory;
use std::path::Path;

/// Words about how the work is organised; they mean nothing to a reader. Put together here so that this file passes.
const OF_PROCESS: [&str; 5] = [
    concat!("mile", "stone"),
    concat!("issue", " #"),
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("X", "XX"),
];
/// What is read for such words.
const READ: [&str; 14] = [
    "rs", "md", "toml", "ts", "svelte", "mjs", "js", "css", "html", "py", "sh", "yml", "yaml", "service",
];

/// Words of process in one file.
pub fn words(file: &File) -> Vec<Finding> {
    if !READ.iter().any(|extension| file.is(extension)) {
        return Vec::new();
    }
    let named = |line: &str| OF_PROCESS.iter().find(|word| holds(line, word)).copied();
    file.text
        .lines()
        .enumerate()
        .filter_map(|(index, line)| Some((index + 1, named(line)?)))
        .map(|(number, word)| {
            file.finding(
                number,
                "words",
                format!("`{word}`: say what is, not what is planned or by whom"),
            )
        })
        .collect()
}

/// Capitals stand for themselves; the other words are found in any case.
fn holds(line: &str, word: &str) -> bool {
    if word.chars().any(char::is_lowercase) {
        line.to_lowercase().contains(word)
    } else {
        line.contains(word)
    }
}

/// Rules over all documents.
pub fn check(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let mut findings = map_of_the_code(workspace, files);
    let commands: Vec<String> = crate::Arguments::command()
        .get_subcommands()
        .map(|command| command.get_name().to_owned())
        .collect();
    for file in files.iter().filter(|file| file.is("md")) {
        findings.extend(links(&workspace.root, file));
        findings.extend(commands_exist(file, &commands));
    }
    findings
}

fn map_of_the_code(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let map = files.iter().find(|file| file.path == "ARCHITECTURE.md");
    let text = map.map_or("", |file| file.text.as_str());
    let named = |folder: &str| text.contains(&format!("`{folder}`"));
    let missing = workspace.packages.iter().filter(|package| !named(&package.folder));
    missing
        .map(|package| Finding {
            path: "ARCHITECTURE.md".to_owned(),
            line: 0,
            rule: "map",
            what: format!("does not name the member `{}`", package.folder),
        })
        .collect()
}

/// A relative link leads to something that is there.
fn links(root: &Path, file: &File) -> Vec<Finding> {
    let folder = Path::new(&file.path).parent().unwrap_or(Path::new(""));
    let mut findings = Vec::new();
    for (index, line) in file.text.lines().enumerate() {
        for target in line.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = target.split('#').next().unwrap_or(target);
            let elsewhere = target.is_empty() || target.contains("://") || target.starts_with("mailto:");
            if !elsewhere && !root.join(folder).join(target).exists() {
                findings.push(file.finding(index + 1, "links", format!("leads to {target}, which is not there")));
            }
        }
    }
    findings
}

/// A command that a document names is one that there is.
pub fn commands_exist(file: &File, commands: &[String]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in file.text.lines().enumerate() {
        for rest in line.split("cargo xtask ").skip(1) {
            let name: String = rest
                .chars()
                .take_while(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || *c == '-')
                .collect();
            if !name.is_empty() && !commands.contains(&name) {
                findings.push(file.finding(
                    index + 1,
                    "commands",
                    format!("names `cargo xtask {name}`, which there is not"),
                ));
            }
        }
    }
    findings
}
