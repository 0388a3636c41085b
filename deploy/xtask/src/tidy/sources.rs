//! Rules about source files: the opening comment, size, names, unsafe, what pure crates may touch.

use super::{File, Finding};
use crate::workspace::Workspace;

/// A file longer than this is split.
const FILE_LINES_MAX: usize = 600;
/// A file longer than this is worth a look.
const FILE_LINES_NOTED: usize = 400;
/// `main.rs` only wires.
const MAIN_LINES_MAX: usize = 150;
/// A plugin's library only exports what its crate holds.
const SHIM_LINES_MAX: usize = 60;
/// Names that say nothing about what a file holds.
const EMPTY_NAMES: [&str; 7] = ["utils", "util", "common", "helpers", "helper", "misc", "mod"];
/// Crates without effects: the same inputs give the same outputs.
const PURE: [&str; 5] = [
    "core/coordination/src/",
    "core/domain/src/",
    "core/failover/src/",
    "core/flight/src/",
    "core/safety/src/",
];
/// What would give them effects.
const EFFECTS: [&str; 9] = [
    "Instant::now",
    "SystemTime::now",
    "std::fs",
    "std::net",
    "std::thread",
    "std::env",
    "std::process",
    "tokio::",
    "rand::",
];
/// Crates that may hold `unsafe`; each block carries its reason.
const MAY_BE_UNSAFE: [&str; 4] = [
    "core/plugin-abi",
    "core/plugin-sdk",
    "core/plugin-host",
    "core/realtime",
];

/// Every rule that looks at one file.
pub fn check(file: &File) -> Vec<Finding> {
    let mut findings = Vec::new();
    // what a program wrote is not read but compared, by the test that makes it anew
    if file.path.contains("/generated/") || !(file.is("rs") || file.is("ts") || file.is("svelte") || file.is("py")) {
        return findings;
    }
    let lines = file.text.lines().count();
    if lines > FILE_LINES_MAX {
        findings.push(file.finding(
            0,
            "file-size",
            format!("{lines} lines, over {FILE_LINES_MAX}: split it by what it does"),
        ));
    }
    let (folder, name) = file.path.rsplit_once('/').unwrap_or(("", &file.path));
    let stem = name.split('.').next().unwrap_or(name);
    let last_folder = folder.rsplit('/').next().unwrap_or(folder);
    if EMPTY_NAMES.contains(&stem) || (last_folder != "mod" && EMPTY_NAMES.contains(&last_folder)) {
        findings.push(file.finding(0, "names", "a name that says nothing: name it after what it holds"));
    }
    if file.is("rs") {
        rust(file, name, &mut findings);
    }
    findings
}

fn rust(file: &File, name: &str, findings: &mut Vec<Finding>) {
    if !file.text.starts_with("//!") {
        findings.push(file.finding(
            1,
            "opening",
            "open with `//!`: what lives here, and what it must never do",
        ));
    }
    let lines = file.text.lines().count();
    if name == "main.rs" && lines >= MAIN_LINES_MAX {
        findings.push(file.finding(
            0,
            "main-size",
            format!("{lines} lines: main only wires, under {MAIN_LINES_MAX}"),
        ));
    }
    findings.extend(unsafe_blocks(file));
    findings.extend(attributes(file));
    if PURE.iter().any(|folder| file.path.starts_with(folder)) && !is_test(&file.path) {
        findings.extend(effects(file));
    }
}

fn is_test(path: &str) -> bool {
    path.ends_with("/tests.rs") || path.contains("/tests/")
}

fn code_lines(file: &File) -> impl Iterator<Item = (usize, &str)> {
    let numbered = file
        .text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.trim_start()));
    numbered.filter(|(_, line)| !line.starts_with("//"))
}

/// Each `unsafe` block or impl has a line that says why it is sound, close above it or on it.
fn unsafe_blocks(file: &File) -> Vec<Finding> {
    let lines: Vec<&str> = file.text.lines().collect();
    let needs = |line: &str| line.contains(concat!("unsafe", " {")) || line.contains(concat!("unsafe", " impl"));
    let explained = |number: usize| {
        let above = lines.get(number.saturating_sub(7)..number).unwrap_or_default();
        above.iter().any(|line| line.contains("SAFETY"))
    };
    code_lines(file)
        .filter(|(number, line)| needs(line) && !explained(*number))
        .map(|(number, _)| {
            file.finding(
                number,
                "safety-line",
                "say above it, after `// SAFETY:`, why this is sound",
            )
        })
        .collect()
}

/// A lint is switched off, and a test ignored, only with a reason.
fn attributes(file: &File) -> Vec<Finding> {
    let mut findings = Vec::new();
    for start in ["#[allow(", "#![allow(", "#[expect(", "#![expect("] {
        for (at, _) in file.text.match_indices(start) {
            let rest = file.text.get(at..).unwrap_or_default();
            let attribute = rest.split(")]").next().unwrap_or(rest);
            let number = file.text.get(..at).unwrap_or_default().matches('\n').count() + 1;
            let in_code = file
                .text
                .lines()
                .nth(number - 1)
                .is_some_and(|line| line.trim_start().starts_with('#'));
            if in_code && !attribute.contains("reason") {
                findings.push(file.finding(
                    number,
                    "lint-reason",
                    "add `reason = \"…\"`: why does the lint not hold here?",
                ));
            }
        }
    }
    let ignored = code_lines(file).filter(|(_, line)| line.starts_with(concat!("#[", "ignore]")));
    findings.extend(ignored.map(|(number, _)| file.finding(number, "lint-reason", "say why the test is ignored")));
    findings
}

fn effects(file: &File) -> Vec<Finding> {
    let touched = |line: &str| EFFECTS.iter().find(|effect| line.contains(**effect)).copied();
    code_lines(file)
        .filter_map(|(number, line)| Some((number, touched(line)?)))
        .map(|(number, effect)| {
            file.finding(
                number,
                "pure-core",
                format!("a pure crate uses {effect}: take it as an argument"),
            )
        })
        .collect()
}

/// Callers hold typed handles; what actors tell each other stays in their own private modules.
pub fn messages(files: &[File]) -> Vec<Finding> {
    let Some(root) = files.iter().find(|file| file.path == "core/runtime/src/lib.rs") else {
        return Vec::new();
    };
    let shown = |word: &str| code_lines(root).any(|(_, line)| line.starts_with("pub ") && line.contains(word));
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.path.starts_with("core/runtime/src/")) {
        let module = file
            .path
            .trim_start_matches("core/runtime/src/")
            .split(['/', '.'])
            .next()
            .unwrap_or_default();
        let module_is_public = shown(&format!("mod {module};"));
        for (number, line) in code_lines(file) {
            let name = line
                .strip_prefix("pub enum ")
                .and_then(|rest| rest.split([' ', '<', '{']).next());
            let Some(name) = name.filter(|name| name.ends_with("Msg") || name.ends_with("Message")) else {
                continue;
            };
            if module_is_public || shown(name) {
                findings.push(file.finding(
                    number,
                    "handles",
                    "an actor's messages are private: offer a typed handle",
                ));
            }
        }
    }
    findings
}

/// Every crate root forbids unsafe code, but the few that may hold it.
pub fn crate_roots(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in &workspace.packages {
        let shim = package.builds("cdylib");
        if shim || MAY_BE_UNSAFE.contains(&package.folder.as_str()) {
            continue;
        }
        let roots = package
            .targets
            .iter()
            .filter(|target| target.kind.iter().any(|kind| kind == "lib" || kind == "bin"));
        for root in roots {
            let path = root
                .src_path
                .strip_prefix(&workspace.root)
                .unwrap_or(&root.src_path)
                .to_string_lossy();
            let Some(file) = files.iter().find(|file| file.path == path) else {
                continue;
            };
            if !file.text.contains("#![forbid(unsafe_code)]") {
                findings.push(file.finding(0, "forbid-unsafe", "add `#![forbid(unsafe_code)]` to the crate root"));
            }
        }
    }
    findings
}

/// The libraries of plugins are thin: logic lives in the crate beside them, where unit tests reach it.
pub fn shims(files: &[File]) -> Vec<Finding> {
    let shims = files
        .iter()
        .filter(|f| f.path.starts_with("plugins/") && f.path.contains("/cdylib/") && f.is("rs"));
    shims
        .filter(|file| file.text.lines().count() >= SHIM_LINES_MAX)
        .map(|file| {
            file.finding(
                0,
                "shim-size",
                format!("{SHIM_LINES_MAX} lines or more: move logic into the plugin's crate"),
            )
        })
        .collect()
}

/// Files that are getting long; no breach yet.
pub fn long_files(files: &[File]) -> Vec<String> {
    let sources = files
        .iter()
        .filter(|file| file.is("rs") || file.is("ts") || file.is("svelte"));
    let sources = sources.filter(|file| !file.path.contains("/generated/"));
    let long = sources
        .map(|file| (file, file.text.lines().count()))
        .filter(|(_, lines)| *lines > FILE_LINES_NOTED);
    long.map(|(file, lines)| format!("{} has {lines} lines (wanted: about {FILE_LINES_NOTED})", file.path))
        .collect()
}
