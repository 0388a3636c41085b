//! Rules about documents: the map names every member, links and their anchors lead somewhere, the site has every page, commands and names of
//! ROS 2 exist, no words of process.
//!
//! Must never do: look at other hosts.

use super::{File, Finding};
use crate::docs::links::{self, anchors, folder, include, resolved};
use crate::docs::{GENERATED, PAGES, SUMMARY, pages};
use crate::workspace::Workspace;
use clap::CommandFactory;
use std::collections::BTreeMap;
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
    let documents: Vec<&File> = files.iter().filter(|file| file.is("md")).collect();
    let whole: BTreeMap<&str, String> = documents
        .iter()
        .map(|file| {
            let text = pages::whole(&workspace.root, &file.path);
            (file.path.as_str(), text.unwrap_or_else(|_| file.text.clone()))
        })
        .collect();
    for file in documents {
        findings.extend(leads(&workspace.root, file, &whole));
        findings.extend(commands_exist(file, &commands));
    }
    findings.extend(site(files));
    findings.extend(ros2_names(files));
    findings
}

fn map_of_the_code(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let map = files.iter().find(|file| file.path == "ARCHITECTURE.md");
    let text = map.map_or("", |file| file.text.as_str());
    let named = |folder: &str| text.contains(&format!("`{folder}`"));
    let missing = workspace.packages.iter().filter(|package| !named(&package.folder));
    missing
        .map(|package| {
            let what = format!("does not name the member `{}`", package.folder);
            Finding::of("ARCHITECTURE.md", "map", what)
        })
        .collect()
}

/// A relative link leads to something that is there, and to a heading that is in it; what is included is there.
pub fn leads(root: &Path, file: &File, whole: &BTreeMap<&str, String>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in file.text.lines().enumerate() {
        if let Some(path) = include(line).map(|path| resolved(folder(&file.path), path))
            && !root.join(&path).is_file()
        {
            findings.push(file.finding(index + 1, "links", format!("includes {path}, which is not there")));
        }
    }
    for link in links::of(&file.text) {
        let path = match link.path {
            "" => file.path.clone(),
            path => resolved(folder(&file.path), path),
        };
        // Elsewhere than on the site a generated page is not there: only the summary leads to it.
        if file.path == SUMMARY && is_generated(&path) {
            continue;
        }
        if !root.join(&path).exists() {
            findings.push(file.finding(link.line, "links", format!("leads to {path}, which is not there")));
        } else if let (Some(anchor), Some(text)) = (link.anchor, whole.get(path.as_str()))
            && !anchors(text).iter().any(|known| known == anchor)
        {
            let what = format!("leads to the heading #{anchor} of {path}, which is not there");
            findings.push(file.finding(link.line, "links", what));
        }
    }
    findings
}

fn is_generated(path: &str) -> bool {
    path.strip_prefix(PAGES)
        .is_some_and(|page| GENERATED.contains(&page.trim_start_matches('/')))
}

/// The summary of the site names every page of it, and every page that is generated.
pub fn site(files: &[File]) -> Vec<Finding> {
    let Some(summary) = files.iter().find(|file| file.path == SUMMARY) else {
        return Vec::new();
    };
    let named: Vec<&str> = links::of(&summary.text).iter().map(|link| link.path).collect();
    let written = files.iter().filter(|file| file.is("md") && file.path != SUMMARY);
    let pages = written.filter_map(|file| Some(file.path.strip_prefix(PAGES)?.trim_start_matches('/')));
    let missing = pages.chain(GENERATED).filter(|page| !named.contains(page));
    missing
        .map(|page| summary.finding(0, "site", format!("does not name the page {page}")))
        .collect()
}

/// Where topics and services of ROS 2 are made, and the calls whose first text is a name.
const ROS2_SOURCES: [&str; 3] = [
    "core/ros2/src/services/commands.rs",
    "core/ros2/src/swarm.rs",
    "core/ros2/src/vehicle.rs",
];
const ROS2_CALLS: [&str; 5] = [
    "place.voice(",
    "place.ear::<",
    "place.server::<",
    "let topic = format!(",
    "\", VehicleCommand::",
];

/// The guide to ROS 2 names every topic and service that there is.
pub fn ros2_names(files: &[File]) -> Vec<Finding> {
    let guide = format!("{PAGES}/ros2.md");
    let Some(guide) = files.iter().find(|file| file.path == guide) else {
        return Vec::new();
    };
    let sources = files.iter().filter(|file| ROS2_SOURCES.contains(&file.path.as_str()));
    let lines = sources.flat_map(|file| file.text.lines());
    let names = lines
        .filter(|line| ROS2_CALLS.iter().any(|call| line.contains(call)) && !line.contains("to_string"))
        .filter_map(|line| line.split('"').nth(1))
        .map(|name| name.rsplit('}').next().unwrap_or(name).trim_start_matches('/'));
    names
        .filter(|name| !guide.text.contains(&format!("{name}`")))
        .map(|name| {
            guide.finding(
                0,
                "ros2-names",
                format!("does not name `{name}`, which the program offers"),
            )
        })
        .collect()
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
