//! Which message is on which topic in which release of PX4.
//!
//! Must never do: hold two definitions of one topic and version that a sample's length does not tell apart.

use crate::cdr::{CdrError, Encoding, decode, fits};
use crate::messages::{Field, Message, incoming, size_bytes};
use crate::sample::{Implausible, Sample};
use crate::type_hash;
use std::fmt;
use thiserror::Error;

/// A release of PX4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Release {
    /// 1.15: the last one without versions of messages.
    V1_15,
    /// 1.16.
    V1_16,
    /// 1.17.
    V1_17,
    /// 1.18.
    V1_18,
    /// What was developed after 1.18, as of July 2026.
    Later,
}

impl Release {
    /// All of them, oldest first.
    pub const ALL: [Self; 5] = [Self::V1_15, Self::V1_16, Self::V1_17, Self::V1_18, Self::Later];
}

impl fmt::Display for Release {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::V1_15 => "1.15",
            Self::V1_16 => "1.16",
            Self::V1_17 => "1.17",
            Self::V1_18 => "1.18",
            Self::Later => "after 1.18",
        })
    }
}

/// Whether a vehicle can be flown without a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Need {
    /// Samples of it must have been seen.
    Seen,
    /// It may be missing.
    Optional,
}

/// A topic that Skein reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// What the vehicle does.
    Status,
    /// Where it is in its own frame.
    LocalPosition,
    /// Whether it stands on the ground.
    LandDetected,
    /// Answers to commands.
    CommandAck,
    /// How it is turned.
    Attitude,
    /// Where it is on Earth.
    GlobalPosition,
    /// Its battery.
    Battery,
    /// Its satellite receiver.
    Gnss,
    /// Where it was launched.
    Home,
    /// Its clock and its agent's.
    Timesync,
}

impl Topic {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Status,
        Self::LocalPosition,
        Self::LandDetected,
        Self::CommandAck,
        Self::Attitude,
        Self::GlobalPosition,
        Self::Battery,
        Self::Gnss,
        Self::Home,
        Self::Timesync,
    ];

    /// Its name without a version.
    #[must_use]
    pub fn base(self) -> &'static str {
        match self {
            Self::Status => "vehicle_status",
            Self::LocalPosition => "vehicle_local_position",
            Self::LandDetected => "vehicle_land_detected",
            Self::CommandAck => "vehicle_command_ack",
            Self::Attitude => "vehicle_attitude",
            Self::GlobalPosition => "vehicle_global_position",
            Self::Battery => "battery_status",
            Self::Gnss => "vehicle_gps_position",
            Self::Home => "home_position",
            Self::Timesync => "timesync_status",
        }
    }

    /// The topic of this name.
    #[must_use]
    pub fn of(base: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.base() == base)
    }

    /// What PX4 calls its message.
    #[must_use]
    pub fn message(self) -> &'static str {
        DEFINITIONS.iter().find(|d| d.topic == self).map_or("", |d| d.message)
    }

    /// Whether a vehicle can be flown without it.
    ///
    /// PX4 offers a topic from its first message on: the one of answers is not there before a command was answered. 1.15 has none of landing.
    #[must_use]
    pub fn need(self) -> Need {
        match self {
            Self::Status | Self::LocalPosition => Need::Seen,
            _ => Need::Optional,
        }
    }
}

/// A topic that Skein writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Command {
    /// Commands.
    VehicleCommand,
    /// What of a setpoint counts; keeps OFFBOARD alive.
    OffboardControlMode,
    /// Setpoints.
    TrajectorySetpoint,
}

impl Command {
    /// All of them.
    pub const ALL: [Self; 3] = [
        Self::VehicleCommand,
        Self::OffboardControlMode,
        Self::TrajectorySetpoint,
    ];

    /// Its name. All releases that are known have version 0 of these.
    #[must_use]
    pub fn base(self) -> &'static str {
        match self {
            Self::VehicleCommand => "vehicle_command",
            Self::OffboardControlMode => "offboard_control_mode",
            Self::TrajectorySetpoint => "trajectory_setpoint",
        }
    }

    /// The topic of this name.
    #[must_use]
    pub fn of(base: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|command| command.base() == base)
    }

    /// What PX4 calls its message.
    #[must_use]
    pub fn message(self) -> &'static str {
        match self {
            Self::VehicleCommand => incoming::VehicleCommand::NAME,
            Self::OffboardControlMode => incoming::OffboardControlMode::NAME,
            Self::TrajectorySetpoint => incoming::TrajectorySetpoint::NAME,
        }
    }

    /// The fields of its message.
    #[must_use]
    pub fn fields(self) -> &'static [Field] {
        match self {
            Self::VehicleCommand => incoming::VehicleCommand::FIELDS,
            Self::OffboardControlMode => incoming::OffboardControlMode::FIELDS,
            Self::TrajectorySetpoint => incoming::TrajectorySetpoint::FIELDS,
        }
    }
}

/// Why a sample cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SampleError {
    /// It is not the message.
    #[error(transparent)]
    Cdr(#[from] CdrError),
    /// It cannot be true.
    #[error(transparent)]
    Implausible(#[from] Implausible),
}

/// One shape of the message on a topic.
#[derive(Debug, Clone, Copy)]
pub struct Definition {
    /// The topic.
    pub topic: Topic,
    /// Version that the topic's name carries.
    pub version: u32,
    /// What PX4 calls the message.
    pub message: &'static str,
    /// Which releases it fits.
    pub releases: &'static [Release],
    /// Its fields.
    pub fields: &'static [Field],
    read: fn(Encoding, &[u8]) -> Result<Sample, CdrError>,
}

impl Definition {
    const fn new<M: Message + Into<Sample>>(topic: Topic, version: u32, releases: &'static [Release]) -> Self {
        Self {
            topic,
            version,
            message: M::NAME,
            releases,
            fields: M::FIELDS,
            read: |encoding, bytes| decode::<M>(encoding, bytes).map(Into::into),
        }
    }

    /// Octets of a sample.
    #[must_use]
    pub fn size_bytes(&self) -> usize {
        size_bytes(self.fields)
    }

    /// The hash that ROS 2 gives its type.
    #[must_use]
    pub fn type_hash(&self) -> String {
        type_hash::of_px4(self.message, self.fields)
    }

    /// Reads a sample.
    ///
    /// # Errors
    /// If it is not this message, or cannot be true.
    pub fn read(&self, encoding: Encoding, bytes: &[u8]) -> Result<Sample, SampleError> {
        let sample = (self.read)(encoding, bytes)?;
        sample.check()?;
        Ok(sample)
    }
}

/// The topic of each message that PX4 sends, by the name of the message.
mod topic_of {
    pub use super::Topic::{
        Attitude as VehicleAttitude, Battery as BatteryStatus, CommandAck as VehicleCommandAck,
        GlobalPosition as VehicleGlobalPosition, Gnss as SensorGps, Home as HomePosition,
        LandDetected as VehicleLandDetected, LocalPosition as VehicleLocalPosition, Status as VehicleStatus,
        Timesync as TimesyncStatus,
    };
}

/// All of them: each message in each shape, with the releases from the one that brought it up to the one before the next.
pub const DEFINITIONS: &[Definition] = include!(concat!(env!("OUT_DIR"), "/definitions.rs"));

/// The definitions of a topic in a version.
pub fn of(topic: Topic, version: u32) -> impl Iterator<Item = &'static Definition> {
    DEFINITIONS
        .iter()
        .filter(move |d| d.topic == topic && d.version == version)
}

/// The one among the definitions of a topic in a version that a sample of so many octets fits.
#[must_use]
pub fn by_size(topic: Topic, version: u32, sample_bytes: usize) -> Option<&'static Definition> {
    of(topic, version).find(|d| fits(sample_bytes, d.size_bytes()))
}

#[cfg(test)]
mod tests;
