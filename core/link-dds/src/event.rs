//! What is noticed of vehicles on DDS, for the node. What happens on one vehicle's link comes as `LinkEvent` from the link itself.

use crate::admission::Mismatch;
use crate::definitions::Release;
use crate::link::DdsLink;
use crate::naming::{Namespace, TopicName};
use std::sync::Arc;

/// Something that was noticed.
#[derive(Debug, Clone)]
pub enum DdsEvent {
    /// A vehicle has been admitted for the first time.
    Discovered {
        /// Its link; stays the same over losses, reboots and restarts of its agent.
        link: Arc<DdsLink>,
        /// Its system id.
        system_id: u8,
        /// Releases of PX4 that its messages fit.
        releases: Vec<Release>,
    },
    /// A vehicle is not taken, for one of its messages does not fit.
    Refused {
        /// Where its topics are.
        namespace: Namespace,
        /// What does not fit.
        mismatch: Mismatch,
    },
    /// A vehicle is there, but topics that are needed are not, or are silent.
    Incomplete {
        /// Where its topics are.
        namespace: Namespace,
        /// What is waited for.
        missing: Vec<&'static str>,
    },
    /// One message of a vehicle that flies does not fit; it is left alone, and the vehicle flown without it.
    Ignored {
        /// Where its topics are.
        namespace: Namespace,
        /// What does not fit.
        mismatch: Mismatch,
    },
    /// Two speak as one vehicle: it gets no commands or setpoints until one has been silent for a while.
    Duplicate {
        /// Where the topics are.
        namespace: Namespace,
        /// Its system id.
        system_id: u8,
    },
    /// One of two has gone silent; the vehicle is obeyed again.
    DuplicateCleared {
        /// Where the topics are.
        namespace: Namespace,
        /// Its system id.
        system_id: u8,
    },
    /// Another program writes to a topic on which a vehicle takes commands or setpoints, or speaks on one of its own without being an autopilot.
    ForeignPublisher {
        /// The topic.
        topic: TopicName,
    },
}

/// Where events go. Called on the thread that reads: must return at once.
pub type EventSink = Arc<dyn Fn(DdsEvent) + Send + Sync>;
