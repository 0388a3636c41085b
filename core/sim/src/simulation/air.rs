//! What is between a vehicle and whoever speaks to it: loss and delay, the same for datagrams and for what topics carry.
//!
//! Must never do: look into what it carries.

use crate::settings::Impairment;
use crate::topics::{Asked, Published};
use crate::vehicle::LinkKind;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Something under way.
pub(super) enum Parcel {
    /// A datagram to the vehicle.
    Inbound(LinkKind, Vec<u8>),
    /// A frame of the vehicle.
    Outbound(LinkKind, Vec<u8>),
    /// Of a topic, to the vehicle.
    Asked(Asked),
    /// Of a topic of the vehicle.
    Published(Published),
}

/// Something that is held up.
pub(super) struct Delayed {
    due_s: f64,
    parcel: Parcel,
}

/// What everything has to pass through.
pub(super) struct Air {
    pub impairment: Impairment,
    pub now_s: f64,
}

impl Air {
    /// True if it gets through at once; else it is lost, or kept in `delayed` until it is due.
    pub(super) fn passes(
        &self,
        parcel: impl FnOnce() -> Parcel,
        delayed: &mut Vec<Delayed>,
        rng: &mut ChaCha8Rng,
    ) -> bool {
        let Impairment {
            loss,
            delay_s,
            jitter_s,
        } = self.impairment;
        if loss > 0.0 && rng.random_range(0.0..1.0) < loss {
            return false;
        }
        if delay_s <= 0.0 && jitter_s <= 0.0 {
            return true;
        }
        let extra_s = if jitter_s > 0.0 {
            rng.random_range(0.0..jitter_s)
        } else {
            0.0
        };
        delayed.push(Delayed {
            due_s: self.now_s + delay_s + extra_s,
            parcel: parcel(),
        });
        false
    }
}

/// Takes those that are due, oldest first.
pub(super) fn take_due(delayed: &mut Vec<Delayed>, now_s: f64) -> Vec<Parcel> {
    if delayed.is_empty() {
        return Vec::new();
    }
    let (mut due, rest): (Vec<_>, Vec<_>) = delayed.drain(..).partition(|d| d.due_s <= now_s);
    *delayed = rest;
    due.sort_by(|a, b| a.due_s.total_cmp(&b.due_s));
    due.into_iter().map(|d| d.parcel).collect()
}
