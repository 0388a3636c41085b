//! A recording of a flight as a file (MCAP): what its topics are and what is told on them, how it is written so that it survives the end of the
//! program at any moment, how it is read whatever is wrong with it. The three types to know: [`Topic`], [`Writer`], [`Recording`].
//!
//! Must never do: know an actor or a clock, or take more memory for a file than one chunk of it does.
#![forbid(unsafe_code)]

mod audit;
mod chunk;
mod damage;
pub mod decisions;
mod encoded;
mod header;
mod lengths;
mod messages;
mod order;
mod plain_schema;
mod reader;
mod redecide;
pub mod scene;
mod telemetry;
mod topic;
mod writer;

pub use audit::{AuditChain, AuditRecord, Broken};
pub use damage::{Damage, ReadError};
pub use encoded::Encoded;
pub use header::{FORMAT, Header, METADATA, TimeBase};
pub use messages::{Message, Messages, Select};
pub use order::Merged;
pub use reader::{Recording, TopicInfo};
pub use redecide::{Difference, Redecided, Redecider};
pub use skein_view::Audit;
pub use telemetry::{ClockOffset, ClockRecord, RecorderState, SetpointRecord, VehicleTelemetry};
pub use topic::{Topic, TopicSchema};
pub use writer::{WriteError, Writer};

#[cfg(test)]
mod tests;
