//! Another version of the program on a node, and back: archives, the versions that a node keeps, the swap, the roll-out over a swarm. The three
//! types to know: [`Versions`] (the rules, pure), [`Slots`] (what is kept on the disk), [`Upgrader`] (the node's end).
//!
//! Must never do: start another version while a vehicle of the node is armed or not heard; leave a node without a version that has confirmed
//! itself; write outside of its own folder.
#![forbid(unsafe_code)]

mod archive;
mod ground;
mod incoming;
mod manifest;
mod rollout;
mod rules;
mod slots;
mod start;
mod trial;
mod upgrader;

pub use archive::{ArchiveError, check, pack};
pub use ground::{Ground, RolloutRequest};
pub use incoming::MOST_ARCHIVE_BYTES;
pub use manifest::{Manifest, ManifestError};
pub use rollout::begin;
pub use rules::{Expectations, Package, Seen, Start, Trial, Verdict, Version, Versions};
pub use slots::{Slots, SlotsError};
pub use start::{Chosen, Running, cannot_start, choose};
pub use trial::HangGuard;
pub use upgrader::{Swap, Upgrader};
