//! `docs`: the documentation as a site. Pages are put together in the build directory from `deploy/docs`, from the files that these include,
//! and from what is generated; mdBook makes HTML of them.
//!
//! Must never do: write into the source tree, or be needed by `test`: CI checks the links by `tidy`, without mdBook.

pub mod links;
pub mod pages;
mod reference;
#[cfg(test)]
mod tests;

use crate::tidy;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Where the site's own pages are.
pub const PAGES: &str = "deploy/docs/src";
/// The table of their contents.
pub const SUMMARY: &str = "deploy/docs/src/SUMMARY.md";
/// Pages that are made when the site is built.
pub const GENERATED: [&str; 4] = [
    "reference/api.md",
    "reference/cli.md",
    "reference/metrics.md",
    "reference/ros2-messages.md",
];

/// Checks links and anchors, builds the site, says where it is.
pub fn run(workspace: &Workspace) -> Result<ExitCode> {
    tidy::check_documents(workspace)?;
    let source = workspace.target.join("docs/source");
    let site = workspace.target.join("docs/site");
    if source.exists() {
        std::fs::remove_dir_all(&source)?;
    }
    pages::write(workspace, &source)?;
    for (page, text) in reference::pages(workspace)? {
        ensure!(
            GENERATED.contains(&page),
            "{page} is not in the list of generated pages"
        );
        write(&source.join("src").join(page), &text)?;
    }
    let built = Command::new(mdbook(workspace)?)
        .arg("build")
        .arg(&source)
        .arg("--dest-dir")
        .arg(&site)
        .status();
    ensure!(
        built.context("cannot start mdbook")?.success(),
        "mdbook failed: see above"
    );
    println!("open {}", site.join("index.html").display());
    Ok(ExitCode::SUCCESS)
}

/// An installed mdBook, or one of our own in the build directory, which is installed once.
fn mdbook(workspace: &Workspace) -> Result<PathBuf> {
    let works = |program: &Path| Command::new(program).arg("--version").output().is_ok();
    let tools = workspace.target.join("tools");
    let own = tools.join("bin/mdbook");
    for program in [PathBuf::from("mdbook"), own.clone()] {
        if works(&program) {
            return Ok(program);
        }
    }
    println!("installing mdbook into {} (some minutes, once)", tools.display());
    let mut install = workspace.cargo();
    install
        .args(["install", "--locked", "--version", "^0.5", "--root"])
        .arg(&tools)
        .arg("mdbook");
    ensure!(install.status()?.success(), "mdbook was not installed: see above");
    Ok(own)
}

fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().context("a file lies in a folder")?;
    std::fs::create_dir_all(folder)?;
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
