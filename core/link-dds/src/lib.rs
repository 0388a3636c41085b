//! PX4 over DDS, through its uXRCE-DDS agent: its messages by release, the check that they fit, and one link per vehicle.
//!
//! Must never do: decide where a vehicle flies; read a sample as a message that it is not.
#![forbid(unsafe_code)]

pub mod admission;
pub mod cdr;
pub mod definitions;
pub mod event;
pub mod link;
pub mod messages;
pub mod naming;
pub mod node;
pub mod raw;
pub mod sample;
pub mod session;
pub mod sources;
#[cfg(test)]
mod specimen;
pub mod type_hash;

pub use event::{DdsEvent, EventSink};
pub use link::DdsLink;
pub use node::{DdsArguments, DdsLinkTable, DdsNode};
pub use raw::DdsError;
