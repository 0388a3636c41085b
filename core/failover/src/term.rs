//! What nodes tell each other: terms, pulses, and who may coordinate.
//!
//! Must never do: say that one term is better than another of the same number; only the leadership decides what is obeyed.

use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use skein_domain::NodeId;

/// How suited a node is to coordinate. Greater is better; of equals the smaller id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Encode, Decode)]
pub struct Standing {
    /// As configured.
    #[n(0)]
    pub priority: u8,
    /// Whose.
    #[n(1)]
    pub node: NodeId,
}

impl Ord for Standing {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.priority, std::cmp::Reverse(self.node)).cmp(&(other.priority, std::cmp::Reverse(other.node)))
    }
}

impl PartialOrd for Standing {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A term of the leadership.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Encode, Decode)]
pub struct Term {
    /// From 1; grows with every change of the holder.
    #[n(0)]
    pub number: u64,
    /// Who coordinates in it.
    #[n(1)]
    pub holder: Standing,
}

/// What every node tells about every tenth of a second. The newest of a node replaces the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Encode, Decode)]
pub struct Beacon {
    /// Who tells it.
    #[n(0)]
    pub from: NodeId,
    /// The term it obeys; none before the first.
    #[n(1)]
    pub obeys: Option<Term>,
    /// The newest pulse of that term's holder it knows of. The holder counts it up with every beacon of its own.
    #[n(2)]
    pub pulse: u64,
    /// How suited it is; none if it can't coordinate now.
    #[n(3)]
    pub standing: Option<Standing>,
}
