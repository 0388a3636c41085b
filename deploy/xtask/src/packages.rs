//! `packages`: Debian packages of the program with its plugins, archives of the same for `skein upgrade`, and whether they install, upgrade and go without a trace.
//!
//! Must never do: put into a package what was not built from this tree, or install anything outside a root of its own.

mod chroot;
mod service;
mod target;

pub use chroot::base;
pub use target::Architecture;

use crate::plugins;
use crate::ui;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Of cargo-deb.
const CARGO_DEB: &str = "^3.8";
/// The oldest C library that the packages are for, as `depends` of the program's manifest has it: that of Jetson Linux 36 and Ubuntu 22.04.
const LIBC: (u32, u32) = (2, 35);

/// What `cargo xtask packages` may be told.
#[derive(clap::Args)]
pub struct PackagesArguments {
    /// For these computers; each but this computer's own is cross-compiled [default: both].
    #[arg(long = "arch", value_name = "ARCHITECTURE")]
    architectures: Vec<Architecture>,
    /// Also holds each against lintian, installs, upgrades, removes and purges it in a Debian of its own, and flies it there as a service of systemd. Needs root.
    #[arg(long)]
    check: bool,
}

/// Builds the packages, checks them if that is wanted, says where they are.
pub fn run(workspace: &Workspace, arguments: &PackagesArguments) -> Result<ExitCode> {
    let wanted = match arguments.architectures.as_slice() {
        [] => vec![Architecture::Amd64, Architecture::Arm64],
        named => named.to_vec(),
    };
    let made = build(workspace, &wanted)?;
    if arguments.check {
        for (architecture, package) in &made {
            chroot::check(workspace, *architecture, package)?;
            if *architecture == Architecture::of_this_computer()? {
                service::check(workspace, *architecture, package)?;
            }
        }
    }
    for (architecture, package) in &made {
        let archive = archive(workspace, *architecture, package)?;
        for file in [package, &archive] {
            let size_mb = std::fs::metadata(file)?.len() as f64 / 1e6;
            println!("{} ({size_mb:.1} MB)", file.display());
        }
    }
    println!("install one by: apt install ./FILE, and fly a simulated swarm by: skein demo");
    Ok(ExitCode::SUCCESS)
}

/// One package for each architecture.
pub fn build(workspace: &Workspace, wanted: &[Architecture]) -> Result<Vec<(Architecture, PathBuf)>> {
    let own = Architecture::of_this_computer()?;
    let cargo_deb = cargo_deb(workspace)?;
    ui::build(workspace)?;
    // Its own program writes the pages and completions for all.
    println!("building for {own}");
    plugins::build_to_ship(workspace, None)?;
    let pages = workspace.target.join("release/package");
    write_pages(workspace, &pages)?;
    let mut made = Vec::new();
    for architecture in wanted {
        let triple = (*architecture != own).then(|| architecture.triple());
        if triple.is_some() {
            println!("building for {architecture}");
            architecture.prepare()?;
            plugins::build_to_ship(workspace, Some(*architecture))?;
            let there = workspace.target.join(architecture.triple()).join("release/package");
            copy_all(&pages, &there)?;
        }
        let built = triple.map_or_else(|| workspace.target.clone(), |triple| workspace.target.join(triple));
        runs_with_old_libc(*architecture, &built.join("release"))?;
        made.push((*architecture, pack(workspace, &cargo_deb, *architecture, triple)?));
    }
    Ok(made)
}

/// An installed cargo-deb, or one of our own in the build directory, which is installed once.
fn cargo_deb(workspace: &Workspace) -> Result<PathBuf> {
    let tools = workspace.target.join("tools");
    let own = tools.join("bin/cargo-deb");
    let works = |program: &Path| Command::new(program).arg("--version").output().is_ok();
    if let Some(program) = [PathBuf::from("cargo-deb"), own.clone()].into_iter().find(|p| works(p)) {
        return Ok(program);
    }
    println!("installing cargo-deb into {} (some minutes, once)", tools.display());
    let mut install = workspace.cargo();
    install
        .args(["install", "--locked", "--version", CARGO_DEB, "--root"])
        .arg(&tools)
        .arg("cargo-deb");
    ensure!(install.status()?.success(), "cargo-deb was not installed: see above");
    Ok(own)
}

/// Man pages, completions and the changelogs, that in Debian's form and that for people.
fn write_pages(workspace: &Workspace, into: &Path) -> Result<()> {
    let program = workspace.target.join("release/skein");
    let (man, completions) = (into.join("man"), into.join("completions"));
    if into.exists() {
        std::fs::remove_dir_all(into)?;
    }
    std::fs::create_dir_all(&man)?;
    std::fs::create_dir_all(&completions)?;
    ended_well(Command::new(&program).arg("man").arg(&man), "skein man")?;
    for page in std::fs::read_dir(&man)?.flatten() {
        compress(&page.path())?;
    }
    for (shell, file) in [("bash", "skein.bash"), ("zsh", "_skein"), ("fish", "skein.fish")] {
        let printed = Command::new(&program).args(["completions", shell]).output()?;
        ensure!(printed.status.success(), "skein completions {shell} failed");
        std::fs::write(completions.join(file), printed.stdout)?;
    }
    std::fs::write(into.join("changelog.Debian"), changelog_of(workspace)?)?;
    std::fs::copy(workspace.root.join("CHANGELOG.md"), into.join("changelog"))?;
    compress(&into.join("changelog.Debian"))?;
    compress(&into.join("changelog"))
}

/// One entry: what has changed stands in the changelog for people, beside it.
fn changelog_of(workspace: &Workspace) -> Result<String> {
    let date = Command::new("git")
        .args(["log", "-1", "--format=%cD"])
        .current_dir(&workspace.root)
        .output()?;
    let date = String::from_utf8(date.stdout)?;
    let version = workspace.version()?;
    Ok(format!(
        "skein ({version}-1) unstable; urgency=medium\n\n  * See /usr/share/doc/skein/changelog.gz.\n\n -- Skein developers <skein@skein-swarm.org>  {}\n",
        date.trim()
    ))
}

/// As Debian wants it: without a name or a time in it.
fn compress(file: &Path) -> Result<()> {
    ended_well(Command::new("gzip").args(["-9nf"]).arg(file), "gzip")
}

fn copy_all(from: &Path, to: &Path) -> Result<()> {
    if to.exists() {
        std::fs::remove_dir_all(to)?;
    }
    std::fs::create_dir_all(to.parent().context("a folder above")?)?;
    ended_well(Command::new("cp").arg("-r").arg(from).arg(to), "cp")
}

/// No program or plugin calls what only a newer C library has.
fn runs_with_old_libc(architecture: Architecture, built: &Path) -> Result<()> {
    let plugins = std::fs::read_dir(built.join("plugins"))?
        .flatten()
        .map(|plugin| plugin.path());
    for file in std::iter::once(built.join("skein")).chain(plugins) {
        let said = Command::new(architecture.objdump()).arg("-T").arg(&file).output()?;
        ensure!(said.status.success(), "objdump cannot read {}", file.display());
        let text = String::from_utf8_lossy(&said.stdout);
        let versions = text.split("GLIBC_").skip(1).filter_map(|rest| {
            let mut parts = rest.split(|c: char| !c.is_ascii_digit()).map(str::parse::<u32>);
            Some((parts.next()?.ok()?, parts.next()?.ok()?))
        });
        let newest = versions.max().unwrap_or_default();
        ensure!(
            newest <= LIBC,
            "{} needs libc {}.{}",
            file.display(),
            newest.0,
            newest.1
        );
    }
    Ok(())
}

/// The package of what has been built.
fn pack(workspace: &Workspace, cargo_deb: &Path, architecture: Architecture, triple: Option<&str>) -> Result<PathBuf> {
    let folder = workspace.target.join("packages");
    std::fs::create_dir_all(&folder)?;
    let package = folder.join(format!("skein_{}-1_{architecture}.deb", workspace.version()?));
    let mut command = Command::new(cargo_deb);
    command
        // By hand it is `cargo deb`.
        .args(["deb", "--no-build", "--dbgsym", "--package", "skein", "--output"])
        .arg(&package)
        .current_dir(&workspace.root)
        .envs(architecture.environment());
    if let Some(triple) = triple {
        command.args(["--target", triple]);
    }
    ended_well(&mut command, "cargo-deb")?;
    Ok(package)
}

/// What is in a package, as `skein upgrade` sends it to the nodes of a swarm.
fn archive(workspace: &Workspace, architecture: Architecture, package: &Path) -> Result<PathBuf> {
    let unpacked = workspace
        .target
        .join("packages")
        .join(format!("unpacked-{architecture}"));
    if unpacked.exists() {
        std::fs::remove_dir_all(&unpacked)?;
    }
    let mut unpack = Command::new("dpkg-deb");
    ended_well(unpack.arg("-x").arg(package).arg(&unpacked), "dpkg-deb")?;
    let version = workspace.version()?;
    let archive = workspace
        .target
        .join("packages")
        .join(format!("skein_{version}_{architecture}.tar.gz"));
    let mut pack = Command::new(workspace.target.join("release/skein"));
    pack.args(["upgrade", "pack", "--version", version]);
    ended_well(pack.arg(&unpacked).arg(&archive), "skein upgrade pack")?;
    std::fs::remove_dir_all(&unpacked)?;
    Ok(archive)
}

fn ended_well(command: &mut Command, name: &str) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {name}"))?;
    ensure!(status.success(), "{name} failed: see above");
    Ok(())
}
