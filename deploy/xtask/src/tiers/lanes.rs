//! What is reckoned runs beside what flies in real time, which leaves a good part of the processor idle.
//!
//! Must never do: let cargo hold its lock for minutes while a flight waits to be started by it.

use super::{Built, Run, Tier};
use crate::report::Report;
use std::sync::mpsc;

/// Runs these tiers. The lints come last of what is reckoned, when nothing that flies needs cargo any more.
pub(super) fn run(tiers: &[Tier], run: &Run<'_>, built: &Built, report: &mut Report) {
    let (mut reckoned, flown): (Vec<Tier>, Vec<Tier>) = tiers.iter().partition(|tier| tier.is_reckoned());
    if flown.is_empty() {
        reckoned.iter().for_each(|tier| run.tier(*tier, built, report));
        return;
    }
    reckoned.sort_by_key(|tier| *tier == Tier::Static);
    let (cargo_is_needed, cargo_is_free) = mpsc::channel::<()>();
    let mut beside = report.beside();
    let aside = &mut beside;
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for tier in reckoned {
                if tier == Tier::Static {
                    // nothing is ever sent: it ends when the other side is dropped
                    let _ = cargo_is_free.recv();
                }
                run.tier(tier, built, aside);
            }
        });
        let mut cargo_is_needed = Some(cargo_is_needed);
        for tier in flown {
            if !tier.is_of_cargo() {
                cargo_is_needed = None;
            }
            run.tier(tier, built, report);
        }
        drop(cargo_is_needed);
    });
    report.join(beside);
}
