//! The pages that are made from the program: its command line, its API, its metrics and its messages of ROS 2.
//!
//! Must never do: explain. What is not clear from these pages is to be made clear where they come from.

use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program that is built already, as the tests take it.
const BINARY: &str = "SKEIN_BINARY";
/// Options that every command has; they are shown once.
const EVERYWHERE: [&str; 3] = ["--log-format <", "--log <", "-h, --help"];
/// Where metrics are counted and described.
const METRICS: [&str; 2] = ["core/api/src/metrics.rs", "core/api/src/stream.rs"];
/// Where the counters of an endpoint are declared, each with what it counts.
const ENDPOINT_COUNTERS: &str = "core/link-mavlink/src/metrics.rs";

/// Each generated page with its text.
pub fn pages(workspace: &Workspace) -> Result<Vec<(&'static str, String)>> {
    let root = &workspace.root;
    let read = |path: &str| std::fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {path}"));
    let sources = METRICS.iter().map(|path| read(path)).collect::<Result<String>>()?;
    Ok(vec![
        (
            "reference/api.md",
            api(&serde_json::from_str(&read("core/api/openapi.json")?)?),
        ),
        ("reference/cli.md", command_line(&binary(workspace)?)?),
        ("reference/metrics.md", metrics(&sources, &read(ENDPOINT_COUNTERS)?)),
        (
            "reference/ros2-messages.md",
            messages(&root.join("deploy/ros2/skein_msgs"))?,
        ),
    ])
}

/// The operations of an OpenAPI document, by subject.
pub fn api(document: &Value) -> String {
    let mut by_tag: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let paths = document["paths"].as_object().into_iter().flatten();
    for (path, operations) in paths {
        for (method, operation) in operations.as_object().into_iter().flatten() {
            let tag = operation["tags"][0].as_str().unwrap_or("other");
            let summary = operation["summary"].as_str().unwrap_or_default().replace('|', "\\|");
            let row = format!("| {} | `{path}` | {summary} |", method.to_uppercase());
            by_tag.entry(tag).or_default().push(row);
        }
    }
    let mut page = "# API\n\nMade from `core/api/openapi.json`, which a node serves at `/api/v1/openapi.json`: it has the schema of every body \
                    and an example of each. `/api/v1/stream` is a WebSocket; its messages are in the same document.\n"
        .to_owned();
    for (tag, rows) in by_tag {
        _ = write!(
            page,
            "\n## {tag}\n\n| method | path | what |\n|---|---|---|\n{}\n",
            rows.join("\n")
        );
    }
    page
}

/// The program whose help is shown.
fn binary(workspace: &Workspace) -> Result<PathBuf> {
    if let Some(told) = std::env::var_os(BINARY) {
        return Ok(told.into());
    }
    let built = workspace.cargo().args(["build", "--package", "skein"]).status()?;
    ensure!(built.success(), "skein was not built: see above");
    Ok(workspace.target.join("debug/skein"))
}

/// The help of the program and of all of its commands.
fn command_line(binary: &Path) -> Result<String> {
    let mut page = "# Command line\n\nMade from `skein --help` and the help of each command. `--log-format`, `--log` and `--help` are options of \
                    every command; they are shown once.\n"
        .to_owned();
    let mut left = vec![Vec::<String>::new()];
    while let Some(command) = left.pop() {
        let output = Command::new(binary).args(&command).arg("--help").output();
        let output = output.with_context(|| format!("cannot start {}", binary.display()))?;
        ensure!(output.status.success(), "skein {} --help failed", command.join(" "));
        let help = String::from_utf8_lossy(&output.stdout);
        let below = commands(&help);
        left.extend(
            below
                .into_iter()
                .rev()
                .map(|name| [command.clone(), vec![name]].concat()),
        );
        let name = [vec!["skein".to_owned()], command.clone()].concat().join(" ");
        let shown = if command.is_empty() {
            help.trim_end().to_owned()
        } else {
            own_options(&help)
        };
        _ = write!(page, "\n## {name}\n\n```text\n{shown}\n```\n");
    }
    Ok(page)
}

/// The commands that a help text names.
pub fn commands(help: &str) -> Vec<String> {
    let section = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = section
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

/// A help text without the options that every command has.
pub fn own_options(help: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut skipping = false;
    for line in help.lines() {
        let indented = line.len() - line.trim_start().len();
        if indented <= 6 && line.trim_start().starts_with('-') {
            skipping = EVERYWHERE.iter().any(|option| line.contains(option));
        } else if indented == 0 && !line.is_empty() {
            skipping = false;
        }
        if !skipping {
            kept.push(line);
        }
    }
    let text = kept.join("\n").trim_end().to_owned();
    text.strip_suffix("Options:")
        .map_or(text.clone(), |rest| rest.trim_end().to_owned())
}

/// The metrics that the sources name, each with its description where it has one.
pub fn metrics(sources: &str, endpoint_counters: &str) -> String {
    let mut described: BTreeMap<&str, &str> = BTreeMap::new();
    for part in sources.split("describe_").skip(1).filter(|part| part.contains("!(")) {
        let mut texts = part.split('"').skip(1).step_by(2);
        if let (Some(name), Some(text)) = (texts.next(), texts.next()) {
            described.insert(name, text);
        }
    }
    let named: BTreeSet<&str> = [
        "gauge!(\"",
        "counter!(\"",
        "gauge!(\n        \"",
        "counter!(\n        \"",
    ]
    .into_iter()
    .flat_map(|call| sources.split(call).skip(1).filter_map(|rest| rest.split('"').next()))
    .collect();
    let mut rows: Vec<(String, &str)> = named
        .into_iter()
        .map(|name| (name.to_owned(), described.get(name).copied().unwrap_or_default()))
        .collect();
    let declared = endpoint_counters.split("counters!(").nth(1).unwrap_or_default();
    let declared = declared.split("\n);").next().unwrap_or_default();
    for part in declared.split("/// ").skip(1) {
        let mut lines = part.lines();
        let (text, name) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
        rows.push((
            format!("skein_endpoint_{}_total", name.trim().trim_end_matches(',')),
            text,
        ));
    }
    let mut page = "# Metrics\n\nMade from the source of `/metrics`, which a node serves in Prometheus' text format. What is not known is left out: \
                    a zero would look like a measurement.\n\n| metric | what |\n|---|---|\n"
        .to_owned();
    for (name, text) in rows {
        _ = writeln!(page, "| `{name}` | {text} |");
    }
    page
}

/// The definitions of `skein_msgs`.
fn messages(package: &Path) -> Result<String> {
    let mut page = "# ROS 2 messages\n\nMade from the definitions in `deploy/ros2/skein_msgs`.\n".to_owned();
    for folder in ["msg", "srv"] {
        let files = std::fs::read_dir(package.join(folder))?.collect::<Result<Vec<_>, _>>()?;
        let paths: BTreeSet<PathBuf> = files.iter().map(std::fs::DirEntry::path).collect();
        for path in paths {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let text = std::fs::read_to_string(&path)?;
            _ = write!(page, "\n## skein_msgs/{name}\n\n```text\n{}\n```\n", text.trim_end());
        }
    }
    Ok(page)
}
