//! The gateway actor: serves dashboard and API on a listener that outlives it, so that its restart loses no port.

use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_api::ApiSettings;
use skein_config::NodeConfig;
use skein_runtime::{Adapter, NodeHandle};
use std::sync::Arc;
use tokio::task::JoinHandle;

/// The actor.
struct Gateway;

struct GatewayArguments {
    node: NodeHandle,
    listener: std::net::TcpListener,
    settings: ApiSettings,
}

/// The server has ended; that is always a failure.
struct Ended(String);

struct GatewayState {
    server: JoinHandle<()>,
}

impl Drop for GatewayState {
    fn drop(&mut self) {
        self.server.abort();
    }
}

impl Actor for Gateway {
    type Msg = Ended;
    type State = GatewayState;
    type Arguments = GatewayArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<Ended>,
        arguments: GatewayArguments,
    ) -> Result<GatewayState, ActorProcessingErr> {
        let listener = tokio::net::TcpListener::from_std(arguments.listener)?;
        let router = skein_api::router(arguments.node, &arguments.settings);
        let server = tokio::spawn(async move {
            let ended = skein_api::serve(listener, router, std::future::pending()).await;
            // An actor that is gone needs no word of it.
            let _ = myself.cast(Ended(
                ended.map_or_else(|e| e.to_string(), |()| "the server ended".into()),
            ));
        });
        Ok(GatewayState { server })
    }

    async fn handle(&self, _: ActorRef<Ended>, ended: Ended, _: &mut GatewayState) -> Result<(), ActorProcessingErr> {
        Err(ended.0.into())
    }
}

/// What the API is served with.
#[must_use]
pub fn settings(config: &NodeConfig) -> ApiSettings {
    ApiSettings {
        allowed_hosts: config.web.allowed_hosts.clone(),
        ..ApiSettings::default()
    }
}

/// Has this node answer what came in at other nodes' gateways about its vehicles.
pub fn serve_others(node: &NodeHandle) {
    node.serve_api(skein_api::serve_others(node.clone()));
}

/// The gateway as a part of the node.
pub fn adapter(listener: std::net::TcpListener, settings: ApiSettings) -> Adapter {
    let listener = Arc::new(listener);
    Adapter {
        name: "gateway".into(),
        start: Arc::new(move |node, supervisor| {
            let (listener, settings) = (listener.clone(), settings.clone());
            Box::pin(async move {
                let listener = listener.try_clone().map_err(|e| e.to_string())?;
                let arguments = GatewayArguments {
                    node,
                    listener,
                    settings,
                };
                let spawned = Gateway::spawn_linked(None, Gateway, arguments, supervisor).await;
                spawned.map(|(actor, _)| actor.get_id()).map_err(|e| e.to_string())
            })
        }),
    }
}
