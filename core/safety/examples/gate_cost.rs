//! What the gate costs for a hundred vehicles that fly in formation, each checked against all others 50 times a second:
//! `cargo run --release -p skein-safety --example gate_cost`.

use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, Setpoint, VehicleId, VelocityNed};
use skein_safety::{Fence, Gate, Limits, Peer};
use std::hint::black_box;
use std::time::Instant;

const RATE_HZ: f64 = 50.0;
const ROUNDS: u32 = 500;

fn main() {
    let limits = Limits {
        max_speed_m_s: 12.0,
        max_climb_m_s: 4.0,
        max_descent_m_s: 3.0,
        min_separation_m: 2.0,
        separation_horizon_s: 0.8,
    };
    let corners: Vec<[f64; 2]> = (0..12)
        .map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU)
        .map(|a| [500.0 * a.cos(), 500.0 * a.sin()])
        .collect();
    let fence = Fence::new(corners, -20.0, 120.0).ok();
    let now = NodeTime::from_seconds(100.0);
    let velocity = VelocityNed::new(8.0, 1.0, 0.1);
    let peers = formation(&velocity, now);
    for (name, gate) in [
        ("without a fence", Gate::new(limits, None)),
        ("with 12 corners", Gate::new(limits, fence)),
    ] {
        let begun = Instant::now();
        let mut refused = 0_u32;
        for _ in 0..ROUNDS {
            for peer in &peers {
                let position = peer.kinematics.position.after(&velocity, 0.05);
                let setpoint = Setpoint {
                    position: Some(position),
                    velocity: Some(velocity),
                    ..Setpoint::default()
                };
                let verdict = gate.setpoint(
                    peer.id,
                    &peer.kinematics,
                    true,
                    black_box(&setpoint),
                    black_box(&peers),
                    now,
                );
                refused += u32::from(verdict.is_err());
            }
        }
        let per_round_s = begun.elapsed().as_secs_f64() / f64::from(ROUNDS);
        println!(
            "{name}: {:.2} us a setpoint, {:.2} % of a core at {RATE_HZ} Hz; {refused} refused",
            per_round_s * 1e6 / peers.len() as f64,
            per_round_s * RATE_HZ * 100.0
        );
    }
}

/// A hundred vehicles on a grid with five metres between them, all at one velocity.
fn formation(velocity: &VelocityNed, now: NodeTime) -> Vec<Peer> {
    let peer = |i: u16| Peer {
        id: VehicleId(i),
        kinematics: VehicleKinematics {
            position: PositionNed::new(f64::from(i / 10) * 5.0, f64::from(i % 10) * 5.0, -30.0),
            velocity: *velocity,
            yaw_rad: 0.0,
            measured: now.plus_seconds(-0.03),
        },
        airborne: true,
    };
    (0..100).map(peer).collect()
}
