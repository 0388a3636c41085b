//! Whether hosts can be made on this machine for the tier `multihost`: network namespaces and TAP devices, and `ip` to make them with.
//!
//! Must never do: leave anything behind on the machine but an installed package.

use crate::debian;
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A namespace that is made and removed again to see whether it can be.
const PROBE: &str = "skein-probe";
/// Names of the tests' namespaces begin like this, and whoever holds this file's lock has them.
const PREFIX: &str = "skein-mh-";
const LOCK: &str = "/tmp/skein-multihost.lock";
/// A program that was killed keeps its locks until the last of its threads is gone, which is after its first one.
const LOOKS: u32 = 100;
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Steps the clock of one node; the flights look for it here.
const FAKETIME: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1";

/// Whether they can be made; `ip` is installed if it is not there and that is possible.
pub fn can_be_made() -> Result<()> {
    if !runs("ip", &["-V"]) || !runs("tc", &["-V"]) {
        println!("no ip and tc found: installing iproute2 through apt-get");
        debian::install("iproute2").context("install iproute2")?;
    }
    if !Path::new(FAKETIME).exists() {
        println!("no libfaketime found: installing it through apt-get");
        debian::install("libfaketime").context("install libfaketime")?;
    }
    ensure!(Path::new("/dev/net/tun").exists(), "there is no /dev/net/tun");
    let made = runs("ip", &["netns", "add", PROBE]);
    let removed = runs("ip", &["netns", "del", PROBE]);
    ensure!(
        made && removed,
        "network namespaces cannot be made: that needs root, and a kernel that has them"
    );
    Ok(())
}

/// Removes the hosts that an interrupted run has left, unless another run has them. The tests make them (`tests/multihost/src/net.rs`), and
/// remove them where they come to their end.
pub fn clear() {
    let Ok(lock) = std::fs::File::open(LOCK) else { return };
    let mut looks = 0..LOOKS;
    while lock.try_lock().is_err() {
        if looks.next().is_none() {
            return;
        }
        std::thread::sleep(LOOK_EVERY);
    }
    for name in std::fs::read_dir("/run/netns").into_iter().flatten().flatten() {
        if let Some(name) = name.file_name().to_str().filter(|name| name.starts_with(PREFIX)) {
            runs("ip", &["netns", "del", name]);
        }
    }
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
