//! The separation filter flown: many seeded encounters on a plant of its own, judged by the true distances.

#[path = "avoidance/plant.rs"]
mod plant;
#[path = "avoidance/scenarios.rs"]
mod scenarios;

use plant::{Disturbance, Outcome, World};
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

/// `SEEDS=200 COUNT=20 ONLY=circle cargo test --release -p skein-safety --test avoidance -- --ignored --nocapture survey`
#[test]
#[ignore = "a survey for whoever works on the filter"]
fn survey() {
    let number = |name: &str, otherwise: u64| std::env::var(name).map_or(otherwise, |v| v.parse().unwrap());
    let only = std::env::var("ONLY").unwrap_or_default();
    let (first, seeds) = (number("FIRST", 0), number("SEEDS", 20));
    for (name, make) in scenarios::ALL {
        if !name.contains(&only) {
            continue;
        }
        for count in [2, 8, 20].map(|c| number("COUNT", c)).into_iter().take(if std::env::var("COUNT").is_ok() { 1 } else { 3 }) {
            summary(name, make, count as usize, first, seeds);
        }
    }
}

fn summary(name: &str, make: scenarios::Make, count: usize, first: u64, seeds: u64) {
    let (mut below, mut late, mut worst) = (Vec::new(), Vec::new(), (f64::INFINITY, 0));
    let (mut arrived, mut change, mut share, mut infeasible, mut step) = (Vec::new(), 0.0, 0.0, 0.0, 0.0);
    for seed in first..first + seeds {
        let outcome = case(make, count, seed, 120.0);
        if outcome.least_m < 2.0 {
            below.push((seed, outcome.least_m, outcome.least_at_s, outcome.least_pair));
        }
        if outcome.least_m < worst.0 {
            worst = (outcome.least_m, seed);
        }
        match outcome.arrived_s {
            Some(t) => arrived.push(t),
            None => late.push((seed, outcome.not_arrived)),
        }
        change += outcome.mean_change_m_s() / seeds as f64;
        share += outcome.changed as f64 / outcome.calls.max(1) as f64 / seeds as f64;
        infeasible += outcome.infeasible as f64 / outcome.calls.max(1) as f64 / seeds as f64;
        step += outcome.step_sum_m_s / outcome.changed.max(1) as f64 / seeds as f64;
    }
    arrived.sort_by(f64::total_cmp);
    let median = arrived.get(arrived.len() / 2).copied().unwrap_or(f64::NAN);
    println!(
        "{name:8} {count:3}: worst {:.2} m (seed {}), below {}, not arrived {}, median {median:.1} s, last {:.1} s, \
         changed {:.0} % by {change:.2} m/s, infeasible {:.1} %, step {step:.3}",
        worst.0, worst.1, below.len(), late.len(), arrived.last().copied().unwrap_or(f64::NAN), share * 100.0, infeasible * 100.0,
    );
    for (seed, least, at, pair) in below.iter().take(4) {
        println!("    seed {seed}: {least:.2} m at {at:.1} s between {pair:?}");
    }
    for (seed, left) in late.iter().take(4) {
        println!("    seed {seed}: {left} not there");
    }
}
