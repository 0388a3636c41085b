//! What can go wrong with an endpoint as a whole. What goes wrong with one command is a `Refusal`.

use crate::address::EndpointAddress;
use std::io;

/// Why an endpoint could not be started, or ended.
#[derive(Debug, thiserror::Error)]
pub enum EndpointError {
    /// Another program, or another endpoint, has the port.
    #[error("endpoint `{name}`: {address} is in use by another program or endpoint")]
    AddressInUse {
        /// The endpoint's name.
        name: String,
        /// The address asked for.
        address: EndpointAddress,
    },
    /// The address could not be bound for another reason.
    #[error("endpoint `{name}`: cannot bind {address}: {source}")]
    Bind {
        /// The endpoint's name.
        name: String,
        /// The address asked for.
        address: EndpointAddress,
        /// What the system says.
        source: io::Error,
    },
    /// An endpoint of the same name is still running.
    #[error("endpoint `{name}`: another endpoint of this name is running")]
    NameInUse {
        /// The name.
        name: String,
    },
    /// A setting makes no sense.
    #[error("endpoint `{name}`: {detail}")]
    Setting {
        /// The endpoint's name.
        name: String,
        /// Which setting, and what would be right.
        detail: String,
    },
    /// The receiving task ended unexpectedly.
    #[error("endpoint `{name}`: receiving ended: {detail}")]
    Ended {
        /// The endpoint's name.
        name: String,
        /// How.
        detail: String,
    },
}
