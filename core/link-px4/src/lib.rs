//! PX4 over MAVLink: one actor per socket or serial line, and one link per vehicle heard on it.
//!
//! Must never do: decide where a vehicle flies, enter OFFBOARD unasked, or repeat a setpoint that has expired.
#![forbid(unsafe_code)]

pub mod address;
pub mod decode;
pub mod endpoint;
pub mod error;
pub mod event;
pub mod frame;
pub mod link;
pub mod metrics;
pub mod modes;
pub mod outbox;
mod outlet;
pub mod settings;
pub mod sighting;
pub mod table;
mod taps;
pub mod vehicle;

pub use address::{AddressError, EndpointAddress};
pub use endpoint::{Endpoint, EndpointArguments, EventSink};
pub use error::EndpointError;
pub use event::{EndpointEvent, Source};
pub use link::Px4Link;
pub use metrics::{EndpointCounters, EndpointMetrics};
pub use settings::{EndpointSettings, LinkSettings, MessageRates};
pub use sighting::{ReferenceSink, Sighting, Sightings};
pub use table::LinkTable;
pub use vehicle::AutopilotIdentity;
pub use vehicle::parameters::{ParameterError, ParameterEvent, ParameterValue};
pub use vehicle::plan::Command;
