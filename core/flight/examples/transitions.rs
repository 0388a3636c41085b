//! Prints what transitions cost to plan and take to fly: `cargo run --release -p skein-flight --example transitions [vehicles]`.

use skein_domain::{FormationRequest, NodeTime, OffsetFrd, Shape};
use skein_flight::formation::slots;
use skein_flight::transition::{MotionLimits, plan};
use std::time::Instant;

fn main() {
    let count: u32 = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(50);
    let limits = MotionLimits {
        speed_m_s: 8.0,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.5,
        min_distance_m: 2.5,
    };
    println!(
        "{:<18} {:<12} {:>8} {:>9} {:>10} {:>8} {:>9}",
        "from", "to", "plan ms", "lasts s", "distance m", "detours", "highest m"
    );
    let columns = count.isqrt().max(1);
    let grid: Vec<OffsetFrd> = (0..count)
        .map(|i| OffsetFrd::new(f64::from(i / columns) * 5.0, f64::from(i % columns) * 5.0, 0.0))
        .collect();
    let mut slowest_ms = 0.0_f64;
    for (name, heading_rad) in [
        ("launch grid", 0.0_f64),
        ("launch grid, 0.7", 0.7),
        ("launch grid, 3.0", 3.0),
    ] {
        let turned: Vec<_> = grid
            .iter()
            .map(|o| OffsetFrd::from_ned(o.vector(), heading_rad))
            .collect();
        for shape in Shape::ALL {
            slowest_ms = slowest_ms.max(show(name, &turned, *shape, &limits));
        }
    }
    for from in Shape::ALL {
        let Ok(present) = slots(&FormationRequest::new(*from, 5.0), grid.len()) else {
            continue;
        };
        for to in Shape::ALL {
            slowest_ms = slowest_ms.max(show(&format!("{from:?}"), &present, *to, &limits));
        }
    }
    println!("The slowest took {slowest_ms:.1} ms to plan.");
}

fn show(name: &str, from: &[OffsetFrd], to: Shape, limits: &MotionLimits) -> f64 {
    let Ok(targets) = slots(&FormationRequest::new(to, 5.0), from.len()) else {
        return 0.0;
    };
    let begun = Instant::now();
    let planned = plan(from, &targets, limits, NodeTime(0));
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    match planned {
        Ok(plan) => {
            let detours = plan.moves.iter().filter(|slot| slot.detour_up_m != 0.0).count();
            let highest_m = plan.moves.iter().map(|slot| slot.detour_up_m.abs()).fold(0.0, f64::max);
            println!(
                "{name:<18} {:<12} {took_ms:>8.2} {:>9.1} {:>10.2} {detours:>8} {highest_m:>9.1}",
                format!("{to:?}"),
                plan.duration_s,
                plan.min_distance_m
            );
        }
        Err(refused) => println!("{name:<18} {:<12} {took_ms:>8.2} {refused}", format!("{to:?}")),
    }
    took_ms
}
