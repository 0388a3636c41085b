//! A node that joins a swarm on a slow radio is brought up gradually: commands to others hardly wait for it. Time is simulated; the figures are printed.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_bus::budget::BudgetSettings;
use skein_bus::bus::Bus;
use skein_bus::envelope::{Boot, SwarmKey};
use skein_bus::latest::Key;
use skein_bus::local::{Hub, Local};
use skein_bus::radio::{Air, AirSettings, Radio};
use skein_bus::{BusSettings, Event, pump};
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, BTreeSet};

const NODES: u64 = 25;
const STEP_US: u64 = 5_000;
/// 256 kbit/s for all together.
const AIR: AirSettings = AirSettings {
    range_m: f64::INFINITY,
    path_loss_exponent: 2.5,
    fade_db: 1.5,
    bits_per_s: 256e3,
    overhead_bytes: 40,
    longest_wait_s: 1.0,
    loss: 0.02,
    delay_s: 0.005,
    jitter_s: 0.005,
    doubles: 0.0,
};
/// Values that each node tells and hardly ever changes, and how long they are: 1,500 bytes of each, 36 kB of all, which take the air for 1.3 s.
const RESTING: u32 = 15;
const RESTING_BYTES: usize = 100;
/// The last one joins then, in seconds; everything ends at [`ENDS_S`].
const JOINS_S: f64 = 55.0;
const ENDS_S: f64 = 90.0;
/// The others join so many steps apart.
const APART: u64 = 200;

struct Swarm {
    nodes: Vec<(Bus, Radio<Local>)>,
    /// When commands were posted, by their number.
    posted: BTreeMap<u32, f64>,
    /// When they were posted, and how long they took.
    took: Vec<(f64, f64)>,
    /// What the one that joins knows of the others, and when it came.
    known: BTreeMap<(NodeId, Key), f64>,
    air: Air,
    hub: Hub,
}

impl Swarm {
    fn new() -> Self {
        Self {
            nodes: Vec::new(),
            posted: BTreeMap::new(),
            took: Vec::new(),
            known: BTreeMap::new(),
            air: Air::new(AIR, 3),
            hub: Hub::default(),
        }
    }

    fn join(&mut self, node: u64, now: NodeTime) {
        let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
        let settings = BusSettings {
            budget: BudgetSettings {
                bytes_per_s: 32_000.0,
                ..BudgetSettings::default()
            },
            ..BusSettings::default()
        };
        let mut bus = Bus::new(settings, key, NodeId(node), Boot(node), now);
        for rests in 0..RESTING {
            bus.tell(now, Key(100 + rests), vec![rests as u8; RESTING_BYTES])
                .unwrap();
        }
        let radio = self.air.radio(self.hub.join(NodeId(node)));
        self.nodes.push((bus, radio));
    }

    fn step(&mut self, step: u64) {
        let now = NodeTime(step * STEP_US);
        let at_s = now.as_seconds();
        for (bus, radio) in &mut self.nodes {
            let node = bus.node().0;
            if (step + node * 13).is_multiple_of(400) {
                bus.tell(now, Key(1), [(step / 400) as u8; 60].to_vec()).unwrap();
            }
            // From two nodes to two others, each once a second.
            if node <= 2 && (step + node * 77).is_multiple_of(200) {
                let number = (step / 100 * 8 + node) as u32;
                let body = number.to_be_bytes().to_vec();
                if bus.post(now, NodeId(node + 10), body).is_ok() {
                    self.posted.insert(number, at_s);
                }
            }
            for event in pump(bus, radio, now).unwrap() {
                match event {
                    Event::Command { body, .. } => {
                        let number = u32::from_be_bytes(body.try_into().unwrap());
                        let posted = self.posted[&number];
                        self.took.push((posted, at_s - posted));
                    }
                    Event::State { from, key, .. } if node == NODES => {
                        self.known.entry((from, key)).or_insert(at_s);
                    }
                    _ => {}
                }
            }
        }
    }

    /// How long commands of this span took: the median, and the longest; and how many came.
    fn took_s(&self, span: std::ops::Range<f64>) -> (f64, f64, usize) {
        let of_span = self.took.iter().filter(|(posted, _)| span.contains(posted));
        let mut times: Vec<f64> = of_span.map(|(_, took)| *took).collect();
        times.sort_by(f64::total_cmp);
        (times[times.len() / 2], times[times.len() - 1], times.len())
    }
}

#[test]
fn who_joins_a_slow_radio_is_in_nobodys_way() {
    let mut swarm = Swarm::new();
    let joins = (JOINS_S * 1e6) as u64 / STEP_US;
    for step in 1..(ENDS_S * 1e6) as u64 / STEP_US {
        let now = NodeTime(step * STEP_US);
        // One after the other, so that they learn what the air is like.
        if step.is_multiple_of(APART) && step / APART < NODES {
            swarm.join(step / APART, now);
        }
        if step == joins {
            swarm.join(NODES, now);
        }
        swarm.step(step);
    }
    let before = swarm.took_s(JOINS_S - 15.0..JOINS_S - 1.0);
    let while_joining = swarm.took_s(JOINS_S - 0.1..JOINS_S + 4.0);
    let after = swarm.took_s(JOINS_S + 10.0..ENDS_S - 4.0);
    for (what, (median_s, longest_s, count)) in [("before", before), ("while", while_joining), ("after", after)] {
        println!("{what}: {count} commands, {median_s:.2} s, {longest_s:.2} s at most");
    }
    let all: BTreeSet<u32> = (0..RESTING).map(|rests| 100 + rests).chain([1]).collect();
    let last_s = swarm.known.values().copied().fold(0.0, f64::max) - JOINS_S;
    let mut times: Vec<f64> = swarm.known.values().map(|at_s| at_s - JOINS_S).collect();
    times.sort_by(f64::total_cmp);
    println!(
        "half of all values after {:.1} s, all after {last_s:.1} s; {:?}",
        times[times.len() / 2],
        swarm.air.used()
    );
    assert_eq!(
        swarm.known.len(),
        all.len() * (NODES as usize - 1),
        "it knows everything"
    );
    assert!(while_joining.1 < before.1 + 0.5, "commands to others waited for it");
}
