//! The same messages live, over Foxglove's WebSocket protocol, for Foxglove and Lichtblick.
//!
//! Must never do: take anything from who looks on; wait for one that is slow.

use foxglove::websocket::Capability;
use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer, WebSocketServerHandle,
};
use skein_recording::{Encoded, TimeBase, Topic};
use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::Arc;

/// So many messages wait for one that looks on; then the oldest are dropped.
const BACKLOG: usize = 1024;

/// Whoever looks on.
pub struct Live {
    context: Arc<Context>,
    channels: HashMap<Topic, Arc<RawChannel>>,
    server: Option<WebSocketServerHandle>,
}

impl Live {
    /// Listens from now on.
    ///
    /// # Errors
    /// When the address cannot be listened on.
    pub async fn listen(
        address: SocketAddr,
        name: &str,
        runtime: &tokio::runtime::Handle,
    ) -> Result<Self, FoxgloveError> {
        let context = Context::new();
        let server = WebSocketServer::new()
            .name(name)
            .bind(address.ip().to_string(), address.port())
            .capabilities(std::iter::empty::<Capability>())
            .message_backlog_size(BACKLOG)
            .tokio_runtime(runtime)
            .context(&context)
            .start()
            .await?;
        Ok(Self {
            context,
            channels: HashMap::new(),
            server: Some(server),
        })
    }

    /// Shows a message to whoever wants its topic.
    pub fn show(&mut self, message: &Encoded, base: TimeBase) {
        let channel = match self.channels.get(&message.topic) {
            Some(channel) => channel,
            None => {
                let Some(channel) = self.channel(&message.topic) else {
                    return;
                };
                self.channels.entry(message.topic.clone()).or_insert(channel)
            }
        };
        if channel.has_sinks() {
            let at = PartialMetadata {
                log_time: Some(base.unix_ns(message.at)),
            };
            channel.log_with_meta(&message.bytes, at);
        }
    }

    fn channel(&self, topic: &Topic) -> Option<Arc<RawChannel>> {
        let schema = topic.schema();
        let built = ChannelBuilder::new(topic.to_string())
            .schema(Schema::new(schema.name, schema.encoding, schema.data))
            .message_encoding(schema.message_encoding)
            .context(&self.context)
            .build_raw();
        built
            .inspect_err(|error| tracing::warn!("{topic} is not shown live: {error}"))
            .ok()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            // It ends by itself; nobody waits.
            drop(server.stop());
        }
    }
}
