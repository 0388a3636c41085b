//! The separation filter flown: many seeded encounters on a plant of its own, judged by the true distances.

#[path = "avoidance/plant.rs"]
mod plant;
#[path = "avoidance/scenarios.rs"]
mod scenarios;

use nalgebra::Vector3;
use plant::{Disturbance, Kind, Outcome, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// One case of a kind; the seed says everything else.
fn case(make: scenarios::Make, count: usize, seed: u64, seconds: f64) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let disturbance = Disturbance {
        noise_m: rng.random_range(0.1..=0.3),
        latency_s: rng.random_range(0.0..=0.2),
        loss: 0.2,
        wind_m_s: rng.random_range(0.0..=5.0),
        gust_m_s: rng.random_range(0.0..=1.0),
    };
    World::new(&make(count, seed), disturbance, seed).fly(seconds)
}

/// True distances never fall short, and everybody arrives.
fn holds(make: scenarios::Make, counts: &[usize], seeds: u64) {
    for &count in counts {
        for seed in 0..seeds {
            let outcome = case(make, count, seed, 120.0);
            assert!(outcome.least_m >= 2.0, "{count} vehicles, seed {seed}: {outcome:?}");
            assert!(
                outcome.arrived_s.is_some(),
                "{count} vehicles, seed {seed}: {outcome:?}"
            );
        }
    }
}

#[test]
fn random_ways() {
    holds(scenarios::random, &[2, 8, 20], 4);
}

#[test]
fn everybody_through_the_middle_of_a_circle() {
    holds(scenarios::circle, &[2, 7, 16], 3);
}

#[test]
fn everybody_through_the_middle_of_a_sphere() {
    holds(scenarios::sphere, &[6, 20], 3);
}

#[test]
fn streams_that_cross() {
    holds(scenarios::streams, &[2, 12], 3);
}

#[test]
fn lines_that_fly_at_each_other() {
    holds(scenarios::head_on, &[2, 10], 4);
}

#[test]
fn places_in_a_grid_are_swapped() {
    holds(scenarios::swaps, &[2, 9], 3);
}

#[test]
fn vehicles_that_stop_answering() {
    holds(scenarios::failing, &[2, 12], 4);
}

#[test]
fn foreign_aircraft_that_cross() {
    holds(scenarios::foreign, &[3, 12], 4);
}

fn formation_at_ten_metres_a_second(loss: f64) -> Outcome {
    let starts: Vec<scenarios::Start> = (0..25)
        .map(|i| {
            let at = Vector3::new((i / 5) as f64 * 5.0, (i % 5) as f64 * 5.0, 0.0);
            (at, Vector3::x() * 10.0, Kind::Slot { at, speed_m_s: 10.0 })
        })
        .collect();
    let disturbance = Disturbance {
        noise_m: 0.3,
        latency_s: 0.2,
        loss,
        wind_m_s: 4.0,
        gust_m_s: 0.5,
    };
    let mut world = World::new(&starts, disturbance, 1);
    world.settings.max_speed_m_s = 14.0;
    world.fly(20.0)
}

/// States 0.2 s late, and a fifth of them lost: now and then somebody has not heard of the one ahead for so long that it may have begun
/// to brake.
#[test]
fn a_formation_at_ten_metres_a_second_is_hardly_touched() {
    for (loss, most_of_a_thousand) in [(0.0, 1), (0.2, 10)] {
        let outcome = formation_at_ten_metres_a_second(loss);
        assert!(outcome.calls > 10_000);
        assert!(
            outcome.changed * 1_000 < most_of_a_thousand * outcome.calls,
            "{outcome:?}"
        );
        assert!(outcome.change_sum_m_s <= 0.2 * outcome.changed as f64, "{outcome:?}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn two_hundred_vehicles() {
    for make in [scenarios::random, scenarios::sphere, scenarios::foreign] {
        let outcome = case(make, 200, 1, 180.0);
        println!("{outcome:?}");
        assert!(outcome.least_m >= 2.0 && outcome.arrived_s.is_some(), "{outcome:?}");
    }
}

/// `SEEDS=200 COUNT=20 ONLY=circle cargo test --release -p skein-safety --test avoidance -- --ignored --nocapture survey`
#[test]
#[ignore = "a survey for whoever works on the filter"]
fn survey() {
    let number = |name: &str, otherwise: u64| std::env::var(name).map_or(otherwise, |v| v.parse().unwrap());
    let only = std::env::var("ONLY").unwrap_or_default();
    for (name, make) in scenarios::ALL {
        if name.contains(&only) {
            summary(
                name,
                make,
                number("COUNT", 20) as usize,
                number("FIRST", 0),
                number("SEEDS", 20),
            );
        }
    }
}

/// Prints what many seeds of one kind come to; seeds that fail one by one.
fn summary(name: &str, make: scenarios::Make, count: usize, first: u64, seeds: u64) {
    let (mut below, mut late, mut least_m) = (0, 0, f64::INFINITY);
    let (mut arrived, mut change, mut infeasible, mut step) = (Vec::new(), 0.0, 0.0, 0.0);
    for seed in first..first + seeds {
        let outcome = case(make, count, seed, 120.0);
        if outcome.least_m < 2.0 || outcome.arrived_s.is_none() {
            println!(
                "    seed {seed}: {:.2} m at {:.1} s between {:?}, {} not there",
                outcome.least_m, outcome.least_at_s, outcome.least_pair, outcome.not_arrived
            );
        }
        below += usize::from(outcome.least_m < 2.0);
        late += usize::from(outcome.arrived_s.is_none());
        least_m = least_m.min(outcome.least_m);
        arrived.extend(outcome.arrived_s);
        change += outcome.mean_change_m_s() / seeds as f64;
        infeasible += outcome.infeasible as f64 / outcome.calls.max(1) as f64 / seeds as f64;
        step += outcome.step_sum_m_s / outcome.changed.max(1) as f64 / seeds as f64;
    }
    arrived.sort_by(f64::total_cmp);
    let median_s = arrived.get(arrived.len() / 2).copied().unwrap_or(f64::NAN);
    let last_s = arrived.last().copied().unwrap_or(f64::NAN);
    println!(
        "{name:8} {count:3}: least {least_m:.2} m, below {below}, late {late}, median {median_s:.1} s, last {last_s:.1} s, \
         change {change:.2} m/s, infeasible {:.1} %, step {step:.3} m/s",
        infeasible * 100.0
    );
}
