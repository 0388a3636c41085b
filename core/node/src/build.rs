//! From a configuration to a running node with its gateway: what `skein run`, the demo and the tests start.

use crate::gateway;
use crate::ros2;
use crate::swarm::{self, SwarmError};
use skein_cluster::SwarmSetup;
use skein_config::{DdsPeer, NodeConfig};
use skein_dds::{DdsSettings, Peer, Place};
use skein_runtime::{Node, NodeError, NodeHandle};
use std::net::SocketAddr;
use std::sync::Arc;
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
    /// It cannot be part of its swarm.
    #[error(transparent)]
    Swarm(#[from] SwarmError),
    /// The node itself could not be started.
    #[error(transparent)]
    Node(#[from] NodeError),
}

/// A running node with its gateway.
pub struct Running {
    node: Node,
    web: Option<SocketAddr>,
}

impl Running {
    /// The handle to the node.
    #[must_use]
    pub fn handle(&self) -> NodeHandle {
        self.node.handle()
    }

    /// Where dashboard and API listen, if they do.
    #[must_use]
    pub fn web_address(&self) -> Option<SocketAddr> {
        self.web
    }

    /// Stops everything and waits for it.
    pub async fn stop(self) {
        let handle = self.node.handle();
        self.node.stop().await;
        skein_recorder::ended(&handle).await;
    }
}

/// Builds and starts a node. Nothing is left running if it fails.
///
/// # Errors
/// When the configuration makes no sense, a plugin is missing or a port is not available.
pub async fn build(config: NodeConfig) -> Result<Running, BuildError> {
    let place = place(&config);
    let swarm = swarm::setup(&config.swarm, &place)?;
    build_at(config, swarm, place).await
}

/// Where a node is in DDS; it joins when something needs it.
fn place(config: &NodeConfig) -> Arc<Place> {
    let peer = |peer: &DdsPeer| Peer {
        address: peer.address,
        port: peer.port,
    };
    Arc::new(Place::new(DdsSettings {
        domain_id: config.dds.domain_id,
        interfaces: config.dds.interfaces.clone(),
        peers: config.dds.peers.iter().map(peer).collect(),
    }))
}

/// The same, with the others of its swarm reached in this way.
///
/// # Errors
/// As [`build`].
pub async fn build_in(config: NodeConfig, swarm: Option<SwarmSetup>) -> Result<Running, BuildError> {
    let place = place(&config);
    build_at(config, swarm, place).await
}

async fn build_at(config: NodeConfig, swarm: Option<SwarmSetup>, place: Arc<Place>) -> Result<Running, BuildError> {
    let (mut web, mut adapters) = (None, Vec::new());
    if config.web.enabled {
        let address = config.web.listen;
        let unavailable = |source| BuildError::Listen { address, source };
        let listener = std::net::TcpListener::bind(address).map_err(unavailable)?;
        listener.set_nonblocking(true).map_err(unavailable)?;
        web = Some(listener.local_addr().map_err(unavailable)?);
        adapters.push(gateway::adapter(listener, gateway::settings(&config)));
    }
    if config.ros2.enabled {
        adapters.push(ros2::adapter(place.clone()));
    }
    adapters.extend(skein_recorder::adapter(&config.recorder));
    let node = Node::start(config, adapters, swarm, place).await?;
    gateway::serve_others(&node.handle());
    Ok(Running { node, web })
}
