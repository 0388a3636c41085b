//! The package as a service: a Debian of its own is booted by systemd, in a container of systemd-nspawn, and `service.sh` installs the package there, flies a
//! simulated vehicle with it, stops and kills its node in flight, upgrades it, and tells what holds.
//!
//! Must never do: touch this computer's own services or network, or leave anything in the Debian that it boots.

use super::{Architecture, chroot};
use crate::debian;
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};

/// What the container runs instead of what it would boot into. Its output and exit status are written beside it: the console is systemd's.
const RUN: &str = "#!/bin/sh\n/bin/sh /check/service.sh >/check/said 2>&1\necho $? >/check/status\n";
/// So long the whole takes at most, in seconds.
const MOST_S: &str = "900";

/// The node of the vehicle, which the service runs.
const VEHICLE: &str = r#"
[swarm]
id = "field"
node = 2
secret_file = "/etc/skein/swarm.key"
transports = ["zenoh"]
max_bytes_per_s = 50000000.0
[swarm.zenoh]
listen = ["tcp/127.0.0.1:7447"]
multicast = false
[[endpoints]]
name = "autopilot"
address = "udp-listen://127.0.0.1:14540"
[[adopt]]
endpoint = "autopilot"
name = "uav-{system_id}"
model = "generic-uav"
[[adopt.payloads]]
name = "camera"
plugin = "camera"
isolation = "child"
config = { source = "synthetic", rate_hz = 1.0, width_px = 320, height_px = 240 }
[plugins]
directories = ["/usr/lib/skein/plugins"]
[web]
listen = "127.0.0.1:8081"
[upgrade]
accept = true
"#;

/// The ground station, which coordinates and upgrades.
const GROUND: &str = r#"
[swarm]
id = "field"
node = 1
secret_file = "/root/swarm.key"
transports = ["zenoh"]
coordinator_priority = 200
max_bytes_per_s = 50000000.0
[swarm.zenoh]
connect = ["tcp/127.0.0.1:7447"]
multicast = false
[plugins]
directories = ["/usr/lib/skein/plugins"]
[web]
listen = "127.0.0.1:8080"
[upgrade]
accept = true
[[operators]]
name = "check"
may_upgrade = true
# of the word "secret", which the check knows too
token_sha256 = "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b"
"#;

/// Boots the container: `$0` the longest time, `$1` the base, `$2` what is bound. Where no systemd runs, its control groups are mounted first, in a mount
/// namespace of their own.
const BOOT: &str = r#"
if [ ! -e /sys/fs/cgroup/cgroup.controllers ]; then
    cd /sys/fs/cgroup
    mkdir -p systemd unified
    mountpoint -q systemd || mount -t cgroup -o none,name=systemd cgroup systemd
    mountpoint -q unified || mount -t cgroup2 cgroup2 unified
    cd /
fi
exec timeout "$0" systemd-nspawn --quiet --directory="$1" --volatile=overlay --private-network --register=no --keep-unit "$2" --boot \
    systemd.run=/check/run systemd.run_success_action=poweroff systemd.run_failure_action=poweroff
"#;

/// Boots it, and says what the check has said.
pub fn check(workspace: &Workspace, architecture: Architecture, package: &Path) -> Result<()> {
    if Command::new("systemd-nspawn").arg("--version").output().is_err() {
        println!("no systemd-nspawn found: installing it through apt-get");
        debian::install("systemd-container").context("install systemd-container")?;
    }
    let base = chroot::booted_base(workspace, architecture)?;
    let given = workspace.target.join("debian/service");
    if given.exists() {
        fs::remove_dir_all(&given)?;
    }
    fs::create_dir_all(&given)?;
    give(&given, package)?;
    println!("{architecture}: booting a Debian with the service (some minutes)");
    let console = fs::File::create(given.join("console"))?;
    let mut boot = Command::new("unshare");
    boot.args(["--mount", "/bin/sh", "-ec", BOOT, MOST_S])
        .arg(&base)
        .arg(format!("--bind={}:/check", given.display()))
        .stdin(Stdio::null())
        .stdout(console.try_clone()?)
        .stderr(console);
    // What it returns says how the container ended, not what was found in it.
    let ended = boot.status().context("cannot start unshare")?;
    let said = fs::read_to_string(given.join("said")).unwrap_or_default();
    let status = fs::read_to_string(given.join("status")).unwrap_or_default();
    print!("{said}");
    ensure!(
        status.trim() == "0",
        "the service is not as it should be (the container: {ended}); see {}",
        given.join("console").display()
    );
    println!("{architecture}: the service flies, comes back in flight, is upgraded, and goes back");
    fs::remove_dir_all(&given)?;
    Ok(())
}

/// What the check needs, in a folder that the container sees.
fn give(folder: &Path, package: &Path) -> Result<()> {
    fs::copy(package, folder.join("skein.deb"))?;
    fs::write(folder.join("vehicle.toml"), VEHICLE)?;
    fs::write(folder.join("ground.toml"), GROUND)?;
    // Of no swarm but this one.
    fs::write(folder.join("swarm.key"), "0123456789abcdef".repeat(4) + "\n")?;
    fs::write(folder.join("service.sh"), include_str!("service.sh"))?;
    let run = folder.join("run");
    fs::write(&run, RUN)?;
    fs::set_permissions(&run, fs::Permissions::from_mode(0o755))?;
    Ok(())
}
