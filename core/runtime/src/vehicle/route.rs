//! The route that is put on a vehicle's autopilot, and what became of it.
//!
//! Must never do: judge a route (whoever has it uploaded has had it judged), or have it flown.

use super::VehicleState;
use crate::snapshot::EventKind;
use skein_domain::exchange::Severity;
use skein_domain::link::RoutePoint;
use skein_domain::{Refusal, RequestId, RouteUpload};

/// Request ids of uploads: this many from here on, beyond what models use and below those of the watch.
const FIRST_REQUEST: u32 = u32::MAX - 1_000_000;
const REQUESTS: u32 = 900_000;

/// The route on a vehicle, beyond its actor's life.
#[derive(Debug, Default)]
pub struct HeldRoute {
    asked: u32,
    state: Option<RouteUpload>,
}

impl HeldRoute {
    /// What became of it; nothing if none was ever asked for.
    pub fn state(&self) -> Option<RouteUpload> {
        self.state.clone()
    }

    fn request(&self) -> RequestId {
        RequestId(FIRST_REQUEST + self.asked % REQUESTS)
    }
}

/// Whether a request is an upload.
pub fn is_upload(request: RequestId) -> bool {
    (FIRST_REQUEST..FIRST_REQUEST + REQUESTS).contains(&request.0)
}

impl VehicleState {
    /// Begins to put a route on the autopilot.
    pub(super) fn upload_route(&self, route: &[RoutePoint]) {
        let request = {
            let mut held = self.cell.route.lock();
            held.asked = held.asked.wrapping_add(1);
            let points = u16::try_from(route.len()).unwrap_or(u16::MAX);
            held.state = Some(RouteUpload::Sending { points });
            held.request()
        };
        self.cell.link.load().0.upload_route(self.board.now(), request, route);
    }

    /// What became of an upload. An answer to one that was replaced says nothing of the present one.
    pub(super) fn tell_upload(&self, request: RequestId, outcome: Result<(), Refusal>) {
        let name = &self.cell.name;
        let (severity, text) = {
            let mut held = self.cell.route.lock();
            let Some(RouteUpload::Sending { points }) = held.state.clone().filter(|_| held.request() == request) else {
                return;
            };
            match outcome {
                Ok(()) => {
                    held.state = Some(RouteUpload::Held { points });
                    let text = format!("{name}: the autopilot holds a route of {points} points");
                    (Severity::Info, text)
                }
                Err(refusal) => {
                    let text = format!("{name}: the autopilot does not take the route: {refusal}");
                    held.state = Some(RouteUpload::Failed { refusal });
                    (Severity::Warning, text)
                }
            }
        };
        self.record(severity, EventKind::Trajectory, text);
    }
}
