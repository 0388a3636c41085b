//! What is to be done with an instance of a plugin.
//!
//! Must never do: do it.

use crate::frames::Frame;
use std::sync::Arc;

/// What is to be done with an instance.
#[derive(Debug)]
pub(crate) enum Task {
    /// Make it.
    Create { schema: u32, bytes: Vec<u8> },
    /// Call one of its methods, and if that went well take a snapshot.
    Invoke {
        method: u32,
        schema: u32,
        bytes: Vec<u8>,
        /// What can be read during the call.
        frames: Vec<Arc<Frame>>,
        then_snapshot: bool,
    },
    /// End it.
    Destroy,
}
