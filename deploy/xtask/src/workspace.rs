//! What cargo says about the workspace: where it is, where it builds to, its members and what they depend on.
//!
//! Must never do: guess a path that cargo can tell.

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace as cargo describes it.
pub struct Workspace {
    /// The repository's root.
    pub root: PathBuf,
    /// The build directory (follows `CARGO_TARGET_DIR`).
    pub target: PathBuf,
    /// Its members.
    pub packages: Vec<Package>,
}

/// A member of the workspace.
#[derive(Debug, Clone)]
pub struct Package {
    /// Name in its manifest.
    pub name: String,
    /// Version in its manifest.
    pub version: String,
    /// Folder relative to the root, with `/` between its parts.
    pub folder: String,
    /// What it depends on.
    pub dependencies: Vec<Dependency>,
    /// What cargo builds from it.
    pub targets: Vec<Target>,
    /// Its test programs that run in real time, over sockets: `in-real-time` under `package.metadata.xtask` in its manifest.
    pub in_real_time: Vec<String>,
}

/// One dependency of a member.
#[derive(Debug, Clone, Deserialize)]
pub struct Dependency {
    /// Package name.
    pub name: String,
    /// `None` for an ordinary one, else `dev` or `build`.
    pub kind: Option<String>,
}

impl Dependency {
    /// Whether the shipped code depends on it, and not only its tests.
    pub fn ships(&self) -> bool {
        self.kind.as_deref() != Some("dev")
    }
}

/// One build target of a member.
#[derive(Debug, Clone, Deserialize)]
pub struct Target {
    /// Target name.
    pub name: String,
    /// `lib`, `bin`, `cdylib`, `test`, …
    pub kind: Vec<String>,
    /// Its root source file.
    pub src_path: PathBuf,
    /// Whether `cargo test` looks for tests in it.
    pub test: bool,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<RawPackage>,
    workspace_root: PathBuf,
    target_directory: PathBuf,
}

#[derive(Deserialize)]
struct RawPackage {
    name: String,
    version: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
    targets: Vec<Target>,
    metadata: Option<ToolKeys>,
}

/// The keys of a manifest that are for tools; cargo does not look at them.
#[derive(Deserialize)]
struct ToolKeys {
    xtask: Option<OwnKeys>,
}

/// Those that are for xtask.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct OwnKeys {
    in_real_time: Vec<String>,
}

impl Workspace {
    /// Asks cargo.
    pub fn load() -> Result<Self> {
        // where cargo runs it, not where it was compiled: two checkouts may share one build directory
        let home = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
        let manifest = Path::new(&home).join("../../Cargo.toml");
        let output = cargo()
            .args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"])
            .arg(&manifest)
            .output()
            .context("cannot start cargo: is Rust installed (https://rustup.rs)?")?;
        ensure!(
            output.status.success(),
            "cargo metadata: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        let metadata: Metadata = serde_json::from_slice(&output.stdout).context("cargo metadata is not as expected")?;
        let root = metadata.workspace_root;
        let packages = metadata
            .packages
            .into_iter()
            .map(|raw| Package::new(&root, raw))
            .collect::<Result<_>>()?;
        Ok(Self {
            root,
            target: metadata.target_directory,
            packages,
        })
    }

    /// A cargo command that runs at the root.
    pub fn cargo(&self) -> Command {
        let mut command = cargo();
        command.current_dir(&self.root);
        command
    }

    /// The member of that name.
    pub fn package(&self, name: &str) -> Option<&Package> {
        self.packages.iter().find(|package| package.name == name)
    }

    /// The program's version.
    pub fn version(&self) -> Result<&str> {
        let program = self.package("skein").context("a member `skein`")?;
        Ok(&program.version)
    }

    /// The commit that is checked out, shortened; `unknown` outside of git.
    pub fn commit(&self) -> String {
        let mut git = Command::new("git");
        git.args(["rev-parse", "--short", "HEAD"]).current_dir(&self.root);
        let output = git.output().ok().filter(|output| output.status.success());
        let commit = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
        commit.unwrap_or_else(|| "unknown".to_owned())
    }

    /// The dashboard's folder.
    pub fn web_ui(&self) -> PathBuf {
        self.root.join("web-ui")
    }
}

impl Package {
    fn new(root: &Path, raw: RawPackage) -> Result<Self> {
        let folder = raw.manifest_path.parent().context("a manifest lies in a folder")?;
        let folder = folder
            .strip_prefix(root)
            .with_context(|| format!("{} is outside of the workspace", raw.name))?;
        let folder = folder.to_string_lossy().replace('\\', "/");
        Ok(Self {
            name: raw.name,
            version: raw.version,
            folder,
            dependencies: raw.dependencies,
            targets: raw.targets,
            in_real_time: (raw.metadata.and_then(|tools| tools.xtask))
                .map(|keys| keys.in_real_time)
                .unwrap_or_default(),
        })
    }

    /// Whether it builds a shared library that the program loads.
    pub fn is_plugin_library(&self) -> bool {
        self.folder.starts_with("plugins/") && self.builds("cdylib")
    }

    /// Whether one of its targets is of that kind.
    pub fn builds(&self, kind: &str) -> bool {
        self.targets.iter().any(|target| target.kind.iter().any(|k| k == kind))
    }
}

fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // What cargo told this program of itself: build scripts look at it, and would run again whenever cargo is then called by hand.
    for (name, _) in std::env::vars_os() {
        let told = name.to_string_lossy();
        if told.starts_with("CARGO_PKG_") || told.starts_with("CARGO_MANIFEST_") {
            command.env_remove(&name);
        }
    }
    if std::env::var_os("CI").is_some() {
        // everything is compiled once and thrown away: keeping what a second build could reuse only costs time
        command.env("CARGO_INCREMENTAL", "0");
    }
    command
}
