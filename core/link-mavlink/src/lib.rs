//! PX4 over MAVLink: one actor per socket or serial line, and one link per vehicle heard on it.
//!
//! Limits that a caller has to know:
//! * The emergency stop is sent in the moment it is asked for and repeated at least ten times a second until the motors are seen
//!   stopped, ten seconds at most; also to a vehicle that is not heard. It is refused while two vehicles use one system id.
//! * A step of the autopilot's clock is told with the second TIMESYNC after it (within 1.2 s at the usual rate), if it is longer than
//!   50 ms and half of the round trip. One back by more than two seconds is told as a restart: by its stamps it is none other.
//! * Wind, second receiver and estimator are told only by autopilots that have them. PX4 estimates the wind of a multicopter only
//!   with `EKF2_DRAG_CTRL`, and tells no vertical wind. How old each of them is stands in `Telemetry::heard`.
//! * Parameters are read at the autopilot's own rate, and what got lost of them at most twenty times a second; the reading ends after five
//!   minutes, and at 4,096 parameters. None is written to an armed vehicle. Ranges only the autopilot knows: it may clip a value or take
//!   a senseless one.
//! * A route lies on the vehicle until its mode is set to MISSION. Whether it leads anywhere safe is its caller's business.
//! * What is heard of others ([`sighting`]) is their word, with their own errors; an aircraft without a valid height is left out.
//!
//! Must never do: decide where a vehicle flies, enter OFFBOARD unasked, or repeat a setpoint that has expired.
#![forbid(unsafe_code)]

pub mod address;
pub mod decode;
pub mod endpoint;
pub mod error;
pub mod event;
mod fields;
pub mod frame;
pub mod link;
pub mod logs;
pub mod metrics;
pub mod outbox;
mod outlet;
mod route_message;
pub mod settings;
pub mod sighting;
mod source;
pub mod table;
mod taps;
pub mod vehicle;

pub use address::{AddressError, EndpointAddress};
pub use endpoint::{Endpoint, EndpointArguments, EventSink};
pub use error::EndpointError;
pub use event::EndpointEvent;
pub use link::Px4Link;
pub use metrics::{EndpointCounters, EndpointMetrics};
pub use settings::EndpointSettings;
pub use sighting::{ReferenceSink, Sighting, Sightings};
pub use source::Source;
pub use table::LinkTable;
pub use vehicle::AutopilotIdentity;
pub use vehicle::cameras::{ToldCamera, ToldStream};
