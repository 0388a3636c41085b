//! How a node of a swarm reaches the others: secret and transports as its configuration names them.
//!
//! Must never do: print a secret.

use skein_bus::envelope::{SwarmKey, WeakSecret};
use skein_bus::redundant::Redundant;
use skein_bus::transport::Transport;
use skein_cluster::{OpenedTransport, SwarmSetup};
use skein_config::{SwarmSettings, SwarmTransport};
use skein_dds::Place;
use skein_domain::NodeId;
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error;

/// Why a node cannot be part of its swarm.
#[derive(Debug, Error)]
pub enum SwarmError {
    /// The secret cannot be read.
    #[error("swarm.secret_file: cannot read {path}: {source}; `skein swarm new-secret {path}` makes one, to be copied to every node", path = path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Others may read it.
    #[error("swarm.secret_file: others may read {path}: `chmod 600 {path}`", path = path.display())]
    Open {
        /// Which file.
        path: PathBuf,
    },
    /// The configuration names Zenoh, and the program has none.
    #[error(
        "swarm.transports names \"zenoh\", which this program was built without: `cargo build --release -p skein` builds it with everything, or name \"dds\""
    )]
    WithoutZenoh,
    /// It is no secret.
    #[error("swarm.secret_file: {path} holds no secret: {reason}", path = path.display())]
    NoSecret {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// What a node needs to be part of the swarm of its configuration; nothing if that names none.
///
/// # Errors
/// When the secret cannot be read or is none.
pub fn setup(settings: &SwarmSettings, place: &Arc<Place>) -> Result<Option<SwarmSetup>, SwarmError> {
    let (Some(id), Some(file)) = (&settings.id, &settings.secret_file) else {
        return Ok(None);
    };
    if !cfg!(feature = "zenoh") && settings.transports.contains(&SwarmTransport::Zenoh) {
        return Err(SwarmError::WithoutZenoh);
    }
    let key = read_key(id, file)?;
    let (settings, place) = (settings.clone(), Arc::clone(place));
    let open = Arc::new(move || open(&settings, &place));
    Ok(Some(SwarmSetup { key, open }))
}

fn read_key(id: &str, file: &Path) -> Result<SwarmKey, SwarmError> {
    let unreadable = |source| SwarmError::Unreadable {
        path: file.to_owned(),
        source,
    };
    let mode = std::fs::metadata(file).map_err(unreadable)?.permissions().mode();
    if mode & 0o077 != 0 {
        return Err(SwarmError::Open { path: file.to_owned() });
    }
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    let no_secret = |reason: String| SwarmError::NoSecret {
        path: file.to_owned(),
        reason,
    };
    let secret = from_hexadecimal(text.trim())
        .ok_or_else(|| no_secret("it is not made of pairs of hexadecimal digits".into()))?;
    SwarmKey::derive(id, &secret).map_err(|weak: WeakSecret| no_secret(weak.to_string()))
}

fn from_hexadecimal(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u8>> = text.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
    let digits = digits?;
    let pairs = digits.chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return None;
    }
    Some(
        pairs
            .filter_map(|pair| Some(pair.first()? << 4 | pair.get(1)?))
            .collect(),
    )
}

/// The transport or the two transports of a configuration. Waits for them to begin.
fn open(settings: &SwarmSettings, place: &Place) -> Result<OpenedTransport, String> {
    let open = |which: &SwarmTransport| open_one(settings, place, *which);
    match settings.transports.as_slice() {
        [only] => open(only).map(OpenedTransport::from),
        [first, second] => {
            let both = Redundant::new(open(first)?, open(second)?).map_err(|e| e.to_string())?;
            let ways = Some(([first.to_string(), second.to_string()], both.ways()));
            Ok(OpenedTransport {
                transport: Box::new(both),
                ways,
            })
        }
        _ => Err("swarm.transports names none".into()),
    }
}

fn open_one(settings: &SwarmSettings, place: &Place, which: SwarmTransport) -> Result<Box<dyn Transport>, String> {
    let swarm = settings.id.clone().unwrap_or_default();
    let node = NodeId(settings.node.unwrap_or_default());
    match which {
        #[cfg(feature = "zenoh")]
        SwarmTransport::Zenoh => {
            let opened = skein_bus_zenoh::Zenoh::open(&swarm, node, &settings.zenoh);
            Ok(Box::new(opened.map_err(|e| format!("swarm.zenoh: {e}"))?))
        }
        #[cfg(not(feature = "zenoh"))]
        SwarmTransport::Zenoh => Err(SwarmError::WithoutZenoh.to_string()),
        SwarmTransport::Dds => {
            let participant = place.participant().map_err(|e| format!("dds: {e}"))?;
            let opened = skein_bus_dds::Dds::open(&swarm, node, participant);
            Ok(Box::new(opened.map_err(|e| format!("dds: {e}"))?))
        }
    }
}
