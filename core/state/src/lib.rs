//! What the actors of a node share by reading instead of asking: the vehicles, payloads and plugin instances beyond their actors' lives, what is
//! known of the swarm's other nodes, what operators told, the messages of the mailboxes. The three types to know: [`SharedState`], [`VehicleRecord`],
//! [`cluster::share::SwarmShare`].
//!
//! Must never do: contain an actor, wait, or hold a lock across an await.
#![forbid(unsafe_code)]

pub mod asks;
pub mod by_hand;
pub mod cluster;
mod commanded;
mod coordination;
pub mod emergency;
mod failsafe;
mod held_route;
mod mailbox;
mod observed;
mod operators;
mod overrun;
mod payload;
pub mod picture;
mod plugin;
mod plugins;
mod recordings;
pub mod restart;
pub mod resume;
mod shared;
mod tape;
mod vehicle;
mod vehicles;
pub mod video;
pub mod whole_file;

pub use commanded::{Commanded, Itinerary, LegProgress};
pub use coordination::SharedCoordination;
pub use failsafe::{FailsafeMonitor, Holding};
pub use held_route::{HeldRoute, UploadEnd, is_upload};
pub use mailbox::{
    ActorSlot, Asker, ExchangeReply, ParameterOrder, ParameterOutcome, PayloadMessage, SwarmMessage, TrackingMessage,
    VehicleMessage, asking,
};
pub use observed::{MOST_FOR_OTHERS, Observed, Seen, SeenCounts};
pub use operators::Operators;
pub use overrun::Overrun;
pub use payload::{PayloadPublished, PayloadRecord, Report, TransportAddress};
pub use plugin::{PluginIdentity, PluginRecord};
pub use plugins::Plugins;
pub use recordings::{Recording, Recordings};
pub use shared::SharedState;
pub use tape::{FailsafeStep, JudgedSetpoint, LeadershipTurn, MadePlan, Taken, Tape, Thinning, Writing};
pub use vehicle::{PublishedState, VehicleRecord};
pub use vehicles::Vehicles;
