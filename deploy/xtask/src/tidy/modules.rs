//! Imports inside a crate only point down, too: no module imports, over others or not, one that imports it. A module is a file beside `lib.rs`
//! with its folder. What `lib.rs` takes out of a module under its own name counts as imported from there. And each file is a module of the one above
//! it: one that nobody declares is not even compiled.
//!
//! Must never do: judge what tests import, which may see everything.

use super::{File, Finding};
use crate::workspace::Workspace;
use std::collections::{BTreeMap, BTreeSet};

/// Which modules a module imports.
type Imports<'f> = BTreeMap<&'f str, BTreeSet<&'f str>>;

/// Names each circle of modules of a crate once.
pub fn check(workspace: &Workspace, files: &[File]) -> Vec<Finding> {
    let shipped = |folder: &str| folder.starts_with("core/") || folder.starts_with("plugins/");
    let packages = workspace.packages.iter().filter(|package| shipped(&package.folder));
    packages.flat_map(|package| of_crate(&package.folder, files)).collect()
}

/// The circles of one crate.
pub fn of_crate(folder: &str, files: &[File]) -> Vec<Finding> {
    let root = format!("{folder}/src/");
    let imports = imports(&root, files);
    let finding = |circle: Vec<&str>| {
        let round = circle.join(" → ");
        let what = format!("imports go round: {round}; put what they share into a module below them");
        Finding::of(format!("{root}lib.rs"), "modules", what)
    };
    circles(&imports).into_iter().map(finding).collect()
}

/// Files of crates that no file above them declares as a module.
pub fn undeclared(files: &[File]) -> Vec<Finding> {
    let texts: BTreeMap<&str, &str> = files
        .iter()
        .map(|file| (file.path.as_str(), file.text.as_str()))
        .collect();
    let declares = |path: &str, module: &str| {
        let text = texts.get(path).copied().unwrap_or_default();
        let declared = format!("mod {module};");
        let is_comment = |line: &str| line.trim_start().starts_with("//");
        text.lines().any(|line| {
            !is_comment(line)
                && line
                    .split(' ')
                    .skip_while(|word| *word != "mod")
                    .eq(declared.split(' '))
        })
    };
    let is_declared = |path: &str| {
        let (folder, name) = path.rsplit_once('/').unwrap_or_default();
        let module = name.trim_end_matches(".rs");
        if !folder.ends_with("/src") {
            return declares(&format!("{folder}.rs"), module);
        }
        let is_root = ["lib", "main"].contains(&module);
        is_root
            || ["lib", "main"]
                .iter()
                .any(|root| declares(&format!("{folder}/{root}.rs"), module))
    };
    let of_crates = files
        .iter()
        .filter(|file| file.is("rs") && file.path.contains("/src/") && !file.path.contains("/src/bin/"));
    of_crates
        .filter(|file| !is_declared(&file.path))
        .map(|file| {
            Finding::of(
                &file.path,
                "modules",
                "no file above it declares it as a module: nothing compiles it",
            )
        })
        .collect()
}

fn imports<'f>(root: &str, files: &'f [File]) -> Imports<'f> {
    let own: Vec<(&str, &str)> = (files.iter())
        .filter_map(|file| Some((file.path.strip_prefix(root)?, shipped(&file.text))))
        .filter(|(path, _)| path.ends_with(".rs") && !is_test(path))
        .collect();
    let top = |path: &'f str| path.split('/').next().unwrap_or(path).trim_end_matches(".rs");
    let known: BTreeSet<&str> = own.iter().map(|(path, _)| top(path)).collect();
    let lib = own
        .iter()
        .find(|(path, _)| *path == "lib.rs")
        .map_or("", |(_, text)| text);
    let taken_out = taken_out(lib);
    let mut imports = Imports::new();
    for (path, text) in own {
        let module = top(path);
        if module == "lib" || module == "main" {
            continue;
        }
        let mut named = named_after("crate::", text);
        if !path.contains('/') {
            named.extend(named_after("super::", text));
        }
        let modules = named
            .into_iter()
            .filter_map(|name| known.get(name).or_else(|| taken_out.get(name)));
        let others = modules.copied().filter(|other| *other != module);
        imports.entry(module).or_default().extend(others);
    }
    imports
}

fn is_test(path: &str) -> bool {
    path.ends_with("/tests.rs") || path == "tests.rs" || path.contains("/tests/")
}

/// A file without the tests at its end.
fn shipped(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text)
}

/// What stands behind a prefix, alone or in braces: `a` of `crate::a::B`, `a` and `c` of `crate::{a::B, c}`.
fn named_after<'f>(prefix: &str, text: &'f str) -> Vec<&'f str> {
    let mut names = Vec::new();
    for (at, _) in text.match_indices(prefix) {
        let line = text.get(..at).and_then(|before| before.rsplit('\n').next());
        // what is told of in a comment is not imported
        if line.is_some_and(|line| line.trim_start().starts_with("//")) {
            continue;
        }
        let before = text.get(..at).and_then(|before| before.chars().next_back());
        // of `$crate::` and `some_crate::` nothing is meant
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '$' || c == ':') {
            continue;
        }
        let rest = text.get(at + prefix.len()..).unwrap_or_default();
        match rest.strip_prefix('{') {
            Some(group) => names.extend(heads(group)),
            None => names.push(word(rest)),
        }
    }
    names
}

/// The first word of each entry of a group in braces.
fn heads(group: &str) -> Vec<&str> {
    let (mut depth, mut begins, mut heads) = (0_u32, 0, Vec::new());
    for (at, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => {
                heads.push(word(group.get(begins..at).unwrap_or_default().trim_start()));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                heads.push(word(group.get(begins..at).unwrap_or_default().trim_start()));
                begins = at + 1;
            }
            _ => {}
        }
    }
    heads
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    text.get(..end.unwrap_or(text.len())).unwrap_or_default()
}

/// Names that `lib.rs` takes out of its modules, with the module of each.
fn taken_out(lib: &str) -> BTreeMap<&str, &str> {
    let mut names = BTreeMap::new();
    for statement in lib.split(';') {
        let Some((_, path)) = statement.split_once("pub use ") else {
            continue;
        };
        let Some((module, rest)) = path.split_once("::") else {
            continue;
        };
        match rest.strip_prefix('{') {
            Some(group) => names.extend(heads(group).into_iter().map(|name| (name, module))),
            None => {
                names.insert(word(rest), module);
            }
        }
    }
    names
}

/// Each circle, from its first module by name back to it.
fn circles<'f>(imports: &Imports<'f>) -> Vec<Vec<&'f str>> {
    let mut found: Vec<Vec<&str>> = Vec::new();
    for start in imports.keys() {
        if found.iter().any(|circle| circle.contains(start)) {
            continue;
        }
        if let Some(mut way) = way_back(imports, start) {
            way.insert(0, start);
            found.push(way);
        }
    }
    found
}

/// The shortest way from a module to itself.
fn way_back<'f>(imports: &Imports<'f>, start: &'f str) -> Option<Vec<&'f str>> {
    let mut seen = BTreeSet::new();
    let mut ways: Vec<Vec<&str>> = vec![vec![start]];
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            let last = way.last()?;
            for next in imports.get(last).into_iter().flatten() {
                let way = [&way[..], &[*next]].concat();
                if *next == start {
                    return Some(way.into_iter().skip(1).collect());
                }
                if seen.insert(*next) {
                    longer.push(way);
                }
            }
        }
        ways = longer;
    }
    None
}
