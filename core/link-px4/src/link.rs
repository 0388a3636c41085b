//! One vehicle's link as the vehicle actor sees it: the sans-I/O core behind a lock, and the way out.

use skein_domain::link::{LinkEvent, VehicleLink};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, LinkHealth, NodeTime, RequestId, SystemId, Telemetry};

/// One PX4 vehicle's link. Shared by the endpoint (frames in, ticks) and the vehicle actor (requests, setpoints).
#[derive(Debug)]
pub struct Px4Link {
    system_id: SystemId,
}

impl VehicleLink for Px4Link {
    fn system_id(&self) -> SystemId {
        self.system_id
    }
    fn read(&self, _now: NodeTime) -> (Telemetry, LinkHealth) {
        Default::default()
    }
    fn take_events(&self) -> Vec<LinkEvent> {
        Vec::new()
    }
    fn request(&self, _now: NodeTime, _request: RequestId, _command: AutopilotCommand) {}
    fn stream(&self, _now: NodeTime, _setpoint: LocalSetpoint, _expires: NodeTime) {}
    fn stop_stream(&self, _now: NodeTime) {}
}
