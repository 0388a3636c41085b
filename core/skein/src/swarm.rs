//! `skein swarm`: a new secret; and the threads that a swarm over TCP needs.
//!
//! Must never do: print a secret.

use crate::args::{SwarmArguments, SwarmCommand};
use anyhow::Context;
use skein_config::{SwarmSettings, SwarmTransport};
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Bytes of a secret that this program makes.
const SECRET_BYTES: usize = 32;

/// `skein swarm`.
///
/// # Errors
/// When the file is there already or cannot be written.
pub fn swarm(arguments: &SwarmArguments) -> anyhow::Result<()> {
    let SwarmCommand::NewSecret { file } = &arguments.command;
    let secret: [u8; SECRET_BYTES] = rand::random();
    let text: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
    let mut made = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(file)
        .with_context(|| format!("cannot make {}", file.display()))?;
    writeln!(made, "{text}")?;
    println!(
        "{} holds a new secret. Copy it to every node of the swarm, and name it there: swarm.secret_file.",
        file.display()
    );
    Ok(())
}

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
