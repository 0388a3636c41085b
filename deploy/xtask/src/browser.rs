//! Finds the real Chromium that the browser tests run in, and installs it where that is possible.
//!
//! Must never do: fetch a browser of its own choice; the one the system's package manager keeps is the one used.

use crate::debian;
use anyhow::{Context, Result};
use std::path::PathBuf;

/// Environment variable that names the browser for the tests.
pub const VARIABLE: &str = "SKEIN_CHROMIUM";
/// What it is called on the systems we know.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// The browser, installed through apt-get if there is none and that is possible.
pub fn chromium() -> Result<PathBuf> {
    if let Some(found) = find() {
        return Ok(found);
    }
    println!("no Chromium found: installing it through apt-get");
    debian::install("chromium").with_context(|| {
        format!(
            "the browser tests need Chromium: install it (Debian: apt-get install chromium) or point {VARIABLE} at it"
        )
    })?;
    find().context("apt-get installed chromium, but it is not on PATH")
}

fn find() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(VARIABLE) {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|file| file.is_file())
}
