//! The pages of the site, with what they include, and with links that hold where the site is read.
//!
//! A page includes files of the repository so that a text stands in one place only. Links in it are relative to its own file; on the site they
//! lead to another page, to a picture that is copied beside it, or to the file on GitHub.
//!
//! Must never do: change what a text says.

use super::links::{self, folder, include, resolved};
use super::{GENERATED, PAGES, SUMMARY};
use crate::workspace::Workspace;
use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Files that are not on the site are read there.
const REPOSITORY: &str = "https://github.com/skein-swarm/skein";
/// Where the pictures are on the site.
const PICTURES: &str = "pictures";

/// The site while its pages are put together. Paths are relative to the root of the repository.
struct Site<'a> {
    root: &'a Path,
    /// Documents that are a page as a whole, and the page that includes them.
    included: BTreeMap<String, String>,
    /// Pictures that a page shows.
    pictures: BTreeSet<String>,
}

/// Writes all pages that are not generated, and how they look, to a folder.
pub fn write(workspace: &Workspace, into: &Path) -> Result<()> {
    let root = workspace.root.as_path();
    let pages = chapters(&read(root, SUMMARY)?);
    let pages: Vec<String> = pages.iter().map(|page| format!("{PAGES}/{page}")).collect();
    let mut site = Site {
        root,
        included: BTreeMap::new(),
        pictures: BTreeSet::new(),
    };
    for page in &pages {
        for line in read(root, page)?.lines() {
            if let Some(path) = include(line).filter(|path| path.ends_with(".md")) {
                site.included.insert(resolved(folder(page), path), page.clone());
            }
        }
    }
    for page in pages.iter().chain([&SUMMARY.to_owned()]) {
        let text = site.page(page, page)?;
        let name = page.strip_prefix(PAGES).unwrap_or(page).trim_start_matches('/');
        super::write(&into.join("src").join(name), &text)?;
    }
    for picture in &site.pictures {
        let name = picture.rsplit('/').next().unwrap_or(picture);
        let to = into.join("src").join(PICTURES);
        std::fs::create_dir_all(&to)?;
        std::fs::copy(root.join(picture), to.join(name)).with_context(|| format!("cannot copy {picture}"))?;
    }
    for name in ["book.toml", "site.css"] {
        super::write(&into.join(name), &read(root, &format!("deploy/docs/{name}"))?)?;
    }
    Ok(())
}

/// The pages that a summary names and that stand in the source tree.
pub fn chapters(summary: &str) -> Vec<String> {
    let links = links::of(summary).into_iter().map(|link| link.path.to_owned());
    links.filter(|path| !GENERATED.contains(&path.as_str())).collect()
}

/// A document with the files that it includes in their places.
pub fn whole(root: &Path, path: &str) -> Result<String> {
    let mut site = Site {
        root,
        included: BTreeMap::new(),
        pictures: BTreeSet::new(),
    };
    site.page(path, path)
}

fn read(root: &Path, path: &str) -> Result<String> {
    std::fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {path}"))
}

impl Site<'_> {
    /// The text of a document as it stands on a page.
    fn page(&mut self, document: &str, page: &str) -> Result<String> {
        let text = read(self.root, document)?;
        let mut out = String::new();
        let mut in_code = false;
        for line in text.lines() {
            in_code ^= line.trim_start().starts_with("```");
            let shown = match include(line).map(|path| resolved(folder(document), path)) {
                Some(path) if path.ends_with(".md") && !in_code => self.page(&path, page)?,
                Some(path) => read(self.root, &path)?,
                None if in_code => line.to_owned(),
                None => self.line(line, document, page),
            };
            out.push_str(shown.trim_end_matches('\n'));
            out.push('\n');
        }
        Ok(out)
    }

    /// A line with its links as they are on the site.
    fn line(&mut self, line: &str, document: &str, page: &str) -> String {
        let mut parts = line.split("](");
        let mut out = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (target, rest) = part.split_once(')').unwrap_or((part, ""));
            out.push_str("](");
            out.push_str(&self.target(target, document, page));
            out.push(')');
            out.push_str(rest);
        }
        out
    }

    fn target(&mut self, target: &str, document: &str, page: &str) -> String {
        let (path, anchor) = target.split_once('#').map_or((target, ""), |(path, _)| (path, "#"));
        let anchor = if anchor.is_empty() {
            ""
        } else {
            target.get(path.len()..).unwrap_or("")
        };
        if path.is_empty() || path.contains("://") || path.starts_with("mailto:") {
            return target.to_owned();
        }
        let file = resolved(folder(document), path);
        let shown = self.included.get(&file).unwrap_or(&file);
        if let Some(name) = shown.strip_prefix(PAGES).map(|name| name.trim_start_matches('/')) {
            return format!("{}{name}{anchor}", self.up(page));
        }
        if [".png", ".webp", ".svg"].iter().any(|picture| file.ends_with(picture)) {
            let name = file.rsplit('/').next().unwrap_or(&file).to_owned();
            self.pictures.insert(file);
            return format!("{}{PICTURES}/{name}", self.up(page));
        }
        let kind = if self.root.join(&file).is_dir() { "tree" } else { "blob" };
        format!("{REPOSITORY}/{kind}/main/{file}{anchor}")
    }

    /// The way from a page's folder to the top of the site.
    fn up(&self, page: &str) -> String {
        let name = page.strip_prefix(PAGES).unwrap_or(page).trim_start_matches('/');
        "../".repeat(name.matches('/').count())
    }
}
