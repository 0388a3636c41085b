//! What a node needs to know of the process that it runs in: where its plugins lie, when it is asked to stop, and who reads along.
//!
//! Must never do: end the process.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::PathBuf;

/// The directory of plugins that comes with this program: `plugins` beside it, or, where a package put them, `../lib/skein/plugins`.
#[must_use]
pub fn plugins_beside_program() -> PathBuf {
    let program = std::env::current_exe().ok();
    let Some(folder) = program.as_deref().and_then(std::path::Path::parent) else {
        return PathBuf::from("plugins");
    };
    let (beside, installed) = (folder.join("plugins"), folder.join("../lib/skein/plugins"));
    match installed.canonicalize() {
        Ok(installed) if !beside.is_dir() => installed,
        _ => beside,
    }
}

/// Where the flights of a program without a configuration file are recorded: `skein/flights` in the user's state folder; `None` for a user
/// without a home.
#[must_use]
pub fn flights_of_user() -> Option<PathBuf> {
    let folder = |name: &str| {
        std::env::var_os(name)
            .filter(|folder| !folder.is_empty())
            .map(PathBuf::from)
    };
    let state = folder("XDG_STATE_HOME").or_else(|| Some(folder("HOME")?.join(".local/state")));
    Some(state?.join("skein/flights"))
}

/// Returns when the process is asked to stop.
///
/// # Errors
/// When signals cannot be listened for.
pub async fn stop_asked() -> io::Result<()> {
    let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    tokio::select! {
        asked = tokio::signal::ctrl_c() => asked?,
        _ = terminate.recv() => {}
    }
    Ok(())
}

/// Tells a line on standard output. Whoever read it may be gone (`skein run | tee log`, and Ctrl-C ended `tee` first): that is no reason to end what flies, so
/// unlike `println!` this never panics.
pub fn tell(line: impl Display) {
    let _unread = writeln!(io::stdout(), "{line}");
}
