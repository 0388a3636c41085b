//! `skein swarm`: a new secret.
//!
//! Must never do: print a secret.

#[cfg(feature = "zenoh")]
mod threads;

use crate::args::{SwarmArguments, SwarmCommand};
use anyhow::Context;
use std::fs::OpenOptions;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;

#[cfg(feature = "zenoh")]
pub use threads::with_threads_enough;

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
