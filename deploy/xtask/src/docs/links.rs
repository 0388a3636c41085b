//! Links, anchors and includes of a document, as Markdown on GitHub and mdBook read them.
//!
//! Must never do: read a file. What a link leads to is its caller's question.

/// A link as it stands in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Link<'a> {
    /// Line, from 1.
    pub line: usize,
    /// The file it names; empty if it leads to the same document.
    pub path: &'a str,
    /// The heading it names, if any.
    pub anchor: Option<&'a str>,
}

/// The file that a line takes in, if it is an include of mdBook: alone on its line, and of a whole file.
pub fn include(line: &str) -> Option<&str> {
    line.trim()
        .strip_prefix("{{#include ")?
        .strip_suffix("}}")
        .map(str::trim)
}

/// Every link and picture outside of code blocks, but those to other hosts.
pub fn of(text: &str) -> Vec<Link<'_>> {
    let lines = prose(text).flat_map(|(number, line)| targets(line).map(move |target| (number, target)));
    lines
        .filter(|(_, target)| !target.is_empty() && !target.contains("://") && !target.starts_with("mailto:"))
        .map(|(line, target)| {
            let (path, anchor) = match target.split_once('#') {
                Some((path, anchor)) => (path, Some(anchor)),
                None => (target, None),
            };
            Link { line, path, anchor }
        })
        .collect()
}

/// What stands in the brackets of each link of a line.
pub fn targets(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// The anchors of a document's headings.
pub fn anchors(text: &str) -> Vec<String> {
    let headings = prose(text).filter_map(|(_, line)| line.strip_prefix('#'));
    let mut anchors: Vec<String> = Vec::new();
    for heading in headings {
        let plain = anchor(heading.trim_start_matches('#').trim());
        let same = anchors.iter().filter(|known| **known == plain).count();
        anchors.push(if same == 0 { plain } else { format!("{plain}-{same}") });
    }
    anchors
}

/// The anchor of a heading: letters, digits, hyphens and underscores; blanks become hyphens, and of a link its text is left.
fn anchor(heading: &str) -> String {
    let mut shown = String::new();
    let mut rest = heading;
    while let Some((before, after)) = rest.split_once("](") {
        shown.push_str(before);
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    shown.push_str(rest);
    let kept = shown.chars().filter_map(|c| match c {
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_lowercase().to_string()),
        c if c.is_whitespace() => Some("-".to_owned()),
        _ => None,
    });
    kept.collect()
}

/// The lines outside of fenced code, with their numbers from 1.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_code = false;
    let numbered = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    numbered.filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        in_code ^= fence;
        !in_code && !fence
    })
}

/// A path relative to the root, of what a document in `folder` names.
pub fn resolved(folder: &str, path: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// The folder of a path.
pub fn folder(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}
