//! `skein doctor`: looks at what keeps a node from running on this machine and says how to mend each.

mod parameters;
mod running;

use crate::args::DoctorArguments;
use crate::run::state_directory;
use running::Node;
use skein_config::{NodeConfig, Overlay};
use skein_link_mavlink::EndpointAddress;
use skein_node::plugins_beside_program;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::ErrorKind;
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

/// Open files a node with many links and dashboards may need.
const FILES_WANTED: u64 = 1024;
/// An hour of video of one camera at 4 Mbit/s, in megabytes.
const ROOM_WANTED_MB: u64 = 2000;
/// Receive buffer in bytes that a hundred vehicles can fill within one late period.
const RECEIVE_BUFFER_WANTED: u64 = 200_000;

/// What was found so far, as it is printed.
#[derive(Default)]
struct Findings {
    lines: Vec<String>,
    is_bad: bool,
}

impl Findings {
    fn good(&mut self, what: impl Display) {
        self.lines.push(format!("  ok    {what}"));
    }

    /// Works, but not well.
    fn poor(&mut self, what: impl Display, mend: impl Display) {
        self.lines.push(format!("  warn  {what}\n        mend: {mend}"));
    }

    /// Will not work.
    fn bad(&mut self, what: impl Display, mend: impl Display) {
        self.lines.push(format!("  BAD   {what}\n        mend: {mend}"));
        self.is_bad = true;
    }

    /// Prints them all, and what follows from them.
    fn told(&self, if_bad: &str, if_good: &str) -> ExitCode {
        self.lines.iter().for_each(|line| println!("{line}"));
        println!("{}", if self.is_bad { if_bad } else { if_good });
        if self.is_bad {
            ExitCode::from(crate::exit::FAILED)
        } else {
            ExitCode::SUCCESS
        }
    }
}

/// Runs all checks and prints them: of this computer, or of a node that runs.
///
/// # Errors
/// A file of parameters cannot be used, or the node ends meanwhile. What is wrong otherwise is a finding, and the exit code.
pub async fn doctor(arguments: &DoctorArguments) -> anyhow::Result<ExitCode> {
    let mut findings = Findings::default();
    if let Some(url) = &arguments.node {
        let node = Node::at(url)?;
        node.is_well(&mut findings).await;
        if !findings.is_bad && !arguments.brief {
            node.examine(&mut findings).await?;
        }
        if let (Some(vehicle), Some(file), false) = (arguments.vehicle, &arguments.parameters, findings.is_bad) {
            node.compare(vehicle, file, &mut findings).await?;
        }
        return Ok(findings.told("The node is not well.", "The node is well."));
    }
    let config = configuration(arguments, &mut findings);
    plugins(&config, &mut findings);
    ports(&config, &mut findings);
    in_swarm(&config, &mut findings);
    clock(&mut findings);
    synchronised(&mut findings);
    disk(&config, &mut findings);
    limits(&mut findings);
    priority(&mut findings);
    Ok(findings.told(
        "A node will not run here as it is.",
        "Nothing keeps a node from running here.",
    ))
}

/// The swarm of several nodes, where the configuration names one: secret, and the file of the obeyed term.
fn in_swarm(config: &NodeConfig, findings: &mut Findings) {
    let settings = &config.swarm;
    let Some(id) = &settings.id else { return };
    match skein_node::setup(settings, &Arc::default()) {
        Ok(_) => findings.good(format_args!("swarm: the secret of {id} can be read")),
        Err(error) => findings.bad(error.to_string(), "see the line above"),
    }
    if let Some(file) = &settings.state_file {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or_else(|| std::path::Path::new("."));
        let probe = folder.join(format!(".{id}.doctor"));
        match std::fs::write(&probe, b"") {
            Ok(()) => {
                // Nothing rests on its being gone.
                let _ = std::fs::remove_file(&probe);
                findings.good(format_args!("swarm: {} can be written", folder.display()));
            }
            Err(error) => findings.bad(
                format_args!("swarm.state_file: {} cannot be written: {error}", folder.display()),
                "name a file in a folder that this user may write to: a node that cannot keep whom it obeys tells nobody anything",
            ),
        }
    }
}

/// The configuration to check the rest with: the given one, or the default with the plugins beside the program.
fn configuration(arguments: &DoctorArguments, findings: &mut Findings) -> NodeConfig {
    let mut default = NodeConfig::default();
    default.plugins.directories = vec![arguments.plugins.clone().unwrap_or_else(plugins_beside_program)];
    let Some(path) = &arguments.config else {
        findings.good("configuration: the default, none was given");
        return default;
    };
    let overlay = Overlay {
        set: arguments.set.clone(),
        state: state_directory(),
    };
    match NodeConfig::load_with(path, &overlay) {
        Ok(config) => {
            findings.good(format_args!("configuration: {} is right", path.display()));
            if config.hears_nobody() {
                findings.poor(
                    "configuration: no [[endpoints]], so that no vehicle will be heard",
                    "add one, for example: address = \"udp-listen://127.0.0.1:14540\"",
                );
            }
            config
        }
        Err(error) => {
            findings.bad(
                format_args!("configuration: {error}"),
                "correct the key that is named; default.toml documents each",
            );
            default
        }
    }
}

fn plugins(config: &NodeConfig, findings: &mut Findings) {
    let catalog = skein_runtime::catalog(config);
    for plugin in catalog.plugins() {
        let manifest = plugin.manifest();
        findings.good(format_args!(
            "plugin: {} {} from {}",
            manifest.name,
            manifest.version,
            plugin.path().display()
        ));
    }
    for problem in catalog.problems() {
        findings.bad(
            format_args!("plugin: {}: {}", problem.path.display(), problem.error),
            "rebuild it (cargo xtask build-plugins) or take it out of the directory",
        );
    }
    let mut names: BTreeSet<&str> = config.adopt.iter().map(|rule| rule.model.as_str()).collect();
    names.extend(
        config
            .adopt
            .iter()
            .flat_map(|rule| rule.payloads.iter().map(|p| p.plugin.as_str())),
    );
    if config.adopt.is_empty() {
        // What the first rule that anyone writes will name.
        names.insert("generic-uav");
    }
    for name in names.into_iter().filter(|name| catalog.get(name).is_none()) {
        findings.bad(
            format_args!("plugin: the plugin \"{name}\" was not found"),
            "cargo xtask build-plugins, or name its directory in plugins.directories",
        );
    }
}

fn ports(config: &NodeConfig, findings: &mut Findings) {
    let web = config.web.listen;
    match TcpListener::bind(web) {
        Ok(_) => findings.good(format_args!("port: {web} is free for the dashboard")),
        Err(error) => findings.bad(
            format_args!("port: {web} for the dashboard: {error}"),
            "stop the program that uses it (ss -ltnp), or change web.listen",
        ),
    }
    if !web.ip().is_loopback() {
        findings.poor(
            format_args!("web.listen {web} can be reached from other machines, and there is no log-in yet"),
            "use 127.0.0.1 and an SSH tunnel, or a network that is yours alone",
        );
    }
    for endpoint in &config.endpoints {
        match endpoint.address.parse::<EndpointAddress>() {
            Ok(EndpointAddress::UdpListen(address)) => match UdpSocket::bind(address) {
                Ok(_) => findings.good(format_args!("port: {} is free", endpoint.address)),
                Err(error) => findings.bad(
                    format_args!("port: {}: {error}", endpoint.address),
                    "stop the program that uses it (ss -lunp), or change the endpoint's address",
                ),
            },
            Ok(EndpointAddress::Serial { path, .. }) => device(&path, findings),
            Ok(_) => findings.good(format_args!("endpoint: {} is understood", endpoint.address)),
            Err(error) => findings.bad(
                format_args!("endpoint: {}: {error}", endpoint.address),
                "write it as default.toml shows",
            ),
        }
    }
}

/// A serial port: there, and this user's to open.
fn device(path: &str, findings: &mut Findings) {
    match OpenOptions::new().read(true).write(true).open(path) {
        Ok(_) => findings.good(format_args!("device: {path} can be opened")),
        Err(error) if error.kind() == ErrorKind::NotFound => findings.bad(
            format_args!("device: {path} does not exist"),
            "plug it in, or look for it with: ls /dev/tty* /dev/autopilot",
        ),
        Err(error) => findings.bad(
            format_args!("device: {path}: {error}"),
            "sudo adduser $USER dialout, and log in again; or end the program that has it (lsof)",
        ),
    }
}

/// Whether something keeps the clock right. Recordings and detections of several computers are laid side by side by it.
fn synchronised(findings: &mut Findings) {
    let said = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok()?;
        output
            .status
            .success()
            .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let by_chrony = said("chronyc", &["-c", "tracking"]).map(|line| !line.contains("Not synchronised"));
    let by_systemd =
        said("timedatectl", &["show", "--property=NTPSynchronized", "--value"]).map(|text| text.trim() == "yes");
    match by_chrony.or(by_systemd) {
        Some(true) => findings.good("clock: it is kept right over the network"),
        Some(false) => findings.poor(
            "clock: it is not synchronised",
            "chronyc sources; a field without internet needs one computer as its server (allow 10.0.0.0/24, local stratum 10)",
        ),
        None => findings.poor("clock: nothing keeps it right", "apt install chrony"),
    }
}

/// Room for recordings.
fn disk(config: &NodeConfig, findings: &mut Findings) {
    let recordings = config.video.recordings.clone().unwrap_or_default();
    let there = recordings
        .ancestors()
        .find(|folder| folder.is_dir())
        .unwrap_or(Path::new("."));
    let Ok(system) = rustix::fs::statvfs(there) else { return };
    let free_mb = system.f_bavail * system.f_frsize / 1_000_000;
    if free_mb < ROOM_WANTED_MB {
        let mend = "take old recordings away, or name another disk in video.recordings";
        findings.poor(format_args!("disk: {free_mb} MB are free at {}", there.display()), mend);
    } else {
        findings.good(format_args!("disk: {free_mb} MB are free at {}", there.display()));
    }
}

fn clock(findings: &mut Findings) {
    // 2025-01-01: a computer without a battery-backed clock starts in 1970.
    let oldest = SystemTime::UNIX_EPOCH + Duration::from_secs(1_735_689_600);
    if SystemTime::now() < oldest {
        findings.bad(
            "clock: the date is wrong",
            "set it (timedatectl set-ntp true); recordings of several nodes could not be compared",
        );
    } else {
        findings.good("clock: the date is plausible");
    }
    let asked = Duration::from_millis(10);
    let begin = Instant::now();
    std::thread::sleep(asked);
    let late = begin.elapsed().saturating_sub(asked);
    if late > Duration::from_millis(10) {
        findings.poor(
            format_args!("clock: a sleep of 10 ms came back {} ms late", late.as_millis()),
            "other programs keep the processor busy; setpoints will be late too",
        );
    } else {
        findings.good(format_args!(
            "clock: sleeps end within {:.1} ms",
            late.as_secs_f64() * 1e3
        ));
    }
}

fn priority(findings: &mut Findings) {
    match skein_realtime::is_permitted() {
        Ok(()) => findings.good("priority: threads that setpoints wait for run in real time"),
        Err(error) => findings.poor(
            format_args!("priority: no thread may run in real time: {error}; other programs make setpoints late"),
            "LimitRTPRIO=10 in its systemd unit, `- rtprio 10` in /etc/security/limits.conf, or the capability SYS_NICE for a container",
        ),
    }
}

fn limits(findings: &mut Findings) {
    let text = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let files = text("/proc/self/limits")
        .lines()
        .find(|line| line.starts_with("Max open files"))
        .and_then(|line| {
            line.split_whitespace()
                .nth(3)
                .map(|soft| soft.parse().unwrap_or(u64::MAX))
        });
    match files {
        Some(files) if files < FILES_WANTED => findings.poor(
            format_args!("limits: {files} open files"),
            format_args!("ulimit -n {FILES_WANTED}"),
        ),
        Some(files) => findings.good(format_args!("limits: {files} open files")),
        None => {}
    }
    if let Ok(buffer) = text("/proc/sys/net/core/rmem_max").trim().parse::<u64>() {
        if buffer < RECEIVE_BUFFER_WANTED {
            findings.poor(
                format_args!("limits: sockets may buffer only {buffer} bytes"),
                "sysctl -w net.core.rmem_max=4194304, for many vehicles on one port",
            );
        } else {
            findings.good(format_args!("limits: sockets may buffer {buffer} bytes"));
        }
    }
}
