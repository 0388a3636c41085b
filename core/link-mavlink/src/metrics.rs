//! Counters of one endpoint, readable at any time without asking its actor.
//!
//! Must never do: lock or allocate; the receive path adds to these for every batch.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

macro_rules! counters {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {
        /// Counters of one endpoint since the node started; they survive its restarts.
        #[derive(Debug, Default)]
        pub struct EndpointMetrics { $($(#[$doc])* pub(crate) $name: AtomicU64),+ }

        /// The counters at one moment.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct EndpointCounters { $($(#[$doc])* pub $name: u64),+ }

        impl EndpointMetrics {
            /// All counters now.
            #[must_use]
            pub fn read(&self) -> EndpointCounters {
                EndpointCounters { $($name: self.$name.load(Relaxed)),+ }
            }

            /// Add what a batch counted.
            pub(crate) fn add(&self, batch: &EndpointCounters) {
                $(if batch.$name != 0 { self.$name.fetch_add(batch.$name, Relaxed); })+
            }
        }

        impl EndpointCounters {
            /// Every counter with its name, for exporters.
            #[must_use]
            pub fn named(&self) -> Vec<(&'static str, u64)> {
                vec![$((stringify!($name), self.$name)),+]
            }
        }
    };
}

counters!(
    /// Datagrams received (UDP), or reads (TCP and serial).
    datagrams_in,
    /// Bytes received.
    bytes_in,
    /// Frames received whole and, where the message is known, with the right checksum.
    frames_in,
    /// Frames of messages that nobody here reads; skipped.
    ignored,
    /// Frames of messages the protocol description here does not know; skipped.
    unknown,
    /// Frames with a wrong checksum.
    bad_crc,
    /// Datagrams that end in the middle of a frame.
    truncated,
    /// Bytes that belong to no frame.
    stray_bytes,
    /// Frames whose fields hold values the protocol description does not know.
    undecodable,
    /// Frames of a system id from another place than its vehicle's.
    foreign,
    /// Frames of systems that are no vehicle, or not yet one.
    unadopted,
    /// Datagrams or frames sent.
    frames_out,
    /// Bytes sent.
    bytes_out,
    /// Frames not sent because the socket or line was full.
    dropped_full,
    /// Frames not sent because the endpoint was down or the system refused.
    dropped_error,
    /// Errors of the system while receiving that were passed over.
    receive_errors,
    /// Times the endpoint woke up to receive.
    wake_ups,
    /// Times it was started.
    starts,
);

impl EndpointMetrics {
    /// Note one frame that was sent.
    pub(crate) fn sent(&self, bytes: usize) {
        self.frames_out.fetch_add(1, Relaxed);
        self.bytes_out.fetch_add(bytes as u64, Relaxed);
    }

    /// Note frames that could not be sent because the line was full.
    pub(crate) fn full(&self) {
        self.dropped_full.fetch_add(1, Relaxed);
    }

    /// Note a frame that could not be sent at all.
    pub(crate) fn failed(&self) {
        self.dropped_error.fetch_add(1, Relaxed);
    }
}
