//! One message, encoded once for everything it goes to: the file and whoever looks on live.
//!
//! Must never do: hold back what could not be encoded without saying so.

use crate::topic::Topic;
use foxglove::Encode;
use serde::Serialize;
use skein_domain::NodeTime;

/// One message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// Where it belongs.
    pub topic: Topic,
    /// When what it tells of happened.
    pub at: NodeTime,
    /// The message.
    pub bytes: Vec<u8>,
}

impl Encoded {
    /// One of ours, as JSON. Numbers that are none (infinite, NaN) are told as null.
    ///
    /// # Errors
    /// When a value has no place in JSON, which is a fault of the type.
    pub fn json(topic: Topic, at: NodeTime, message: &impl Serialize) -> Result<Self, serde_json::Error> {
        let bytes = serde_json::to_vec(message)?;
        Ok(Self { topic, at, bytes })
    }

    /// One of Foxglove's messages.
    #[must_use]
    pub fn theirs(topic: Topic, at: NodeTime, message: &impl Encode) -> Self {
        let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        // A vector grows: there is nothing that it could refuse.
        let _ = message.encode(&mut bytes);
        Self { topic, at, bytes }
    }
}
