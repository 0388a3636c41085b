//! What only computes runs in the background of what flies in real time, which leaves a good part of the processor idle.
//!
//! Must never do: let cargo hold its lock for minutes while a flight waits to be started by it.

use super::{Built, Run, Tier};
use crate::report::Report;
use std::sync::mpsc;

/// Runs these tiers. The lints come last in the background, when no flight needs cargo any more.
pub(super) fn run(tiers: &[Tier], run: &Run<'_>, built: &Built, report: &mut Report) {
    let (mut cpu_bound, flown): (Vec<Tier>, Vec<Tier>) = tiers.iter().partition(|tier| tier.is_cpu_bound());
    if flown.is_empty() {
        cpu_bound.iter().for_each(|tier| run.tier(*tier, built, report));
        return;
    }
    cpu_bound.sort_by_key(|tier| *tier == Tier::Static);
    let (cargo_is_needed, cargo_is_free) = mpsc::channel::<()>();
    let mut background = report.background();
    let in_background = &mut background;
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for tier in cpu_bound {
                if tier == Tier::Static {
                    // nothing is ever sent: it ends when the other side is dropped
                    let _ = cargo_is_free.recv();
                }
                run.tier(tier, built, in_background);
            }
        });
        let mut cargo_is_needed = Some(cargo_is_needed);
        for tier in flown {
            if !tier.is_run_by_cargo() {
                cargo_is_needed = None;
            }
            run.tier(tier, built, report);
        }
        drop(cargo_is_needed);
    });
    report.join(background);
}
