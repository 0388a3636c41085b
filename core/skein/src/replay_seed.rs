//! `skein replay-seed`: flies a drawn flight again, tells its story and its figures, and fails if it fails its criteria.
//!
//! Must never do: judge by itself.

use std::process::ExitCode;

/// Flies the flight of a seed.
#[must_use]
pub fn replay_seed(seed: u64, trace: bool) -> ExitCode {
    let outcome = skein_seeded::fly_seed(seed, trace);
    print!("{outcome}");
    if outcome.is_passed() {
        println!("all criteria are met");
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
