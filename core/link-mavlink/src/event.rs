//! What an endpoint reports to the node: its own state, and vehicles found, moved or mistaken for each other.

use crate::link::Px4Link;
use crate::source::Source;
use std::net::SocketAddr;
use std::sync::Arc;

/// Something an endpoint noticed. What happens on one vehicle's link comes as `LinkEvent` from the link itself.
#[derive(Debug, Clone)]
pub enum EndpointEvent {
    /// It is up and receives.
    Bound {
        /// Its name.
        endpoint: Arc<str>,
        /// The local address of a socket; `None` on serial lines.
        local_addr: Option<SocketAddr>,
    },
    /// A TCP or serial line is down; the endpoint tries again by itself.
    Down {
        /// Its name.
        endpoint: Arc<str>,
        /// What the system says.
        reason: String,
    },
    /// A vehicle is heard for the first time.
    Discovered {
        /// Its link; stays the same over restarts of the endpoint, losses and reboots.
        link: Arc<Px4Link>,
        /// Its system id.
        system_id: u8,
        /// `MAV_AUTOPILOT` as its heartbeat gives it; 12 is PX4.
        autopilot: u8,
        /// `MAV_TYPE` as its heartbeat gives it; 2 is a quadrotor.
        vehicle_type: u8,
        /// Where it is heard.
        source: Source,
    },
    /// Another sender uses the system id of a vehicle. Elsewhere: what is sent still goes to the vehicle alone. At its own place: what is sent
    /// reaches both, and nothing is begun until one has been silent for a while.
    Duplicate {
        /// The system id.
        system_id: u8,
        /// Where the vehicle is heard, and answered.
        first: Source,
        /// Where the other is heard; the same if both are heard at one place.
        second: Source,
    },
    /// One of two senders with the same system id has gone silent.
    DuplicateCleared {
        /// The system id.
        system_id: u8,
        /// Where the remaining one is heard.
        remaining: Source,
    },
    /// A vehicle's frames come from another place now, after the old place went silent.
    Moved {
        /// Its system id.
        system_id: u8,
        /// The old place.
        from: Source,
        /// The new place.
        to: Source,
    },
    /// A system id went silent and another came up at the same place: the vehicle's id was changed.
    SystemIdChanged {
        /// The id that went silent.
        from: u8,
        /// The id heard now.
        to: u8,
        /// The place.
        source: Source,
    },
}
