//! The two ways to reach a vehicle: frames of MAVLink, and the topics of its autopilot.
//!
//! Must never do: know how topics are carried; that is a [`crate::topics::TopicCarrier`]'s.

/// One way to reach a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Face {
    /// MAVLink over UDP.
    Mavlink,
    /// The autopilot's own topics, as its agent puts them on DDS.
    Dds,
}

/// Which ways there are to reach a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Faces {
    /// MAVLink alone: no topics.
    #[default]
    Mavlink,
    /// Topics alone: no port is bound.
    Dds,
    /// Both.
    Both,
}

impl Faces {
    /// Whether this way is one of them.
    #[must_use]
    pub fn has(self, face: Face) -> bool {
        match self {
            Self::Both => true,
            Self::Mavlink => face == Face::Mavlink,
            Self::Dds => face == Face::Dds,
        }
    }
}
