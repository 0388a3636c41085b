//! What a swarm's ordinary traffic costs against its size: every node tells a beacon ten times a second, its place five times, and one tells an
//! intent. Time is simulated; the figures are printed.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_bus::bus::Bus;
use skein_bus::latest::Key;
use skein_bus::radio::{Air, AirSettings};
use skein_bus::seal::{Boot, SwarmKey};
use skein_bus::transport::Class;
use skein_bus::{BusSettings, local::Hub, pump};
use skein_domain::{NodeId, NodeTime};

const STEP_US: u64 = 20_000;
const SECONDS: u64 = 6;
/// As long as the encoded ones.
const BEACON: [u8; 30] = [1; 30];
const PLACE: [u8; 60] = [2; 60];
const INTENT: [u8; 400] = [3; 400];

struct Cost {
    /// Until everyone had proven itself to everyone, in seconds.
    met_s: f64,
    /// Sent by each node in the last seconds, in bytes per second, seals included.
    each_bytes_per_s: f64,
    state_share: f64,
}

fn cost(size: u64) -> Cost {
    let air = AirSettings {
        delay_s: 0.003,
        jitter_s: 0.005,
        loss: 0.02,
        ..AirSettings::default()
    };
    let (air, hub) = (Air::new(air, 1), Hub::default());
    let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
    let mut nodes: Vec<_> = (1..=size)
        .map(|node| {
            let bus = Bus::new(
                BusSettings::default(),
                key.clone(),
                NodeId(node),
                Boot(node),
                NodeTime(0),
            );
            (bus, air.radio(hub.join(NodeId(node))))
        })
        .collect();
    let total = |nodes: &[(Bus, _)]| -> u64 { nodes.iter().map(|(bus, _)| bus.sent().total_bytes()).sum() };
    let (mut met_s, mut halfway) = (None, 0);
    for step in 1..=SECONDS * 1_000_000 / STEP_US {
        let now = NodeTime(step * STEP_US);
        for (index, (bus, radio)) in nodes.iter_mut().enumerate() {
            let turn = step + index as u64;
            if turn.is_multiple_of(5) {
                bus.tell(now, Key(1), BEACON.to_vec()).unwrap();
            }
            if turn.is_multiple_of(10) {
                bus.tell(now, Key(2), PLACE.to_vec()).unwrap();
            }
            if index == 0 && step == 1 {
                bus.tell(now, Key(3), INTENT.to_vec()).unwrap();
            }
            pump(bus, radio, now).unwrap();
        }
        let met = |(bus, _): &(Bus, _)| {
            (1..=size).all(|node| NodeId(node) == bus.node() || bus.run_of(NodeId(node)).is_some())
        };
        if met_s.is_none() && nodes.iter().all(met) {
            met_s = Some(now.as_seconds());
        }
        if step == SECONDS * 500_000 / STEP_US {
            halfway = total(&nodes);
        }
    }
    let half_s = SECONDS as f64 / 2.0;
    let sent = total(&nodes);
    let of_state: u64 = nodes
        .iter()
        .map(|(bus, _)| bus.sent().bytes[Class::State as usize])
        .sum();
    Cost {
        met_s: met_s.unwrap(),
        each_bytes_per_s: (sent - halfway) as f64 / half_s / size as f64,
        state_share: of_state as f64 / sent as f64,
    }
}

#[test]
fn what_a_node_sends_does_not_grow_with_the_swarm() {
    println!("nodes  met after  each sends      all send        of it state, joining included");
    let costs: Vec<(u64, Cost)> = [6, 25, 100].into_iter().map(|size| (size, cost(size))).collect();
    for (size, cost) in &costs {
        println!(
            "{size:5}  {:6.2} s  {:7.0} byte/s  {:9.0} byte/s  {:3.0} %",
            cost.met_s,
            cost.each_bytes_per_s,
            cost.each_bytes_per_s * *size as f64,
            cost.state_share * 100.0
        );
    }
    let (small, large) = (&costs[0].1, &costs[2].1);
    assert!(large.each_bytes_per_s < 1.3 * small.each_bytes_per_s);
    assert!(costs.iter().all(|(_, cost)| cost.met_s < 3.0));
}
