//! The route that is put on a vehicle's autopilot, and what became of it.
//!
//! Must never do: judge a route (whoever has it uploaded has had it judged), or have it flown.

use super::VehicleState;
use skein_domain::exchange::Severity;
use skein_domain::link::RoutePoint;
use skein_domain::{Refusal, RequestId};
use skein_state::UploadEnd;
use skein_view::EventKind;

impl VehicleState {
    /// Begins to put a route on the autopilot.
    pub(super) fn upload_route(&self, route: &[RoutePoint]) {
        let request = self.record.route.lock().begin(route.len());
        self.record.link().upload_route(self.shared.now(), request, route);
    }

    /// What became of an upload. An answer to one that was replaced says nothing of the present one.
    pub(super) fn tell_upload(&self, request: RequestId, outcome: Result<(), Refusal>) {
        let name = &self.record.name;
        let Some(end) = self.record.route.lock().end(request, outcome) else {
            return;
        };
        let (severity, text) = match end {
            UploadEnd::Held { points } => {
                let text = format!("{name}: the autopilot holds a route of {points} points");
                (Severity::Info, text)
            }
            UploadEnd::Failed { refusal } => {
                let text = format!("{name}: the autopilot does not take the route: {refusal}");
                (Severity::Warning, text)
            }
        };
        self.record(severity, EventKind::Trajectory, text);
    }
}
