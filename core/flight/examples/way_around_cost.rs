//! What it costs to find a way around twenty zones of twenty corners: `cargo run --release -p skein-flight --example way_around_cost`.

use skein_domain::{BreachAction, PositionNed, ZoneKind};
use skein_flight::way_around;
use skein_safety::{Clearance, Fence, Fences, Zone};
use std::f64::consts::TAU;
use std::time::Instant;

fn zone(index: u32, north_m: f64, east_m: f64) -> Option<Zone> {
    let corner = |k: u32| {
        let radius_m = 35.0 + f64::from((k * 7 + index * 3) % 5) * 4.0;
        let (sin, cos) = (f64::from(k) / 20.0 * TAU).sin_cos();
        [north_m + radius_m * cos, east_m + radius_m * sin]
    };
    let volume = Fence::new((0..20).map(corner).collect(), -10.0, 500.0).ok()?;
    Some(Zone {
        name: format!("zone {index}"),
        kind: ZoneKind::Exclusion,
        action: BreachAction::Hold,
        volume,
    })
}

fn main() {
    // In five staggered rows of four, so that no straight way leads through.
    let zones = (0..20).filter_map(|i| {
        let (row, column) = (i / 4, i % 4);
        zone(
            i,
            f64::from(row) * 120.0,
            f64::from(column) * 120.0 + f64::from(row % 2) * 60.0,
        )
    });
    let fences = Fences::new(zones.collect());
    let clearance = Clearance {
        horizontal_m: 5.0,
        vertical_m: 3.0,
    };
    let (mut worst_s, mut total_s, mut ways) = (0.0_f64, 0.0, 0.0);
    for k in 0..40 {
        let start = PositionNed::new(-80.0, f64::from(k) * 12.0, -30.0);
        let goal = PositionNed::new(580.0, 480.0 - f64::from(k) * 12.0, -30.0);
        let began = Instant::now();
        let found = way_around(&fences, &start, &goal, &clearance);
        let took_s = began.elapsed().as_secs_f64();
        worst_s = worst_s.max(took_s);
        total_s += took_s;
        ways += 1.0;
        if k % 10 == 0 {
            match found {
                Ok(way) => println!(
                    "{:.1} m over {} places, straight {:.1} m",
                    way.length_m,
                    way.waypoints.len(),
                    start.distance_m(&goal)
                ),
                Err(reason) => println!("{reason}"),
            }
        }
    }
    println!(
        "{:.2} ms on average, {:.2} ms at most",
        total_s / ways * 1e3,
        worst_s * 1e3
    );
}
