//! A package in a Debian of its own: installed, used, upgraded, removed and purged, and held against lintian.
//!
//! Must never do: touch this computer's own system, or need anything in the root that the package does not name.

use super::Architecture;
use crate::debian;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The oldest release that the packages are for, and what of it the package needs beside the essential packages.
const RELEASE: &str = "bookworm";
const NEEDED: &str = "adduser,libstdc++6,libgcc-s1";
/// What else there is where systemd runs it: systemd itself, and what the check asks the node with.
const BOOTED: &str = "systemd-sysv,dbus,curl,jq";
/// Tags of lintian that are not heeded, each with its reason.
const NOT_HEEDED: [&str; 2] = [
    // It is not uploaded to Debian, where the first entry would close a bug.
    "initial-upload-closes-no-bugs",
    // The libraries are plugins: nobody links against them.
    "no-symbols-control-file",
];
/// Where a removed package may leave something: what dpkg and the tools it calls write down.
const BOOKKEEPING: [&str; 8] = [
    "/var/lib/dpkg",
    "/var/log",
    "/var/cache",
    "/etc/passwd",
    "/etc/group",
    "/etc/shadow",
    "/etc/gshadow",
    "/var/lib/systemd",
];

/// Checks one package.
pub fn check(workspace: &Workspace, architecture: Architecture, package: &Path) -> Result<()> {
    lintian(package)?;
    contained(&workspace.root.join("deploy/systemd/skein.service"))?;
    let root = Root::open(workspace, architecture)?;
    let before = root.files()?;
    root.give(package, "skein.deb")?;
    root.run("dpkg -i /skein.deb")?;
    println!("{architecture}: installed");
    used(&root, architecture)?;
    // What a person has written, and the node itself.
    root.run("echo '# mine' > /etc/skein/skein.toml && mkdir -p /var/lib/skein && echo 7 > /var/lib/skein/term")?;
    root.give(&newer(workspace, package)?, "newer.deb")?;
    root.run("dpkg -i /newer.deb")?;
    root.run("grep -q mine /etc/skein/skein.toml && grep -q 7 /var/lib/skein/term")?;
    root.run("skein --version")?;
    println!("{architecture}: upgraded, configuration and state kept");
    root.run("dpkg -r skein && ! command -v skein && test -e /etc/skein/skein.toml && test -e /var/lib/skein/term")?;
    println!("{architecture}: removed, configuration and state kept");
    root.run("dpkg -P skein && rm /skein.deb /newer.deb && ! getent passwd skein")?;
    let left: Vec<_> = root.files()?.difference(&before).cloned().collect();
    ensure!(left.is_empty(), "after a purge there is still: {left:?}");
    println!("{architecture}: purged, nothing is left");
    Ok(())
}

/// It says nothing against the package.
fn lintian(package: &Path) -> Result<()> {
    if Command::new("lintian").arg("--version").output().is_err() {
        println!("no lintian found: installing it through apt-get");
        debian::install("lintian").context("install lintian")?;
    }
    let said = Command::new("lintian")
        .args(["--allow-root", "--suppress-tags", &NOT_HEEDED.join(",")])
        .args(["--fail-on", "error,warning"])
        .arg(package)
        .output()?;
    let text = String::from_utf8_lossy(&said.stdout);
    ensure!(said.status.success(), "lintian: {text}");
    println!("lintian says nothing against {}", package.display());
    Ok(())
}

/// The service reaches little of the system, as systemd counts it: 25 is 2.5 of 10.
fn contained(unit: &Path) -> Result<()> {
    let mut judge = Command::new("systemd-analyze");
    judge
        .args(["security", "--offline=true", "--threshold=25", "--no-pager"])
        .arg(unit);
    let said = judge.output().context("cannot start systemd-analyze")?;
    let text = String::from_utf8_lossy(&said.stdout);
    ensure!(said.status.success(), "{text}");
    println!("{}", text.lines().last().unwrap_or_default());
    Ok(())
}

/// As the next version would come.
fn newer(workspace: &Workspace, package: &Path) -> Result<PathBuf> {
    let folder = workspace.target.join("debian/newer");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    super::ended_well(Command::new("dpkg-deb").arg("-R").arg(package).arg(&folder), "dpkg-deb")?;
    let control = folder.join("DEBIAN/control");
    let version = format!("Version: {}-1", workspace.version()?);
    let text = std::fs::read_to_string(&control)?;
    ensure!(text.contains(&version), "{text}");
    std::fs::write(&control, text.replace(&version, &format!("{version}+1")))?;
    let made = workspace.target.join("debian/newer.deb");
    let mut pack = Command::new("dpkg-deb");
    pack.args(["--root-owner-group", "-Znone", "-b"])
        .arg(&folder)
        .arg(&made);
    super::ended_well(pack.stdout(Stdio::null()), "dpkg-deb")?;
    std::fs::remove_dir_all(&folder)?;
    Ok(made)
}

/// What a person does next. Flights only where the processor is the real one.
fn used(root: &Root, architecture: Architecture) -> Result<()> {
    root.run("skein --version && test -e /usr/share/man/man1/skein.1.gz && test -e /lib/systemd/system/skein.service")?;
    root.run("mkdir -p /tmp/a && cd /tmp/a && HOME=/tmp/a runuser -u skein -- skein doctor")?;
    root.run("rm -r /tmp/a")?;
    if architecture == Architecture::of_this_computer()? {
        root.run("cd /tmp && HOME=/tmp runuser -u nobody -- skein demo --headless --vehicles 3")?;
        println!("{architecture}: the demonstration flew");
    }
    Ok(())
}

/// A minimal Debian; what is done in it is gone afterwards.
struct Root {
    base: PathBuf,
    upper: PathBuf,
    merged: PathBuf,
}

impl Root {
    /// Fetches it if it is not there yet.
    fn open(workspace: &Workspace, architecture: Architecture) -> Result<Self> {
        let base = base(workspace, architecture)?;
        let upper = workspace.target.join("debian").join(format!("used-{architecture}"));
        let root = Self {
            merged: upper.join("merged"),
            base,
            upper,
        };
        root.clear();
        for part in ["upper", "work", "merged"] {
            std::fs::create_dir_all(root.upper.join(part))?;
        }
        Ok(root)
    }

    fn clear(&self) {
        // What is not there needs no removing.
        let _ = std::fs::remove_dir_all(&self.upper);
    }

    fn give(&self, file: &Path, name: &str) -> Result<()> {
        std::fs::copy(file, self.upper.join("upper").join(name))?;
        Ok(())
    }

    /// Runs a line of shell in it, in namespaces of its own: mounts and processes end with it.
    fn run(&self, line: &str) -> Result<()> {
        let said = self.say(line)?;
        ensure!(said.0, "in the Debian of its own: {line}\n{}", said.1);
        Ok(())
    }

    fn say(&self, line: &str) -> Result<(bool, String)> {
        let mount = format!(
            "mount -t overlay overlay -o lowerdir={},upperdir={u}/upper,workdir={u}/work {m} && mount -t proc proc {m}/proc && mount -t tmpfs tmpfs {m}/run && mount --bind /dev {m}/dev && exec chroot {m} /bin/sh -ec \"$0\" 2>&1",
            self.base.display(),
            u = self.upper.display(),
            m = self.merged.display(),
        );
        let output = Command::new("unshare")
            .args([
                "--mount",
                "--pid",
                "--fork",
                "--kill-child",
                "/bin/sh",
                "-c",
                &mount,
                line,
            ])
            .env("DEBIAN_FRONTEND", "noninteractive")
            .env("PATH", "/usr/sbin:/usr/bin:/sbin:/bin")
            .stdin(Stdio::null())
            .output()
            .context("cannot start unshare")?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        Ok((output.status.success(), text))
    }

    /// All that is in it, without what packages write down about themselves.
    fn files(&self) -> Result<BTreeSet<String>> {
        let (found, text) = self.say("find / -xdev -not -path '/proc/*' -not -path '/dev/*' -not -path '/run/*'")?;
        ensure!(found, "{text}");
        let is_kept = |line: &&str| !BOOKKEEPING.iter().any(|folder| line.starts_with(folder));
        Ok(text.lines().filter(is_kept).map(str::to_owned).collect())
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        self.clear();
    }
}

/// A minimal Debian of that architecture, fetched if it is not there yet. Not to be changed.
pub fn base(workspace: &Workspace, architecture: Architecture) -> Result<PathBuf> {
    fetched(
        &folder(workspace, &format!("{RELEASE}-{architecture}")),
        architecture,
        NEEDED,
    )
}

/// The same, which systemd can boot.
pub fn booted_base(workspace: &Workspace, architecture: Architecture) -> Result<PathBuf> {
    fetched(
        &folder(workspace, &format!("{RELEASE}-{architecture}-systemd")),
        architecture,
        &format!("{NEEDED},{BOOTED}"),
    )
}

fn folder(workspace: &Workspace, name: &str) -> PathBuf {
    workspace.target.join("debian").join(name)
}

fn fetched(base: &Path, architecture: Architecture, packages: &str) -> Result<PathBuf> {
    if !base.join("var/lib/dpkg/status").exists() || base.join("debootstrap").exists() {
        fetch(base, architecture, packages)?;
    }
    Ok(base.to_owned())
}

/// By debootstrap; that of another processor runs under qemu, which the kernel calls for it.
fn fetch(base: &Path, architecture: Architecture, packages: &str) -> Result<()> {
    if Command::new("debootstrap").arg("--version").output().is_err() {
        println!("no debootstrap found: installing it through apt-get");
        debian::install("debootstrap").context("install debootstrap")?;
    }
    if architecture != Architecture::of_this_computer()? {
        emulate(architecture)?;
    }
    if base.exists() {
        std::fs::remove_dir_all(base)?;
    }
    println!(
        "fetching a Debian for {architecture} into {} (some minutes, once)",
        base.display()
    );
    let mut fetched = Command::new("debootstrap");
    fetched
        .args([
            "--variant=minbase",
            "--arch",
            &architecture.to_string(),
            "--include",
            packages,
            RELEASE,
        ])
        .arg(base)
        .stdout(Stdio::null());
    super::ended_well(&mut fetched, "debootstrap")
}

/// Lets the kernel run programs of that processor.
fn emulate(architecture: Architecture) -> Result<()> {
    let machine = architecture.machine();
    let entry = format!("/proc/sys/fs/binfmt_misc/qemu-{machine}");
    if Path::new(&entry).exists() {
        return Ok(());
    }
    println!("installing qemu-user-static through apt-get: programs for {architecture} are run by it");
    debian::install("qemu-user-static").context("install qemu-user-static")?;
    debian::install("binfmt-support").context("install binfmt-support")?;
    let mounted = Path::new("/proc/sys/fs/binfmt_misc/register").exists();
    if !mounted {
        let mut mount = Command::new("mount");
        super::ended_well(
            mount.args(["-t", "binfmt_misc", "binfmt_misc", "/proc/sys/fs/binfmt_misc"]),
            "mount",
        )?;
    }
    if !Path::new(&entry).exists() {
        let mut enable = Command::new("update-binfmts");
        super::ended_well(enable.args(["--enable", &format!("qemu-{machine}")]), "update-binfmts")?;
    }
    ensure!(
        Path::new(&entry).exists(),
        "the kernel does not call qemu for {machine}"
    );
    Ok(())
}
