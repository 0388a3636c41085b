//! Simulated vehicles on DDS, as PX4 is behind its uXRCE-DDS agent: topics of `px4_msgs` in the shapes of a release, out and in.
//!
//! * [`start`]: a simulation whose vehicles have topics. All of them are on one participant.
//! * [`DdsCarrier`]: the same part by part, for [`skein_sim::Simulation::start_with`].
//!
//! Must never do: decide anything about a flight, or let the simulation's thread wait for DDS. Others are found over the loopback
//! interface alone.
#![forbid(unsafe_code)]

mod carrier;
mod endpoints;
mod octets;
mod settings;
mod shapes;

pub use carrier::DdsCarrier;
pub use settings::{DdsSettings, Namespaces};
pub use skein_link_dds::definitions::Release;

use skein_sim::{SimError, SimSettings, Simulation};
use std::sync::Arc;
use thiserror::Error;

/// Why there is nobody who carries topics.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum OpenError {
    /// There is no such domain.
    #[error("DDS domain {0} is beyond the last one, 101")]
    Domain(u16),
    /// DDS could not begin, or could not make a topic, reader or writer.
    #[error("DDS: {0}")]
    Dds(String),
}

pub(crate) fn failed(error: impl std::fmt::Display) -> OpenError {
    OpenError::Dds(error.to_string())
}

/// Why there is no simulation.
#[derive(Debug, Error)]
pub enum StartError {
    /// Nobody carries its topics.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// It could not be started itself.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// Starts a simulation; those of its vehicles that have topics ([`SimSettings::faces`]) have them on DDS.
///
/// # Errors
/// When DDS or the simulation cannot begin.
pub fn start(simulation: SimSettings, dds: &DdsSettings) -> Result<Simulation, StartError> {
    let carrier = DdsCarrier::open(dds)?;
    Ok(Simulation::start_with(simulation, Some(Arc::new(carrier)))?)
}
