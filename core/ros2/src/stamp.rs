//! Moments of the node's clock as those of ROS 2, which count since 1970.
//!
//! Must never do: read a clock.

use crate::interfaces::standard::{Header, Time};
use skein_domain::NodeTime;
use std::time::Duration;

/// What both clocks say at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Stamps {
    /// The node's.
    pub node: NodeTime,
    /// The system's, since 1970.
    pub system: Duration,
}

impl Stamps {
    /// A moment of the node's clock.
    #[must_use]
    pub fn time(&self, at: NodeTime) -> Time {
        let since_us = i128::from(at.0) - i128::from(self.node.0);
        let us = (self.system.as_micros() as i128 + since_us).max(0);
        Time {
            sec: i32::try_from(us / 1_000_000).unwrap_or(i32::MAX),
            nanosec: (us % 1_000_000) as u32 * 1_000,
        }
    }

    /// A header for something that was at that moment.
    #[must_use]
    pub fn header(&self, at: NodeTime, frame_id: &str) -> Header {
        Header {
            stamp: self.time(at),
            frame_id: frame_id.to_owned(),
        }
    }
}
