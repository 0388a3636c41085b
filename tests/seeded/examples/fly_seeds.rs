//! Flies a range of seeds, `fly_seeds 0..2000`, and prints every failure and the figures of all; or one, `fly_seeds 7 --trace`.

use skein_seeded::{Failure, fly_seed};
use std::io::Write;

fn main() {
    let asked = std::env::args().nth(1).unwrap_or_else(|| "0..100".into());
    if let Ok(seed) = asked.parse() {
        let trace = std::env::args().nth(2).is_some_and(|a| a == "--trace");
        print!("{}", fly_seed(seed, trace));
        return;
    }
    let (from, to) = asked.split_once("..").unwrap_or(("0", "100"));
    let (from, to): (u64, u64) = (from.parse().unwrap_or(0), to.parse().unwrap_or(100));
    let (mut failed, mut least_m, mut changed, mut calls, mut seconds) = (0_u64, f64::INFINITY, 0, 0, 0.0);
    let (mut refusals, mut held, mut cut_short) = (0, 0, 0_u64);
    for seed in from..to {
        let outcome = fly_seed(seed, false);
        seconds += outcome.end_s;
        least_m = least_m.min(outcome.closest.distance_m);
        changed += outcome.filter.changed;
        calls += outcome.filter.calls;
        refusals += outcome.refusals.len();
        held += outcome
            .arrivals
            .iter()
            .filter(|(_, a)| !matches!(a, skein_seeded::Arrival::There(_)))
            .count();
        cut_short += u64::from(outcome.cut_short);
        if !outcome.is_passed() {
            failed += 1;
            let kinds = outcome
                .failures
                .iter()
                .map(Failure::to_string)
                .take(3)
                .collect::<Vec<_>>();
            println!(
                "seed {seed} ({} vehicles, {:.0} s): {}",
                outcome.vehicles,
                outcome.end_s,
                kinds.join("; ")
            );
            let _ = std::io::stdout().flush();
        }
    }
    println!(
        "{from}..{to}: {failed} failed; nearest {least_m:.2} m; {:.2} % of {calls} setpoints changed; {seconds:.0} s flown; {refusals} refusals, {held} vehicles with a reason; {cut_short} flights cut short",
        100.0 * changed as f64 / f64::from(u32::try_from(calls).unwrap_or(u32::MAX)).max(1.0)
    );
}
