//! Who of the fleet could keep something in view, from what its snapshot says.
//!
//! Must never do: decide who is asked.

use skein_coordination::observing::Candidate;
use skein_domain::payload::PayloadKind;
use skein_domain::{FlightState, LandedState, VehicleId};
use skein_view::{FleetSnapshot, VehicleSnapshot};

/// The model that keeps things in view. Another one that reports an activity as this one does is taken for such a one too.
const OBSERVING_MODEL: &str = "observation-uav";

/// Every vehicle whose model can keep something in view.
#[must_use]
pub fn candidates(snapshot: &FleetSnapshot) -> Vec<Candidate> {
    let members = snapshot
        .formation
        .as_ref()
        .map(|formation| formation.members.as_slice());
    let able = snapshot
        .vehicles
        .iter()
        .filter(|vehicle| vehicle.plugin == OBSERVING_MODEL || activity(vehicle).is_some());
    able.map(|vehicle| candidate(vehicle, members.unwrap_or_default()))
        .collect()
}

fn candidate(vehicle: &VehicleSnapshot, members: &[VehicleId]) -> Candidate {
    let flies = vehicle.landed == LandedState::InAir && vehicle.armed;
    let is_there =
        |state: &serde_json::Value| state.get("connected").and_then(serde_json::Value::as_bool) != Some(false);
    let has = |kind: PayloadKind| {
        let mut of_kind = vehicle.payloads.iter().filter(|payload| payload.kind == kind);
        of_kind.any(|payload| payload.state.as_ref().is_none_or(is_there))
    };
    let unfit = match vehicle.flight_state {
        _ if !vehicle.link.connected => Some("it is not heard".to_owned()),
        FlightState::PilotControl => Some("a pilot flies it".to_owned()),
        FlightState::Faulted => Some("it needs an operator".to_owned()),
        _ if vehicle
            .failsafe
            .as_ref()
            .is_some_and(|failsafe| failsafe.order.is_some()) =>
        {
            Some("its failsafe policy flies it".to_owned())
        }
        _ if !flies => Some("it is on the ground".to_owned()),
        _ => None,
    };
    let busy = match activity(vehicle) {
        Some(activity) if activity != "none" => Some(activity.to_owned()),
        _ if members.contains(&vehicle.id) => Some("in the formation".to_owned()),
        _ => None,
    };
    Candidate {
        vehicle: vehicle.id,
        position: vehicle.kinematics.map(|at| at.position),
        unfit,
        flies,
        battery: vehicle.battery.remaining.map(f64::from),
        energy: vehicle.energy.map(|energy| energy.level),
        gimbal_camera: has(PayloadKind::Gimbal) && has(PayloadKind::Camera),
        busy,
    }
}

/// What a model that can observe says that it is doing beside flying.
pub(crate) fn activity(vehicle: &VehicleSnapshot) -> Option<&str> {
    vehicle.model_state.as_ref()?.get("activity")?.as_str()
}

/// Whether it says that it looks at this track.
pub(crate) fn looks_at(vehicle: &VehicleSnapshot, track: u64) -> bool {
    let target = vehicle.model_state.as_ref().and_then(|state| state.get("target"));
    target
        .and_then(|target| target.get("track"))
        .and_then(serde_json::Value::as_u64)
        == Some(track)
}
