//! What a swarm's ordinary traffic costs against its size: every node tells a beacon ten times a second, its vehicle's state five times, and one tells an
//! intent. Time is simulated; the figures are printed.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_bus::bus::Bus;
use skein_bus::envelope::{Boot, SwarmKey};
use skein_bus::latest::Key;
use skein_bus::radio::{Air, AirSettings};
use skein_bus::transport::Class;
use skein_bus::{BusSettings, local::Hub, pump};
use skein_domain::{NodeId, NodeTime};

const STEP_US: u64 = 20_000;
/// As long as the encoded ones.
const BEACON: [u8; 30] = [1; 30];
const INTENT: [u8; 400] = [3; 400];

/// What a node tells of its vehicle, in fields of fixed width: id, time, flags; position, velocity, heading, charge as it flies a circle of 40 m at 5 m/s.
fn vehicle(node: u64, time_s: f64, in_floats: bool) -> Vec<u8> {
    let angle = node as f64 + time_s * 5.0 / 40.0;
    let (sine, cosine) = angle.sin_cos();
    let (height_m, noise) = (-30.0 + 0.2 * (time_s * 3.1).sin(), (time_s * 977.0).sin() * 0.02);
    let position_m = [40.0 * cosine + noise, 40.0 * sine - noise, height_m];
    let velocity_m_s = [-5.0 * sine + noise, 5.0 * cosine + noise, noise];
    let charge = 0.9 - time_s * 1e-4;
    let mut bytes = (node as u16).to_be_bytes().to_vec();
    bytes.extend(((time_s * 1e6) as u64).to_be_bytes());
    bytes.extend([3, 0, 1, 7]);
    if in_floats {
        bytes.extend(position_m.into_iter().flat_map(f64::to_be_bytes));
        let others = velocity_m_s.into_iter().chain([angle, charge]);
        bytes.extend(others.flat_map(|value| (value as f32).to_be_bytes()));
    } else {
        bytes.extend(
            position_m
                .into_iter()
                .flat_map(|value| ((value * 1e3) as i32).to_be_bytes()),
        );
        let others = velocity_m_s.into_iter().chain([angle.sin() * 3.0, charge]);
        bytes.extend(others.flat_map(|value| ((value * 1e3) as i16).to_be_bytes()));
    }
    // Task, slot, anchor and what else hardly ever changes.
    bytes.extend([9; 24]);
    bytes
}

struct Cost {
    /// Until everyone had proven itself to everyone, in seconds.
    met_s: f64,
    /// Sent by each node in the last seconds, in bytes per second, seals included.
    each_bytes_per_s: f64,
    state_share: f64,
}

/// Who tells what.
#[derive(Clone, Copy)]
struct Case {
    size: u64,
    /// Of each node, in one value.
    vehicles: u64,
    /// That value is told every so many steps.
    every: u64,
    in_floats: bool,
}

fn cost(case: Case, differences: bool) -> Cost {
    let size = case.size;
    // A large swarm takes long to simulate, and its mean needs fewer seconds.
    let seconds: u64 = if size < 100 { 10 } else { 6 };
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
            let mut settings = BusSettings::default();
            settings.state.differences = differences;
            let bus = Bus::new(settings, key.clone(), NodeId(node), Boot(node), NodeTime(0));
            (bus, air.radio(hub.join(NodeId(node))))
        })
        .collect();
    let total = |nodes: &[(Bus, _)]| -> u64 { nodes.iter().map(|(bus, _)| bus.sent().total_bytes()).sum() };
    let (mut met_s, mut halfway) = (None, 0);
    for step in 1..=seconds * 1_000_000 / STEP_US {
        let now = NodeTime(step * STEP_US);
        for (index, (bus, radio)) in nodes.iter_mut().enumerate() {
            let turn = step + index as u64;
            if turn.is_multiple_of(5) {
                bus.tell(now, Key(1), BEACON.to_vec()).unwrap();
            }
            if turn.is_multiple_of(case.every) {
                let of_node = bus.node().0 * case.vehicles;
                let vehicles = of_node..of_node + case.vehicles;
                let value = vehicles.flat_map(|id| vehicle(id, now.as_seconds(), case.in_floats));
                bus.tell(now, Key(2), value.collect()).unwrap();
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
        if step == seconds * 500_000 / STEP_US {
            halfway = total(&nodes);
        }
    }
    let half_s = seconds as f64 / 2.0;
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

/// The cost with wholes and with differences, printed.
fn both_ways(case: Case) -> [Cost; 2] {
    [false, true].map(|differences| {
        let cost = cost(case, differences);
        println!(
            "{:5}  {:2} at {:2.0} Hz  {}  {}  {:6.2} s  {:7.0} byte/s  {:9.0} byte/s  {:3.0} %",
            case.size,
            case.vehicles,
            1e6 / STEP_US as f64 / case.every as f64,
            if case.in_floats { "floats     " } else { "fixed point" },
            if differences { "differences" } else { "wholes     " },
            cost.met_s,
            cost.each_bytes_per_s,
            cost.each_bytes_per_s * case.size as f64,
            cost.state_share * 100.0
        );
        cost
    })
}

#[test]
fn what_a_node_sends_does_not_grow_with_the_swarm() {
    println!(
        "nodes  vehicles     values       told as      met after  each sends      all send        of it state, joining included"
    );
    let one = |size| Case {
        size,
        vehicles: 1,
        every: 10,
        in_floats: true,
    };
    let mut costs = Vec::new();
    for case in [one(6), one(25), one(100)] {
        let [whole, differences] = both_ways(case);
        assert!(differences.each_bytes_per_s < 0.92 * whole.each_bytes_per_s);
        costs.push(differences);
    }
    assert!(costs[2].each_bytes_per_s < 1.3 * costs[0].each_bytes_per_s);
    assert!(costs.iter().all(|cost| cost.met_s < 3.0));
}

#[test]
fn who_tells_much_often_saves_much() {
    for in_floats in [true, false] {
        let [whole, differences] = both_ways(Case {
            size: 6,
            vehicles: 6,
            every: 2,
            in_floats,
        });
        assert!(differences.each_bytes_per_s < 0.7 * whole.each_bytes_per_s);
    }
}
