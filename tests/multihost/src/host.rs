//! One host: its configuration, its simulated vehicle, its node; their ends and new starts.
//!
//! Must never do: tell a node anything that it would not be told in the field.

use crate::compose::Composed;
use crate::judge::Track;
use crate::net::{Namespace, Network};
use crate::operator::Operator;
use serde_json::Value;
use skein_testkit::{Process, plugins_dir, skein_binary};
use std::fmt::Write as _;
use std::fs::Permissions;
use std::net::Ipv4Addr;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Origin of the field, for nodes and simulators alike: the truth is in the frame of the swarm.
pub const ORIGIN: [f64; 3] = [47.397_742, 8.545_594, 489.4];
/// Nobody may be further than this from the origin, in metres north, south, east and west.
pub const FENCE_M: f64 = 150.0;
/// Distance that the nodes are configured to keep, in metres.
pub const SEPARATION_M: f64 = 2.0;
/// Secret of an operator who may exchange the version of a supervised node.
pub const OPERATOR: &str = "password";
/// SHA-256 of that.
const OPERATOR_SHA256: &str = "5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8";
/// What systemd does by the unit that ships: starts it again half a second after it ended, but not with a wrong configuration.
const SUPERVISOR: &str = r#"
end() { kill -TERM "$node"; wait "$node"; exit 0; }
trap end INT TERM
while :; do
    "$@" &
    node=$!
    wait "$node"
    code=$?
    echo "the node ended with code $code"
    [ "$code" -eq 64 ] && exit 64
    sleep 0.5
done
"#;
/// Where vehicles send to, on the loopback of their host.
const ENDPOINT: &str = "127.0.0.1:14540";

/// A vehicle whose node is gone stays in OFFBOARD for a second, until its autopilot takes it home, in seconds with some room. A node
/// that is back sooner leaves it to that.
const LEFT_ALONE_S: f64 = 2.0;
/// Stands between a program and its clocks.
const FAKETIME: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1";
/// The file in a host's folder by which its clock is stepped.
const CLOCK: &str = "clock";

/// The swarm's domain, and the ports of its multicast.
const DDS_DOMAIN: u16 = 7;
pub(crate) const DDS_GROUP_PORTS: [u16; 2] = [7400 + 250 * DDS_DOMAIN, 7401 + 250 * DDS_DOMAIN];

/// How the nodes of a swarm reach each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// Zenoh, found by multicast.
    Zenoh,
    /// DDS, found by multicast.
    Dds,
    /// DDS, through an air that does not carry DDS' multicast; every host names all.
    DdsPeers,
    /// DDS stands in for Zenoh.
    Both,
}

/// What a host is.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Its node's priority for the leadership.
    pub priority: Option<u8>,
    /// Where its vehicle stands, north and east in metres; a ground station has none.
    pub vehicle: Option<(f64, f64)>,
    /// The swarm's secret, 64 hexadecimal digits.
    pub secret: String,
    /// How the others are reached.
    pub transport: Transport,
    /// Who may take over in a swarm that has come apart: `every_part` or `majority`.
    pub apart: &'static str,
    /// What its node does with what it flew when it ended: `ask` or `fly_on`.
    pub resume: &'static str,
    /// What its node sends at most, in bytes per second, if not the default.
    pub max_bytes_per_s: Option<f64>,
    /// Its vehicle carries a camera: 640x480, 30 pictures a second, whose pictures are also shown straight over the air.
    pub camera: bool,
    /// Its node's clock of the day can be stepped: see [`Host::step_clock`].
    pub steppable_clock: bool,
    /// Its node is started again whenever it ends, as by systemd, has a state folder, and takes other versions of the program: see [`OPERATOR`].
    pub supervised: bool,
    /// It runs what a compose file says, in place of a configuration of the tests.
    pub composed: Option<Composed>,
}

/// A host. Its number is that of its node, of its vehicle, and the system id of that one.
#[derive(Debug)]
pub struct Host {
    number: u8,
    plan: Plan,
    namespace: Namespace,
    /// All hosts' addresses in the air.
    all: Vec<Ipv4Addr>,
    folder: PathBuf,
    node: Option<Process>,
    /// What nodes that have ended said.
    said: Vec<String>,
    simulation: Option<Process>,
    track: Track,
    /// When its node did not run, in seconds since 1970; the last one may go on.
    away: Vec<(f64, Option<f64>)>,
    starts: u64,
}

/// Seconds since 1970.
#[must_use]
pub fn now_s() -> f64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_secs_f64()
}

impl Host {
    /// Starts its vehicle and its node.
    ///
    /// # Panics
    /// If it cannot.
    #[must_use]
    pub fn start(number: u8, plan: Plan, network: &Network, folders: &Path) -> Self {
        let hosts = network.hosts();
        let namespace = hosts.get(usize::from(number) - 1).expect("there is such a host");
        let folder = folders.join(format!("host-{number}"));
        std::fs::create_dir_all(&folder).expect("a folder for the host");
        let mut host = Self {
            number,
            plan,
            namespace: namespace.clone(),
            all: hosts.iter().map(|host| host.air).collect(),
            track: Track::new(number, folder.join("truth.jsonl")),
            folder,
            node: None,
            said: Vec::new(),
            simulation: None,
            away: Vec::new(),
            starts: 0,
        };
        if let Some(at) = host.plan.vehicle {
            host.simulation = Some(host.simulate(at));
        }
        host.start_node();
        host
    }

    /// Its number.
    #[must_use]
    pub fn number(&self) -> u8 {
        self.number
    }

    /// What it is.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether its node runs.
    #[must_use]
    pub fn lives(&self) -> bool {
        self.node.is_some()
    }

    /// When its node did not run or its vehicle was still without it, in seconds since 1970.
    #[must_use]
    pub fn away(&self) -> &[(f64, Option<f64>)] {
        &self.away
    }

    /// Its network.
    #[must_use]
    pub fn namespace(&self) -> &Namespace {
        &self.namespace
    }

    /// Speaks to its node over HTTP.
    #[must_use]
    pub fn operator(&self) -> Operator {
        Operator::new(self.namespace.manage)
    }

    /// What its simulator has written so far.
    pub fn track(&mut self) -> &Track {
        self.track.read_on();
        &self.track
    }

    /// The same as far as it was read.
    #[must_use]
    pub fn track_so_far(&self) -> &Track {
        &self.track
    }

    /// So often the node of a supervised host has ended so far.
    #[must_use]
    pub fn ends(&self) -> usize {
        self.said()
            .lines()
            .filter(|line| line.starts_with("the node ended with code"))
            .count()
    }

    /// Everything its nodes have said so far.
    #[must_use]
    pub fn said(&self) -> String {
        let now = self.node.as_ref().map(Process::output).unwrap_or_default();
        let mut all = self.said.clone();
        all.push(now);
        all.join("\n")
    }

    /// The log lines with this message, from all its nodes, oldest first.
    #[must_use]
    pub fn log(&self, message: &str) -> Vec<LogLine> {
        let mut lines = self.lines();
        lines.retain(|line| line.message() == message);
        lines
    }

    /// All log lines of all its nodes, oldest first.
    #[must_use]
    pub fn lines(&self) -> Vec<LogLine> {
        self.said().lines().filter_map(LogLine::read).collect()
    }

    /// Ends the node without a word, as if its computer lost power. Gives when, in seconds since 1970.
    ///
    /// # Panics
    /// If it does not run.
    pub async fn kill(&mut self) -> f64 {
        let mut node = self.node.take().expect("the node runs");
        let at_s = now_s();
        node.kill().await;
        self.said.push(node.output());
        self.away.push((at_s, None));
        at_s
    }

    /// Starts the node again, with what it had stored.
    pub fn restart(&mut self) {
        self.start_node();
    }

    /// From within a second on, the clock of the day (`CLOCK_REALTIME`) of its node is so many seconds later than the machine's. The
    /// monotonic clock goes on: no system steps that one.
    ///
    /// # Panics
    /// If it was not planned.
    pub fn step_clock(&self, seconds: i64) {
        assert!(self.plan.steppable_clock, "a host with a clock that can be stepped");
        std::fs::write(self.folder.join(CLOCK), format!("{seconds:+}\n")).expect("the clock can be set");
    }

    /// A copy of what the node has stored, to be put back later.
    #[must_use]
    pub fn state(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let files = std::fs::read_dir(&self.folder).expect("the host's folder");
        let files = files.filter_map(|entry| Some(entry.ok()?.path()));
        let state = files.filter(|path| path.extension().is_some_and(|end| end == "json"));
        state
            .filter_map(|path| Some((path.clone(), std::fs::read(&path).ok()?)))
            .collect()
    }

    /// Puts stored state back.
    ///
    /// # Panics
    /// If a file cannot be written.
    pub fn put_back(&self, state: &[(PathBuf, Vec<u8>)]) {
        for (path, bytes) in state {
            std::fs::write(path, bytes).expect("the state can be written");
        }
    }

    /// Ends its programs in order.
    pub async fn stop(&mut self) {
        for process in [self.node.take(), self.simulation.take()].into_iter().flatten() {
            let mut process = process;
            if process.id().is_some() {
                process.signal("INT").await;
                let _ = process.end(std::time::Duration::from_secs(20)).await;
            }
        }
    }

    fn start_node(&mut self) {
        let file = self.folder.join("node.toml");
        std::fs::write(&file, self.configuration()).expect("the configuration can be written");
        let key = self.folder.join("swarm.key");
        std::fs::write(&key, &self.plan.secret).expect("the secret can be written");
        std::fs::set_permissions(&key, Permissions::from_mode(0o600)).expect("nobody else reads it");
        let mut command = if self.plan.supervised {
            let mut command = self.namespace.command(Path::new("sh"));
            command.args(["-c", SUPERVISOR, "sh"]).arg(skein_binary());
            let state = self.folder.join("state");
            std::fs::create_dir_all(&state).expect("a state folder");
            command.env("STATE_DIRECTORY", state);
            command
        } else {
            self.namespace.command(&skein_binary())
        };
        if self.plan.steppable_clock {
            self.step_clock(0);
            let library = Path::new(FAKETIME);
            assert!(
                library.exists(),
                "{FAKETIME} is missing (Debian: apt-get install libfaketime)"
            );
            command
                .env("LD_PRELOAD", library)
                .env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
            command.env("FAKETIME_TIMESTAMP_FILE", self.folder.join(CLOCK));
            command.env("FAKETIME_CACHE_DURATION", "1");
        }
        match &self.plan.composed {
            Some(composed) => {
                command.args(composed.node(&key, self.namespace.air, self.namespace.manage, self.number));
            }
            None => {
                command.args(["run", "--config"]).arg(&file);
            }
        }
        command.args(["--log", "info", "--log-format", "json"]);
        self.starts += 1;
        let name = format!("node {}, start {}", self.number, self.starts);
        self.node = Some(Process::start(&name, command.into()));
        if let Some((from_s, until)) = self.away.last_mut() {
            until.get_or_insert(now_s().max(*from_s + LEFT_ALONE_S));
        }
    }

    fn simulate(&self, (north_m, east_m): (f64, f64)) -> Process {
        let mut command: Command = self.namespace.command(&skein_binary());
        if let Some(composed) = &self.plan.composed {
            command
                .args(composed.simulation())
                .arg("--truth")
                .arg(self.track.file());
            return Process::start(&format!("vehicle {}", self.number), command.into());
        }
        let number = self.number.to_string();
        let [latitude, longitude, altitude] = ORIGIN;
        command.args([
            "sim",
            "--vehicles",
            "1",
            "--first-system-id",
            &number,
            "--seed",
            &number,
        ]);
        command.args(["--send-to", ENDPOINT]);
        command.args(["--origin", &format!("{latitude},{longitude},{altitude}")]);
        command.args(["--at", &format!("{north_m},{east_m}")]);
        command.arg("--truth").arg(self.track.file());
        Process::start(&format!("vehicle {number}"), command.into())
    }

    /// What carries the swarm, as the configuration lists it, and who is told of this host by unicast.
    fn transports(&self) -> (&'static str, Vec<String>) {
        let named = || self.all.iter().map(ToString::to_string).collect();
        match self.plan.transport {
            Transport::Zenoh => ("\"zenoh\"", Vec::new()),
            Transport::Dds => ("\"dds\"", Vec::new()),
            Transport::DdsPeers => ("\"dds\"", named()),
            Transport::Both => ("\"zenoh\", \"dds\"", Vec::new()),
        }
    }

    fn configuration(&self) -> String {
        let [latitude, longitude, altitude] = ORIGIN;
        let (n, air, manage) = (self.number, self.namespace.air, self.namespace.manage);
        let plugins = plugins_dir();
        let (transports, peers) = self.transports();
        let web = if self.plan.camera {
            Ipv4Addr::UNSPECIFIED
        } else {
            manage
        };
        let (apart, resume) = (self.plan.apart, self.plan.resume);
        let mut text = format!(
            r#"[node]
name = "host-{n}"
[swarm]
origin = {{ latitude_deg = {latitude}, longitude_deg = {longitude}, altitude_amsl_m = {altitude} }}
id = "field-7"
node = {n}
secret_file = "swarm.key"
apart = "{apart}"
transports = [{transports}]
"#
        );
        let mut add = |part: String| text.write_str(&part).expect("a string grows");
        if let Some(priority) = self.plan.priority {
            add(format!("coordinator_priority = {priority}\n"));
        }
        if let Some(most) = self.plan.max_bytes_per_s {
            add(format!("max_bytes_per_s = {most:?}\n"));
        }
        add(format!(
            r#"[swarm.zenoh]
listen = ["udp/{air}:7447"]
multicast = true
[dds]
domain_id = {DDS_DOMAIN}
interfaces = ["{air}"]
peers = {peers:?}
[web]
listen = "{web}:8080"
[plugins]
directories = [{plugins:?}]
[resume]
then = "{resume}"
[safety]
min_separation_m = {SEPARATION_M:?}
[safety.fence]
polygon_m = [[-{FENCE_M:?}, -{FENCE_M:?}], [{FENCE_M:?}, -{FENCE_M:?}], [{FENCE_M:?}, {FENCE_M:?}], [-{FENCE_M:?}, {FENCE_M:?}]]
floor_m = -20.0
ceiling_m = 60.0
"#
        ));
        if self.plan.supervised {
            text += "[upgrade]\naccept = true\n[[operators]]\nname = \"anna\"\nmay_upgrade = true\n";
            text += &format!("token_sha256 = \"{OPERATOR_SHA256}\"\n");
        }
        text + &self.carried()
    }

    /// The part of its configuration that tells of its vehicle.
    fn carried(&self) -> String {
        let mut text = String::new();
        if self.plan.vehicle.is_some() {
            text = format!(
                r#"[[endpoints]]
name = "vehicle"
address = "udp-listen://{ENDPOINT}"
[[adopt]]
name = "uav-{{system_id}}"
model = "generic-uav"
"#
            );
        }
        if self.plan.camera {
            text += r#"[[adopt.payloads]]
name = "camera"
plugin = "camera"
config = { source = "synthetic", width_px = 640, height_px = 480, rate_hz = 30.0, clock = true }
"#;
        }
        text
    }
}

/// One line of a node's log.
#[derive(Debug, Clone)]
pub struct LogLine(Value);

impl LogLine {
    fn read(line: &str) -> Option<Self> {
        serde_json::from_str(line).ok().map(Self)
    }

    /// What happened.
    #[must_use]
    pub fn message(&self) -> &str {
        self.0["fields"]["message"].as_str().unwrap_or_default()
    }

    /// A number that it says.
    #[must_use]
    pub fn number(&self, field: &str) -> Option<u64> {
        let value = &self.0["fields"][field];
        value.as_u64().or_else(|| value.as_str()?.parse().ok())
    }

    /// How long after a moment (in seconds since 1970) it was written, in seconds; no more than a day.
    #[must_use]
    pub fn seconds_after(&self, moment_s: f64) -> Option<f64> {
        let stamp = self.0["timestamp"].as_str()?;
        let (_, time) = stamp.trim_end_matches('Z').split_once('T')?;
        let parts: Vec<f64> = time.split(':').map_while(|part| part.parse().ok()).collect();
        let [hours, minutes, seconds] = parts.try_into().ok()?;
        let day_s = 86_400.0;
        let after_s = (hours * 60.0 + minutes) * 60.0 + seconds - moment_s.rem_euclid(day_s);
        // halves: so that it works over midnight, and a line from before the moment is negative
        Some((after_s + day_s / 2.0).rem_euclid(day_s) - day_s / 2.0)
    }
}
