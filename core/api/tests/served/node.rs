//! A node and its server for one test.

use serde_json::Value;
use skein_api::ApiSettings;
use skein_config::NodeConfig;
use skein_runtime::{Node, NodeHandle};
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// A served node. [`Served::stop`] ends it.
pub struct Served {
    node: Node,
    address: SocketAddr,
    stop: oneshot::Sender<()>,
    server: JoinHandle<std::io::Result<()>>,
    _plugins: tempfile::TempDir,
    pub http: reqwest::Client,
}

impl Served {
    pub async fn start() -> Self {
        Self::start_with(|_| ()).await
    }

    pub async fn start_with(adapt: impl FnOnce(&mut NodeConfig)) -> Self {
        let plugins = tempfile::tempdir().unwrap();
        let mut config = NodeConfig::default();
        config.plugins.directories = vec![plugins.path().to_owned()];
        adapt(&mut config);
        let settings = ApiSettings::from(&config.web);
        let node = Node::start(config, Vec::new(), None, Arc::default()).await.unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel::<()>();
        let router = skein_api::router(node.handle(), &settings);
        let server = tokio::spawn(skein_api::serve(listener, router, async move {
            let _ = stopped.await;
        }));
        Self {
            node,
            address,
            stop,
            server,
            _plugins: plugins,
            http: reqwest::Client::new(),
        }
    }

    pub fn handle(&self) -> NodeHandle {
        self.node.handle()
    }

    pub fn address(&self) -> SocketAddr {
        self.address
    }

    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    /// Ends the server, then the node.
    pub async fn stop(self) {
        self.stop.send(()).unwrap();
        self.server.await.unwrap().unwrap();
        self.node.stop().await;
    }

    /// An answer's status and its body as JSON; null if it has none.
    pub async fn ask(&self, method: &str, path: &str, body: Option<Value>) -> (u16, Value) {
        let mut request = self.http.request(method.parse().unwrap(), self.url(path));
        if let Some(body) = body {
            request = request.json(&body);
        }
        let answer = request.send().await.unwrap();
        let status = answer.status().as_u16();
        let text = answer.text().await.unwrap();
        (status, serde_json::from_str(&text).unwrap_or(Value::Null))
    }
}
