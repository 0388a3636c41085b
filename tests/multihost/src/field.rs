//! All hosts of a flight.
//!
//! Must never do: wait for anything without an end, or end a flight without having looked at the whole truth.

use crate::host::{DDS_GROUP_PORTS, FENCE_M, Host, Plan, SEPARATION_M, Transport};
use crate::judge::{self, Nearest, Track};
use crate::net::Network;
use crate::relay::Relay;
use reqwest::Method;
use serde_json::{Value, json};
use skein_domain::{PositionNed, VelocityNed};
use std::fmt;
use std::time::Duration;
use tempfile::TempDir;
use tokio::time::Instant;

/// How often something waited for is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Longest time between two setpoints while the vehicle's own node runs, in seconds.
const GAP_S: f64 = 0.2;
/// The hosts of the usual swarm: a ground station and five vehicles.
pub const HOSTS: u8 = 6;
/// A node that was last heard longer ago is not there, in seconds.
const HEARD_S: f64 = 2.0;
/// The ground station's number.
pub const GROUND: u8 = 1;
pub(crate) const SECRET: &str = "7c1f0e5b9a8d4c3b2a1908f7e6d5c4b3a29180f7e6d5c4b3a2918070f6e5d4c3";
/// The secret of somebody else's swarm of the same name.
const OTHER_SECRET: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";

/// A ground station that may coordinate if no vehicle can, and five vehicles in two rows, the first one best suited.
#[must_use]
pub fn usual() -> Vec<Plan> {
    let host = |priority: u8, vehicle| Plan {
        priority: Some(priority),
        vehicle,
        secret: SECRET.to_owned(),
        transport: Transport::Zenoh,
        apart: "every_part",
        resume: "ask",
        max_bytes_per_s: None,
        camera: false,
        steppable_clock: false,
        supervised: false,
        composed: None,
    };
    let place = |i: u8| (4.0 * f64::from(i % 2), 6.0 * f64::from(i));
    let vehicles = (0..HOSTS - 1).map(|i| host(60 - 10 * i, Some(place(i))));
    std::iter::once(host(5, None)).chain(vehicles).collect()
}

/// A host of another swarm, which has the same name and addresses, and would be best suited.
#[must_use]
pub fn stranger() -> Plan {
    Plan {
        priority: Some(200),
        vehicle: Some((30.0, 0.0)),
        secret: OTHER_SECRET.to_owned(),
        ..usual().remove(0)
    }
}

/// Hosts, the air between them, and the judge's records.
#[derive(Debug)]
pub struct Field {
    // in this order: programs end before their network is taken away
    hosts: Vec<Host>,
    network: Network,
    folder: TempDir,
}

/// What the judge found.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// Where two vehicles were nearest.
    pub nearest: Option<Nearest>,
    /// Each vehicle's longest time without a setpoint while its node ran, in seconds, and when in seconds since 1970.
    pub gaps: Vec<(u8, f64, f64)>,
    /// How far anyone was outside of the fence, in metres.
    pub outside_m: f64,
    /// Vehicles that are not down.
    pub up: Vec<u8>,
}

impl Field {
    /// Starts these hosts.
    ///
    /// # Panics
    /// If the machine does not let network namespaces be made, or a host does not start.
    pub fn start(seed: u64, plans: Vec<Plan>) -> Self {
        let count = u8::try_from(plans.len()).expect("a few hosts");
        let network = Network::make(count, seed)
            .unwrap_or_else(|error| panic!("the hosts' networks cannot be made, so nothing is shown: {error:#}"));
        let folder = tempfile::tempdir().expect("a folder");
        if plans.iter().any(|plan| plan.transport == Transport::DdsPeers) {
            for port in DDS_GROUP_PORTS {
                network.relay().close_port(port);
            }
        }
        let hosts = (1..=count)
            .zip(plans)
            .map(|(number, plan)| Host::start(number, plan, &network, folder.path()))
            .collect();
        Self { hosts, network, folder }
    }

    /// A host by its number.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn host(&self, number: u8) -> &Host {
        self.hosts
            .iter()
            .find(|h| h.number() == number)
            .expect("there is such a host")
    }

    /// The same, for what changes it.
    ///
    /// # Panics
    /// If there is none.
    pub fn host_mut(&mut self, number: u8) -> &mut Host {
        let mut hosts = self.hosts.iter_mut();
        hosts.find(|h| h.number() == number).expect("there is such a host")
    }

    /// The air between them.
    #[must_use]
    pub fn air(&self) -> &Relay {
        self.network.relay()
    }

    /// The network as a whole.
    #[must_use]
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Numbers of hosts whose node runs.
    #[must_use]
    pub fn living(&self) -> Vec<u8> {
        self.hosts.iter().filter(|h| h.lives()).map(Host::number).collect()
    }

    /// Numbers of hosts that have a vehicle.
    #[must_use]
    pub fn vehicles(&self) -> Vec<u8> {
        let with = self.hosts.iter().filter(|h| h.plan().vehicle.is_some());
        with.map(Host::number).collect()
    }

    /// Waits until this is so.
    ///
    /// # Panics
    /// If it does not become so; the message says what each node says of the swarm and where the vehicles are.
    pub async fn until(&mut self, what: &str, within_s: f64, mut so: impl AsyncFnMut(&mut Self) -> bool) {
        let deadline = Instant::now() + Duration::from_secs_f64(within_s);
        while !so(self).await {
            if Instant::now() > deadline {
                let picture = self.picture().await;
                panic!("waited {within_s} s in vain for {what}\n{picture}");
            }
            tokio::time::sleep(LOOK_EVERY).await;
        }
    }

    /// Lets the flight go on for a while.
    pub async fn pass(&mut self, seconds: f64) {
        tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
    }

    /// Waits until these nodes hear each other and obey one coordinator, which is one of them. Gives its number.
    ///
    /// # Panics
    /// If they do not.
    pub async fn one_swarm(&mut self, of: &[u8], within_s: f64) -> u8 {
        let what = format!("{of:?} to be one swarm under one coordinator");
        let mut coordinator = None;
        let led = async |field: &mut Self| {
            coordinator = field.coordinator_of(of).await;
            coordinator.is_some()
        };
        self.until(&what, within_s, led).await;
        coordinator.expect("it was waited for")
    }

    /// The same, and has this node coordinate if another one was up earlier: nobody takes the leadership from a coordinator without being asked.
    ///
    /// # Panics
    /// If it does not come to it.
    pub async fn led_by(&mut self, coordinator: u8, of: &[u8], within_s: f64) {
        if self.one_swarm(of, within_s).await != coordinator {
            let operator = self.host(coordinator).operator();
            let ask = Some(json!({ "node": coordinator }));
            let answer = operator.ask(Method::POST, "/api/v1/swarm/coordinator", ask).await;
            assert!(
                answer.is_success(),
                "node {coordinator} does not take the leadership: {answer:?}"
            );
        }
        let what = format!("{of:?} to be led by {coordinator}");
        let led = async |field: &mut Self| field.coordinator_of(of).await == Some(coordinator);
        self.until(&what, within_s, led).await;
    }

    /// The one coordinator that all these nodes obey and whom all hear, if it is so.
    pub async fn coordinator_of(&self, of: &[u8]) -> Option<u8> {
        let mut obeyed: Option<Value> = None;
        let mut acting = Vec::new();
        for number in of {
            let swarm = self.host(*number).operator().swarm().await;
            let nodes = swarm["nodes"].as_array()?;
            let is_heard = |node: &&Value| node["heard_s"].as_f64().is_some_and(|s| s < HEARD_S);
            let heard: Vec<u64> = nodes
                .iter()
                .filter(is_heard)
                .filter_map(|node| node["node"].as_u64())
                .collect();
            let hears = |other: &u8| other == number || heard.contains(&u64::from(*other));
            let term = &swarm["term"];
            let led = swarm["acting"] == Value::Bool(true) || swarm["leader_state"] == "led";
            if !of.iter().all(hears) || !led || term.is_null() || obeyed.get_or_insert_with(|| term.clone()) != term {
                return None;
            }
            if swarm["acting"] == Value::Bool(true) {
                acting.push(*number);
            }
        }
        let holder = obeyed?["coordinator"].as_u64()?;
        match acting.as_slice() {
            [one] if u64::from(*one) == holder => Some(*one),
            _ => None,
        }
    }

    /// Where these vehicles are and how fast, now.
    ///
    /// # Panics
    /// If a simulator has not said anything yet.
    pub fn places(&mut self, of: &[u8]) -> Vec<(PositionNed, VelocityNed)> {
        let last = |number: &u8| {
            let track = self.host_mut(*number).track();
            let line = track.last().unwrap_or_else(|| panic!("vehicle {number} has no truth"));
            (line.position, line.velocity)
        };
        of.iter().map(last).collect()
    }

    /// Whether these vehicles stand on the ground with motors off.
    pub fn are_down(&mut self, of: &[u8]) -> bool {
        of.iter().all(|number| self.host_mut(*number).track().is_down())
    }

    /// What was seen from the start until now.
    pub fn verdict(&mut self) -> Verdict {
        let numbers = self.vehicles();
        for number in &numbers {
            self.host_mut(*number).track();
        }
        let tracks: Vec<&Track> = numbers.iter().map(|n| self.host(*n).track_so_far()).collect();
        let gap = |track: &&Track| {
            let (gap_s, at_s) = track.longest_gap(self.host(track.host()).away());
            (track.host(), gap_s, at_s)
        };
        Verdict {
            nearest: judge::nearest(tracks.iter().copied()),
            gaps: tracks.iter().map(gap).collect(),
            outside_m: tracks.iter().map(|t| t.outside_m(FENCE_M)).fold(0.0, f64::max),
            up: tracks.iter().filter(|t| !t.is_down()).map(|t| t.host()).collect(),
        }
    }

    /// Judges the flight, all vehicles but these to be down, and ends all programs.
    ///
    /// # Panics
    /// If something was not kept; the output of all programs is printed then.
    pub async fn end(mut self, flight: &str, still_up: &[u8]) {
        let verdict = self.verdict();
        println!("{flight}: {verdict}");
        verdict.is_safe();
        verdict.all_down_but(still_up);
        for host in &mut self.hosts {
            host.stop().await;
        }
    }

    /// Everything at this moment, in words.
    async fn picture(&mut self) -> String {
        let mut text = String::new();
        for number in self.living() {
            let operator = self.host(number).operator();
            let fleet = operator.fleet().await;
            let vehicles = fleet["vehicles"].as_array().cloned().unwrap_or_default();
            let vehicles = vehicles.iter().map(|v| {
                let refused = v["state_detail"].as_str().unwrap_or_default();
                format!("{} {} {} {refused}", v["id"], v["flight_state"], v["mode"])
            });
            let vehicles: Vec<String> = vehicles.collect();
            text += &format!(
                "node {number}: swarm {}\n  fleet {vehicles:?}\n",
                operator.swarm().await
            );
        }
        for number in self.vehicles() {
            let line = self.host_mut(number).track().last().cloned();
            text += &format!("vehicle {number}: {line:?}\n");
        }
        text
    }
}

impl Drop for Field {
    fn drop(&mut self) {
        if std::thread::panicking() && std::env::var_os("SKEIN_KEEP").is_some() {
            let folder = self.folder.path();
            println!("what the hosts wrote stays in {}", folder.display());
            for host in &self.hosts {
                let file = folder.join(format!("host-{}", host.number())).join("log.jsonl");
                let _ = std::fs::write(file, host.said());
            }
            self.folder.disable_cleanup(true);
        }
    }
}

impl Verdict {
    /// What holds whatever happens: distances, setpoints, the fence.
    ///
    /// # Panics
    /// If one of them was not kept.
    fn is_safe(&self) {
        let near = self.nearest.as_ref().expect("somebody flew");
        assert!(near.distance_m >= SEPARATION_M, "too near: {self}");
        assert!(
            self.gaps.iter().all(|(_, gap_s, _)| *gap_s <= GAP_S),
            "no setpoints: {self}"
        );
        assert!(self.outside_m <= 0.0, "outside of the fence: {self}");
    }

    /// All but these vehicles are down at the end.
    ///
    /// # Panics
    /// If one is not.
    fn all_down_but(&self, up: &[u8]) {
        assert!(self.up.iter().all(|host| up.contains(host)), "still up: {self}");
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.nearest {
            Some(n) => write!(
                f,
                "nearest {:.2} m (vehicles {} and {}, {:?}, at {:.2} s)",
                n.distance_m, n.hosts.0, n.hosts.1, n.places, n.time_s
            )?,
            None => write!(f, "nobody flew")?,
        }
        write!(f, "; longest gaps")?;
        for (host, gap_s, at_s) in &self.gaps {
            write!(f, " {host}: {:.0} ms at {at_s:.1}", gap_s * 1000.0)?;
        }
        write!(
            f,
            "; outside of the fence {:.1} m; not down: {:?}",
            self.outside_m, self.up
        )
    }
}
