//! Identities. A vehicle's id is the swarm's own number for it; its system id is what MAVLink calls it on one link.

use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident($inner:ty)) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
        #[serde(transparent)]
        #[cbor(transparent)]
        pub struct $name(#[n(0)] pub $inner);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "{}", self.0)
            }
        }
    };
}

id!(
    /// A vehicle of the swarm, unique over all links. By default equal to its MAVLink system id.
    VehicleId(u16)
);
id!(
    /// MAVLink system id: 1..=255, unique on one link only.
    SystemId(u8)
);
id!(
    /// One computer of the swarm: a run of the program with its own state. Random, and kept over restarts.
    NodeId(u64)
);
id!(
    /// How many times an actor or plugin instance has been started, from 1. A message that carries an older one is stale.
    Incarnation(u32)
);
id!(
    /// One command as an operator gave it; outcomes refer to it.
    CommandId(u64)
);
id!(
    /// One request of a plugin to the autopilot; the result refers to it.
    RequestId(u32)
);

impl Incarnation {
    /// The incarnation that follows this one.
    #[must_use]
    pub fn next(self) -> Self {
        Self(self.0.saturating_add(1))
    }
}
