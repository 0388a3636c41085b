//! The sticks of one client that steers a vehicle by hand: at most so many per second go on to the node, of more the newest; what is refused is
//! told at once, and again only every second.
//!
//! Must never do: keep a stick that a newer one has replaced.

use super::ticks;
use crate::error::ApiError;
use crate::protocol::ErrorDetail;
use serde_json::json;
use skein_domain::{Refusal, Stick, VehicleId};
use std::time::Duration;
use tokio::time::{Instant, Interval};

/// Sticks go on no more often than this. A control period is as long: more would not be flown.
const EVERY: Duration = Duration::from_millis(20);
/// The same refusal is told again after so long.
const TOLD_AGAIN: Duration = Duration::from_secs(1);

/// What a client's sticks have come to.
pub(super) struct Sticks {
    waiting: Option<(VehicleId, Stick)>,
    period: Interval,
    told: Option<(&'static str, VehicleId, Instant)>,
}

impl Sticks {
    pub(super) fn new() -> Self {
        Self {
            waiting: None,
            period: ticks(EVERY),
            told: None,
        }
    }

    /// A stick came in. A client steers one vehicle: the newest replaces what waits, whichever vehicle that was for.
    pub(super) fn put(&mut self, vehicle: VehicleId, stick: Stick) {
        self.waiting = Some((vehicle, stick));
    }

    /// Waits until one may go on; for ever if none is there.
    pub(super) async fn due(&mut self) -> (VehicleId, Stick) {
        if let Some(stick) = self.waiting {
            self.period.tick().await;
            self.waiting = None;
            return stick;
        }
        std::future::pending().await
    }

    /// What a client is told of a refused stick; nothing if it was told the same just before.
    pub(super) fn refused(&mut self, vehicle: VehicleId, refusal: Refusal) -> Option<ErrorDetail> {
        let (code, now) = (refusal.code(), Instant::now());
        let again = |(told, of, at): &(&str, VehicleId, Instant)| {
            *told == code && *of == vehicle && now.duration_since(*at) < TOLD_AGAIN
        };
        if self.told.as_ref().is_some_and(again) {
            return None;
        }
        self.told = Some((code, vehicle, now));
        let facts = json!({ "stick": vehicle, "refusal": refusal });
        Some(ErrorDetail {
            detail: facts,
            ..ApiError::from(refusal).detail()
        })
    }

    /// One was taken: the next refusal is news.
    pub(super) fn taken(&mut self) {
        self.told = None;
    }
}

#[cfg(test)]
mod tests;
