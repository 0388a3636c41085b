//! The threads that a swarm over TCP needs.
//!
//! Must never do: begin the program again where that is not needed.

use skein_config::{SwarmSettings, SwarmTransport};
use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Zenoh reads from the environment with how many threads it sends, and over TCP a node that vanished stops one of them for seconds: where
/// links go over TCP or TLS, the program begins once more with as many as it needs. Does not return then.
///
/// # Errors
/// When the program cannot begin again.
pub fn with_threads_enough(settings: &SwarmSettings) -> io::Result<()> {
    let (name, value) = skein_bus_zenoh::RUNTIMES;
    let over_zenoh = settings.id.is_some() && settings.transports.contains(&SwarmTransport::Zenoh);
    let over_tcp = |endpoint: &String| endpoint.starts_with("tcp/") || endpoint.starts_with("tls/");
    let is_needed = over_zenoh
        && settings
            .zenoh
            .listen
            .iter()
            .chain(&settings.zenoh.connect)
            .any(over_tcp);
    if !is_needed || std::env::var_os(name).is_some() {
        return Ok(());
    }
    let mut again = Command::new(std::env::current_exe()?);
    Err(again.args(std::env::args_os().skip(1)).env(name, value).exec())
}
