//! From a configuration to a running node with its gateway: what `skein run`, the demo and the tests start.

use crate::gateway;
use skein_config::NodeConfig;
use skein_runtime::{Node, NodeError, NodeHandle};
use std::net::SocketAddr;
use std::path::PathBuf;
use thiserror::Error;

/// Why a node could not be built.
#[derive(Debug, Error)]
pub enum BuildError {
    /// The address of dashboard and API cannot be listened on.
    #[error("web.listen: cannot listen on {address}: {source}{}", if source.kind() == std::io::ErrorKind::AddrInUse { "; another program uses this port: stop it, or choose another port" } else { "" })]
    Listen {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The node itself could not be started.
    #[error(transparent)]
    Node(#[from] NodeError),
}

/// A running node with its gateway.
pub struct Running {
    node: Node,
    web: SocketAddr,
}

impl Running {
    /// The handle to the node.
    #[must_use]
    pub fn handle(&self) -> NodeHandle {
        self.node.handle()
    }

    /// Where dashboard and API listen.
    #[must_use]
    pub fn web_address(&self) -> SocketAddr {
        self.web
    }

    /// Stops everything and waits for it.
    pub async fn stop(self) {
        self.node.stop().await;
    }
}

/// Builds and starts a node. Nothing is left running if it fails.
///
/// # Errors
/// When the configuration makes no sense, a plugin is missing or a port is not available.
pub async fn build(config: NodeConfig) -> Result<Running, BuildError> {
    let address = config.web.listen;
    let unavailable = |source| BuildError::Listen { address, source };
    let listener = std::net::TcpListener::bind(address).map_err(unavailable)?;
    listener.set_nonblocking(true).map_err(unavailable)?;
    let web = listener.local_addr().map_err(unavailable)?;
    let allowed_hosts = config.web.allowed_hosts.clone();
    let node = Node::start(config, vec![gateway::adapter(listener, allowed_hosts)]).await?;
    Ok(Running { node, web })
}

/// The directory of plugins that comes with this program: `plugins` beside it.
#[must_use]
pub fn plugins_beside_program() -> PathBuf {
    let program = std::env::current_exe().ok();
    program
        .as_deref()
        .and_then(std::path::Path::parent)
        .map_or_else(|| PathBuf::from("plugins"), |dir| dir.join("plugins"))
}
