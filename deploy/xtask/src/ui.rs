//! The dashboard: its packages, its build and its checks through npm.
//!
//! Must never do: build again what has not changed, or take a build for fresh that is not.

use crate::step::Step;
use crate::tally::Tally;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders that are made by the build or the tests and so are no sources of it.
const NOT_SOURCES: [&str; 9] = [
    "node_modules",
    "dist",
    "test-results",
    "playwright-report",
    "e2e",
    "dev",
    "bench",
    "soak",
    "screenshots",
];

/// An npm command in the dashboard's folder.
pub fn npm(workspace: &Workspace, arguments: &[&str]) -> Command {
    let mut command = Command::new("npm");
    command.current_dir(workspace.web_ui()).args(arguments);
    command
}

/// Installs the packages of the lock file, unless they are there.
pub fn install(workspace: &Workspace) -> Result<()> {
    let web_ui = workspace.web_ui();
    let lock = web_ui.join("package-lock.json");
    ensure!(
        lock.is_file(),
        "{} is missing: run `npm install` in web-ui and commit it",
        lock.display()
    );
    let wanted = hash_files(&web_ui, &[lock, web_ui.join("package.json")])?;
    let stamp = Stamp {
        file: web_ui.join("node_modules/.skein-stamp"),
        wanted,
    };
    if stamp.is_fresh() {
        println!("web-ui: packages are there");
        return Ok(());
    }
    println!("web-ui: npm ci");
    let arguments = ["ci", "--no-audit", "--no-fund"];
    let advice = "npm could not install the dashboard's packages: is Node 20.19 or newer there, and the network?";
    Step::new(npm(workspace, &arguments))
        .run(&mut Tally::default())
        .context(advice)?;
    stamp.write()
}

/// Builds the dashboard into `web-ui/dist`, from where the program embeds it.
pub fn build(workspace: &Workspace) -> Result<()> {
    install(workspace)?;
    let web_ui = workspace.web_ui();
    let wanted = hash_files(&web_ui, &sources(&web_ui)?)?;
    let stamp = Stamp {
        // beside what it speaks of: several checkouts may share a build directory
        file: web_ui.join("node_modules/.skein-dist-stamp"),
        wanted,
    };
    if stamp.is_fresh() && web_ui.join("dist/index.html").is_file() {
        println!("web-ui: built from these sources before");
        return Ok(());
    }
    println!("web-ui: npm run build");
    Step::new(npm(workspace, &["run", "build"]))
        .run(&mut Tally::default())
        .context("the dashboard does not build")?;
    // vite empties the folder; git keeps it by this file
    fs::write(web_ui.join("dist/.gitkeep"), "")?;
    stamp.write()
}

/// Remembers from which sources something was made.
struct Stamp {
    file: PathBuf,
    wanted: String,
}

impl Stamp {
    fn is_fresh(&self) -> bool {
        fs::read_to_string(&self.file).is_ok_and(|found| found == self.wanted)
    }

    fn write(&self) -> Result<()> {
        if let Some(folder) = self.file.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(&self.file, &self.wanted).with_context(|| format!("cannot write {}", self.file.display()))
    }
}

fn sources(web_ui: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![web_ui.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))? {
            let path = entry?.path();
            if !path.is_dir() {
                files.push(path);
            } else if !path
                .file_name()
                .is_some_and(|name| NOT_SOURCES.iter().any(|not| name == *not))
            {
                folders.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Detects a change, no attack: the standard library's hash with its fixed keys will do.
fn hash_files(base: &Path, files: &[PathBuf]) -> Result<String> {
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.strip_prefix(base).unwrap_or(file).hash(&mut hasher);
        fs::read(file)
            .with_context(|| format!("cannot read {}", file.display()))?
            .hash(&mut hasher);
    }
    Ok(format!("{:016x}", hasher.finish()))
}
