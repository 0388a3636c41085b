//! What the separation filter costs a swarm in formation flight, each vehicle against all others, as ratios to a plain loop over
//! all distances in the same run: `cargo run --release -p skein-safety --example avoidance_cost`.

use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, Setpoint, VehicleId, VelocityNed};
use skein_safety::avoidance::{
    AvoidanceSettings, Cooperation, Neighbour, NeighbourId, Surroundings, filter, filter_in,
};
use std::hint::black_box;
use std::time::Instant;

const RATE_HZ: f64 = 50.0;

fn main() {
    let settings = AvoidanceSettings::default();
    let now = NodeTime::from_seconds(100.0);
    println!(
        "vehicles, what they do: per pair against a plain distance | per vehicle | all, and of a core at {RATE_HZ} Hz"
    );
    for count in [50_u16, 200, 1000] {
        for (name, scatter_m_s) in [("formation", 0.3), ("mêlée", 6.0)] {
            let neighbours = swarm(count, scatter_m_s, now);
            let distances_s = timed(count, || distances(&neighbours));
            let each_s = timed(count, || one_by_one(&neighbours, &settings, now));
            let shared_s = timed(count, || with_surroundings(&neighbours, &settings, now));
            for (how, seconds) in [("each alone", each_s), ("prepared once", shared_s)] {
                println!(
                    "{count:5} {name:9} {how:13}: {:6.1} x | {:8.2} us | {:8.3} ms, {:6.2} %",
                    seconds / distances_s,
                    seconds * 1e6 / f64::from(count),
                    seconds * 1e3,
                    seconds * RATE_HZ * 100.0
                );
            }
        }
    }
}

/// Seconds that one round takes, the mean of enough of them.
fn timed(count: u16, mut round: impl FnMut() -> f64) -> f64 {
    let rounds = (2_000_000 / (u32::from(count) * u32::from(count))).clamp(5, 400);
    black_box(round());
    let begun = Instant::now();
    for _ in 0..rounds {
        black_box(round());
    }
    begun.elapsed().as_secs_f64() / f64::from(rounds)
}

fn distances(neighbours: &[Neighbour]) -> f64 {
    let mut least_m = f64::INFINITY;
    for a in black_box(neighbours) {
        for b in neighbours {
            if a.id != b.id {
                least_m = least_m.min(a.position.distance_m(&b.position));
            }
        }
    }
    least_m
}

fn one_by_one(neighbours: &[Neighbour], settings: &AvoidanceSettings, now: NodeTime) -> f64 {
    sum(neighbours, |id, own, wanted| {
        let filtered = filter(id, own, wanted, neighbours, &[], settings, now);
        filtered.change.map_or(0.0, |change| change.by_m_s)
    })
}

fn with_surroundings(neighbours: &[Neighbour], settings: &AvoidanceSettings, now: NodeTime) -> f64 {
    let surroundings = Surroundings::new(neighbours, settings, now);
    sum(neighbours, |id, own, wanted| {
        let filtered = filter_in(id, own, wanted, &surroundings, &[], settings, now);
        filtered.change.map_or(0.0, |change| change.by_m_s)
    })
}

fn sum(neighbours: &[Neighbour], mut judge: impl FnMut(VehicleId, &VehicleKinematics, &Setpoint) -> f64) -> f64 {
    let mut total = 0.0;
    for neighbour in black_box(neighbours) {
        let NeighbourId::Vehicle(id) = neighbour.id else {
            continue;
        };
        let own = VehicleKinematics {
            position: neighbour.position,
            velocity: neighbour.velocity,
            yaw_rad: 0.0,
            measured: neighbour.measured,
        };
        let wanted = Setpoint {
            velocity: Some(neighbour.velocity),
            ..Setpoint::hold(neighbour.position.after(&neighbour.velocity, 0.05), None)
        };
        total += judge(id, &own, &wanted);
    }
    total
}

/// A grid at five metres that flies at eight metres a second, each vehicle with a velocity of its own on top of that.
fn swarm(count: u16, scatter_m_s: f64, now: NodeTime) -> Vec<Neighbour> {
    let columns = f64::from(count).sqrt().ceil() as u16;
    let neighbour = |i: u16| {
        // The golden angle: evenly spread, and the same in every run.
        let angle = f64::from(i) * 2.399_963;
        Neighbour {
            id: NeighbourId::Vehicle(VehicleId(i)),
            position: PositionNed::new(f64::from(i / columns) * 5.0, f64::from(i % columns) * 5.0, -30.0),
            velocity: VelocityNed::new(8.0 + scatter_m_s * angle.cos(), scatter_m_s * angle.sin(), 0.1),
            measured: now.plus_seconds(-0.03),
            uncertainty_m: 0.3,
            cooperation: Cooperation::Shares,
            airborne: true,
        }
    };
    (0..count).map(neighbour).collect()
}
