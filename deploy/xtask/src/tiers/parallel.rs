//! Which tiers run beside each other: two that fly in real time, since each leaves a good part of the processor idle, and in the background what
//! only computes.
//!
//! Must never do: run a long flight beside another one.

use super::{Built, Run, Tier};
use crate::report::Report;
use parking_lot::Mutex;
use rustix::process::nice;
use std::collections::VecDeque;

/// By so much what only computes stands back behind what flies: it gets a third of the share. Further back (19) it came to a standstill beside
/// another program that keeps the processor busy.
const NICENESS: i32 = 5;

/// Runs these tiers.
pub(super) fn run<'r>(tiers: &[Tier], run: &Run<'r>, built: &'r Built, report: &mut Report<'r>) {
    let (cpu_bound, flown): (Vec<Tier>, Vec<Tier>) = tiers.iter().partition(|tier| tier.is_cpu_bound());
    let (long, flown): (Vec<Tier>, Vec<Tier>) = flown.into_iter().partition(|tier| tier.is_long());
    if flown.is_empty() && long.is_empty() {
        cpu_bound.iter().for_each(|tier| run.tier(*tier, built, report));
        return;
    }
    let queue = Mutex::new(in_order(flown));
    let next = || queue.lock().pop_front();
    report.defer();
    let (mut background, mut beside) = (report.background(), report.background());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // on Linux this holds for the thread, and for the processes it starts; where it does not work all are alike
            let _ = nice(NICENESS);
            let lints_last = |tier: &&Tier| **tier == Tier::Static;
            let (last, first): (Vec<&Tier>, Vec<&Tier>) = cpu_bound.iter().partition(lints_last);
            [first, last]
                .concat()
                .iter()
                .for_each(|tier| run.tier(**tier, built, &mut background));
        });
        let other = scope.spawn(|| {
            while let Some(tier) = next() {
                run.tier(tier, built, &mut beside);
            }
        });
        while let Some(tier) = next() {
            run.tier(tier, built, report);
        }
        // a panic there is told when the scope ends
        let _ = other.join();
        long.iter().for_each(|tier| run.tier(*tier, built, report));
    });
    report.join(beside);
    report.join(background);
    report.try_deferred();
}

/// The browser first, and the flights of several nodes when it has ended: each of the two takes a whole core, and together they starve each other.
/// The shortest last, so that none is left over for the end, in which nothing runs beside it.
fn in_order(mut tiers: Vec<Tier>) -> VecDeque<Tier> {
    let order = [
        Tier::Ui,
        Tier::Interop,
        Tier::PluginBoundary,
        Tier::Wire,
        Tier::Integration,
        Tier::E2e,
    ];
    tiers.sort_by_key(|tier| order.iter().position(|known| known == tier).unwrap_or(order.len()));
    tiers.into()
}
