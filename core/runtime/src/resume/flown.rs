//! What is flown at a moment, as it is kept for a restart.
//!
//! Must never do: keep setpoints or states. Where vehicles are after a restart, they say themselves.

use skein_coordination::{ActiveRoute, Coordination, Interrupted};
use skein_domain::{FlightMode, FlightState, FormationAnchor};
use skein_state::SharedState;
use skein_state::resume::Flown;
use skein_view::airborne;
use std::collections::BTreeMap;

/// What is flown at this moment. `before` is what was flown until the node last ended, as long as it is not decided on; `path` is how far the
/// formation's anchor has come along its path.
pub(super) fn flown_now(shared: &SharedState, before: Option<Flown>, path: Option<&ActiveRoute>) -> Flown {
    let now = shared.now();
    let mut vehicles = before
        .as_ref()
        .map_or_else(BTreeMap::new, |before| before.vehicles.clone());
    for record in shared.vehicles.records() {
        let (telemetry, _) = record.link().read(now);
        let state = record.state().flight_state;
        let others = matches!(
            state,
            FlightState::Idle | FlightState::PilotControl | FlightState::Faulted
        );
        if telemetry.mode == FlightMode::Offboard && airborne(&telemetry) && !others && !record.is_stopped() {
            let command = record.commanded.command();
            vehicles.entry(record.id).or_insert(command);
        }
    }
    let formation = formation(&shared.coordination.read(), path);
    Flown {
        origin: shared.frame().map(|frame| frame.origin),
        formation: formation.or(before.and_then(|before| before.formation)),
        withdrawn: shared.vehicles.withdrawn(),
        control: shared.operators.control().entries().clone(),
        vehicles,
    }
}

/// The formation, as it is to be flown again.
fn formation(coordination: &Coordination, path: Option<&ActiveRoute>) -> Option<Interrupted> {
    let Some(formation) = &coordination.formation else {
        return coordination.interrupted.clone();
    };
    let mut request = formation.request.clone();
    if let (FormationAnchor::Path { route }, Some(left)) = (&mut request.anchor, path.and_then(ActiveRoute::remaining))
    {
        *route = left;
    }
    let route = coordination.route.as_ref().filter(|route| !route.finished);
    Some(Interrupted {
        request,
        route: route.and_then(ActiveRoute::remaining),
        missing: formation.members.clone(),
    })
}
