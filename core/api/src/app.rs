//! What every route can reach.

use crate::open_replays::OpenReplays;
use crate::view::View;
use crate::webrtc::WebRtc;
use axum::body::Bytes;
use skein_replay::Replay;
use skein_runtime::NodeHandle;
use std::sync::Arc;
use tokio::sync::{Semaphore, watch};

/// Streams served at once. A crew has a handful of screens; more is a mistake or an attack.
pub const MAX_STREAMS: usize = 64;

/// Viewers of videos over all ways at once. An operator has a wall of a dozen; more is a mistake or an attack.
pub const MAX_VIEWERS: usize = 96;

/// What every route can reach. Cheap to clone.
#[derive(Clone)]
pub struct App {
    /// The node.
    pub node: NodeHandle,
    /// What all streams share.
    pub view: Arc<View>,
    /// One permit for each stream that may be open.
    pub streams: Arc<Semaphore>,
    /// One permit for each viewer of a video.
    pub viewers: Arc<Semaphore>,
    /// Videos over WebRTC.
    pub webrtc: Arc<WebRtc>,
    /// The OpenAPI document.
    pub document: Bytes,
    /// The recorded flight that the node stands for, if it is none that flies.
    pub replay: Option<Arc<Replay>>,
    /// Recorded flights that are looked at beside it; of one that is itself a recording there are none.
    pub replays: Option<Arc<OpenReplays>>,
}

impl App {
    /// For one node, with the document of its routes.
    #[must_use]
    pub fn new(node: NodeHandle, document: Bytes) -> Self {
        Self {
            node,
            view: Arc::default(),
            streams: Arc::new(Semaphore::new(MAX_STREAMS)),
            viewers: Arc::new(Semaphore::new(MAX_VIEWERS)),
            webrtc: Arc::default(),
            document,
            replay: None,
            replays: None,
        }
    }

    /// For a recorded flight.
    #[must_use]
    pub fn of_replay(replay: Arc<Replay>, document: Bytes) -> Self {
        Self {
            replay: Some(replay.clone()),
            ..Self::new(replay.node().clone(), document)
        }
    }
}

/// Becomes true when the server is to end; streams close then.
#[derive(Debug, Clone)]
pub struct Closing(pub watch::Receiver<bool>);

impl Closing {
    /// Waits until the server is to end, or is gone.
    pub async fn wait(&mut self) {
        // An error says that the sender is gone, and the server with it: then nobody is left to answer to either.
        let _ = self.0.wait_for(|closing| *closing).await;
    }
}
