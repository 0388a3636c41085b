//! `skein bench`: hands over to the bench library, which measures this program from outside, as its own child processes.

use std::process::ExitCode;

/// The whole program against a load generator, beside a bare loop.
///
/// # Errors
/// When a child process cannot be started or does not come up.
pub fn fleet(_vehicles: u8, _seconds: u32, _json: bool) -> anyhow::Result<ExitCode> {
    anyhow::bail!("not built in")
}

/// The load generator, as its own process.
///
/// # Errors
/// When its settings do not parse or a socket cannot be bound.
pub fn load_generator(_settings: &str) -> anyhow::Result<ExitCode> {
    anyhow::bail!("not built in")
}

/// The bare loop, as its own process.
///
/// # Errors
/// When its settings do not parse or its socket cannot be bound.
pub fn bare_loop(_settings: &str) -> anyhow::Result<ExitCode> {
    anyhow::bail!("not built in")
}
