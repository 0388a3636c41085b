//! `skein bench`: hands over to the bench library, which measures this program from outside, as its own child processes.

use skein_bench::{FleetBenchArgs, run_fleet_bench};
use std::process::ExitCode;

/// The whole program against a load generator, beside a bare loop.
///
/// # Errors
/// When a child process cannot be started or does not come up.
pub fn fleet(vehicles: u8, seconds: u32, json: bool) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let report = run_fleet_bench(&FleetBenchArgs::new(u16::from(vehicles), seconds, program))?;
    if json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        println!("{report}");
    }
    Ok(ExitCode::SUCCESS)
}

/// The load generator, as its own process.
///
/// # Errors
/// When its settings do not parse or a socket cannot be bound.
pub fn load_generator(settings: &str) -> anyhow::Result<ExitCode> {
    Ok(skein_bench::run_load_generator(settings).map(|()| ExitCode::SUCCESS)?)
}

/// The bare loop, as its own process.
///
/// # Errors
/// When its settings do not parse or its socket cannot be bound.
pub fn bare_loop(settings: &str) -> anyhow::Result<ExitCode> {
    Ok(skein_bench::run_bare_loop(settings).map(|()| ExitCode::SUCCESS)?)
}
