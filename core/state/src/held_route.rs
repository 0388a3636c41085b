//! The route that is on a vehicle's autopilot, beyond the life of the vehicle's actor.
//!
//! Must never do: judge a route, or have it flown.

use skein_domain::{Refusal, RequestId, RouteUpload};

/// Request ids of uploads: this many from here on, beyond what models use and below those of the failsafe monitor.
const FIRST_REQUEST: u32 = u32::MAX - 1_000_000;
const REQUESTS: u32 = 900_000;

/// The route on a vehicle.
#[derive(Debug, Default)]
pub struct HeldRoute {
    asked: u32,
    state: Option<RouteUpload>,
}

/// What became of an upload.
#[derive(Debug, Clone, PartialEq)]
pub enum UploadEnd {
    /// The autopilot holds it.
    Held {
        /// How many points it has.
        points: u16,
    },
    /// The autopilot does not take it.
    Failed {
        /// Why.
        refusal: Refusal,
    },
}

impl HeldRoute {
    /// What became of it; nothing if none was ever asked for.
    #[must_use]
    pub fn state(&self) -> Option<RouteUpload> {
        self.state.clone()
    }

    /// An upload of so many points begins, under this id.
    pub fn begin(&mut self, points: usize) -> RequestId {
        self.asked = self.asked.wrapping_add(1);
        let points = u16::try_from(points).unwrap_or(u16::MAX);
        self.state = Some(RouteUpload::Sending { points });
        self.request()
    }

    /// An upload has ended; nothing if it was replaced meanwhile.
    pub fn end(&mut self, request: RequestId, outcome: Result<(), Refusal>) -> Option<UploadEnd> {
        let Some(RouteUpload::Sending { points }) = self.state.clone().filter(|_| self.request() == request) else {
            return None;
        };
        Some(match outcome {
            Ok(()) => {
                self.state = Some(RouteUpload::Held { points });
                UploadEnd::Held { points }
            }
            Err(refusal) => {
                self.state = Some(RouteUpload::Failed {
                    refusal: refusal.clone(),
                });
                UploadEnd::Failed { refusal }
            }
        })
    }

    fn request(&self) -> RequestId {
        RequestId(FIRST_REQUEST + self.asked % REQUESTS)
    }
}

/// Whether a request is an upload.
#[must_use]
pub fn is_upload(request: RequestId) -> bool {
    (FIRST_REQUEST..FIRST_REQUEST + REQUESTS).contains(&request.0)
}
