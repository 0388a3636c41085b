//! What is in a sample of the topics.
//!
//! Must never do: change its shape; a type of another shape gets another name.
//!
//! In IDL:
//!
//! ```idl
//! module skein { module bus {
//!   @final struct Datagram {
//!     unsigned long long sender;
//!     unsigned long long receiver;  // without meaning if it is for all
//!     boolean for_all;
//!     sequence<octet> content;      // sealed
//!   };
//! }; };
//! ```

use serde::{Deserialize, Serialize};
use skein_bus::transport::To;
use skein_domain::NodeId;

/// One datagram as a sample. The order of the fields is that of the IDL.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Packet {
    sender: u64,
    receiver: u64,
    for_all: bool,
    content: Vec<u8>,
}

impl Packet {
    /// Of these bytes.
    #[must_use]
    pub fn new(from: NodeId, to: To, bytes: &[u8]) -> Self {
        let (receiver, for_all) = match to {
            To::One(node) => (node.0, false),
            To::All => (0, true),
        };
        Self {
            sender: from.0,
            receiver,
            for_all,
            content: bytes.to_vec(),
        }
    }

    /// Sender and bytes, if it is for this node: what it tells all others is not for itself.
    #[must_use]
    pub fn for_node(self, me: NodeId) -> Option<(NodeId, Vec<u8>)> {
        let mine = if self.for_all {
            self.sender != me.0
        } else {
            self.receiver == me.0
        };
        mine.then_some((NodeId(self.sender), self.content))
    }
}
