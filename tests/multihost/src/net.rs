//! The hosts' network namespaces.
//!
//! Each host has two devices. `air` is what its swarm uses: its far end is the [`Relay`], which is all that joins the hosts. `manage` is
//! a pair of virtual Ethernet devices to this process, over which the judge and the operator reach it whatever the air is like; no host
//! reaches another over it, because nothing forwards between them.
//!
//! `ip` of iproute2 makes all that: it is on every Linux machine, and a line of it can be tried by hand, which a netlink library's
//! calls cannot.
//!
//! Must never do: leave anything behind that hinders the next run, or touch a namespace or device that is not its own.

use crate::relay::Relay;
use anyhow::{Context, Result, bail, ensure};
use std::fs::File;
use std::net::Ipv4Addr;
use std::os::fd::AsFd;
use std::path::Path;
use std::process::Command;

/// Names of our namespaces begin like this.
const PREFIX: &str = "skein-mh-";
/// Whoever holds this file's lock has the namespaces.
const LOCK: &str = "/tmp/skein-multihost.lock";

/// One host's place in the network.
#[derive(Debug, Clone)]
pub struct Namespace {
    /// Name of the namespace.
    pub name: String,
    /// Its address in the air.
    pub air: Ipv4Addr,
    /// Where the operator and the judge reach it.
    pub manage: Ipv4Addr,
}

/// All hosts' namespaces, and the air between them. Dropped, everything is gone.
#[derive(Debug)]
pub struct Network {
    hosts: Vec<Namespace>,
    relay: Relay,
    /// Two runs on one machine would take each other's namespaces.
    _lock: File,
}

impl Network {
    /// Makes so many hosts; what an earlier run left behind is removed first. Waits while another run goes on.
    ///
    /// # Errors
    /// Without root, without `ip`, or on a kernel without namespaces or TUN devices.
    pub fn make(hosts: u8, seed: u64) -> Result<Self> {
        let lock = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(LOCK)
            .context(LOCK)?;
        lock.lock().context(LOCK)?;
        clear()?;
        let relay = Relay::start(hosts, seed)
            .context("no TAP devices: this needs root, /dev/net/tun, and a kernel that has them")?;
        let mut network = Self {
            hosts: Vec::new(),
            relay,
            _lock: lock,
        };
        for number in 1..=hosts {
            network.hosts.push(add(number)?);
        }
        Ok(network)
    }

    /// The hosts, in their order.
    #[must_use]
    pub fn hosts(&self) -> &[Namespace] {
        &self.hosts
    }

    /// The air.
    #[must_use]
    pub fn relay(&self) -> &Relay {
        &self.relay
    }

    /// What each host can send from now on, in kilobits per second, by the kernel's token bucket with a queue of 300 ms; `None`: as much as it likes.
    ///
    /// # Panics
    /// When the kernel has no `tbf`.
    pub fn limit_rate(&self, kbit_s: Option<u32>) {
        for host in &self.hosts {
            let done = match kbit_s {
                Some(rate) => {
                    let rate = format!("{rate}kbit");
                    let add = [
                        "qdisc", "replace", "dev", "air", "root", "tbf", "rate", &rate, "burst", "4kb", "latency",
                        "300ms",
                    ];
                    run("tc", &[&["-n", &host.name][..], &add[..]].concat())
                }
                None => run("tc", &["-n", &host.name, "qdisc", "del", "dev", "air", "root"]),
            };
            done.expect("the kernel limits the rate of a device");
        }
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // Where a test fails it is already told what matters.
        let _ = clear();
    }
}

impl Namespace {
    /// Does something on a thread that is in it: sockets made there stay there.
    ///
    /// # Panics
    /// If it cannot be entered, or what is done panics.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        let file = File::open(format!("/run/netns/{}", self.name)).expect("the namespace is there");
        std::thread::scope(|scope| {
            let entered = scope.spawn(|| {
                let kind = Some(rustix::thread::LinkNameSpaceType::Network);
                rustix::thread::move_into_link_name_space(file.as_fd(), kind).expect("root enters namespaces");
                work()
            });
            entered.join().expect("what is done there does not panic")
        })
    }

    /// A program that is to be run in it. `ip` becomes it: the process id is that of the child we start.
    #[must_use]
    pub fn command(&self, program: &Path) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.name]).arg(program);
        command
    }
}

/// Adds one host.
fn add(number: u8) -> Result<Namespace> {
    let name = format!("{PREFIX}{number}");
    let host = Namespace {
        air: Ipv4Addr::new(10, 77, 0, number),
        manage: Ipv4Addr::new(10, 78, number, 2),
        name: name.clone(),
    };
    let n = name.as_str();
    run("ip", &["netns", "add", n])?;
    let (near, tap, mac) = (near(number), Relay::device(number), Relay::mac_text(number));
    run("ip", &["link", "set", &tap, "netns", n, "name", "air", "address", &mac])?;
    run(
        "ip",
        &[
            "link", "add", &near, "type", "veth", "peer", "name", "manage", "netns", n,
        ],
    )?;
    run("ip", &["addr", "add", &format!("10.78.{number}.1/30"), "dev", &near])?;
    run("ip", &["link", "set", &near, "up"])?;
    let inside = |arguments: &[&str]| run("ip", &[&["-n", n][..], arguments].concat());
    inside(&["addr", "add", &format!("{}/24", host.air), "dev", "air"])?;
    inside(&["addr", "add", &format!("{}/30", host.manage), "dev", "manage"])?;
    for device in ["lo", "air", "manage"] {
        inside(&["link", "set", device, "up"])?;
    }
    // multicast and everything else that is not the judge's goes over the air
    inside(&["route", "add", "default", "dev", "air"])?;
    Ok(host)
}

/// The near end of a host's `manage`.
fn near(number: u8) -> String {
    format!("skmh-man{number}")
}

/// Removes everything of ours, with the programs in it.
fn clear() -> Result<()> {
    let list = output("ip", &["netns", "list"])?;
    let names = list.lines().filter_map(|line| line.split_whitespace().next());
    for name in names.filter(|name| name.starts_with(PREFIX)) {
        for id in output("ip", &["netns", "pids", name])?.split_whitespace() {
            let _ = run("kill", &["-KILL", id]);
        }
        if let Some(number) = name.strip_prefix(PREFIX).and_then(|n| n.parse().ok()) {
            // goes with the namespace, but only after a while
            let _ = run("ip", &["link", "del", &near(number)]);
        }
        run("ip", &["netns", "del", name])?;
    }
    Ok(())
}

fn run(program: &str, arguments: &[&str]) -> Result<()> {
    output(program, arguments).map(drop)
}

fn output(program: &str, arguments: &[&str]) -> Result<String> {
    let done = Command::new(program).args(arguments).output();
    let done = match done {
        Ok(done) => done,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            bail!("there is no `{program}`; it comes with iproute2 (Debian: apt-get install iproute2)")
        }
        Err(error) => return Err(error).context(program.to_owned()),
    };
    ensure!(
        done.status.success(),
        "{program} {}: {}",
        arguments.join(" "),
        String::from_utf8_lossy(&done.stderr).trim()
    );
    Ok(String::from_utf8_lossy(&done.stdout).into_owned())
}
