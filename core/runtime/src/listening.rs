//! What endpoints notice, carried to the fleet and the event log. Runs on the endpoints' tasks: must never wait.

use crate::fleet::{Discovery, FleetMessage};
use crate::parts::Parts;
use skein_config::LinkKind;
use skein_coordination::ReferenceReport;
use skein_domain::SystemId;
use skein_domain::exchange::Severity;
use skein_link_mavlink::{EndpointEvent, EventSink, ReferenceSink, Sighting, Source};
use skein_state::SharedState;
use skein_view::{EventKind, UnadoptedVehicle};
use std::sync::Arc;

/// Where an endpoint's events go.
pub fn sink(shared: &Arc<SharedState>, parts: &Arc<Parts>) -> EventSink {
    let (shared, parts) = (shared.clone(), parts.clone());
    Arc::new(move |event| noticed(&shared, &parts, event))
}

/// Where an endpoint's sightings of others go: kept away from, and known as references under the name of their source.
pub fn sightings(shared: &Arc<SharedState>) -> Arc<dyn ReferenceSink> {
    Arc::new(Sighted(shared.clone()))
}

struct Sighted(Arc<SharedState>);

impl ReferenceSink for Sighted {
    fn sighted(&self, sighting: Sighting) {
        let shared = &self.0;
        if let Some(frame) = shared.frame() {
            let report = ReferenceReport {
                position: frame.position(&sighting.place),
                velocity: sighting.velocity,
                heading_rad: sighting.heading_rad,
            };
            // One that is out of order says nothing new.
            let _ = shared.observed.references.tell(&sighting.source, report, sighting.time);
        }
        shared.observed.sightings.sighted(sighting);
    }
}

fn noticed(shared: &SharedState, parts: &Parts, event: EndpointEvent) {
    let (severity, text) = match event {
        EndpointEvent::Discovered {
            link,
            system_id,
            source,
            ..
        } => {
            let discovery = Discovery {
                endpoint: source.endpoint.to_string(),
                kind: LinkKind::Mavlink,
                link,
                system_id: SystemId(system_id),
            };
            return tell(parts, FleetMessage::Discovered(discovery));
        }
        EndpointEvent::Duplicate {
            system_id,
            first,
            second,
        } => {
            let why = two_senders(&first, &second);
            let (endpoint, system_id) = (second.endpoint.to_string(), SystemId(system_id));
            return tell(
                parts,
                FleetMessage::Trouble(UnadoptedVehicle {
                    system_id,
                    endpoint,
                    why,
                }),
            );
        }
        EndpointEvent::Bound { endpoint, local_addr } => {
            let Some(address) = local_addr else { return };
            parts.bound.lock().insert(endpoint.to_string(), address);
            (Severity::Info, format!("endpoint {endpoint} receives on {address}"))
        }
        EndpointEvent::Down { endpoint, reason } => {
            (Severity::Warning, format!("endpoint {endpoint} is down: {reason}"))
        }
        EndpointEvent::DuplicateCleared { system_id, remaining } => {
            shared.vehicles.forget_unadopted(|u| u.system_id.0 == system_id);
            (
                Severity::Advisory,
                format!("system id {system_id} is unique again, heard from {remaining}"),
            )
        }
        EndpointEvent::Moved { system_id, from, to } => (
            Severity::Advisory,
            format!("system id {system_id} moved from {from} to {to}"),
        ),
        EndpointEvent::SystemIdChanged { from, to, source } => (
            Severity::Warning,
            format!("the vehicle at {source} changed its system id from {from} to {to}"),
        ),
    };
    shared
        .events
        .record(shared.now(), None, severity, EventKind::Notice, text);
}

fn two_senders(first: &Source, second: &Source) -> String {
    if first == second {
        return format!("two vehicles use this system id at {first}; give one another MAV_SYS_ID");
    }
    format!(
        "another sender uses this system id at {second}; the vehicle is flown at {first}, and nothing goes to the other. If it is a vehicle, give it another MAV_SYS_ID"
    )
}

/// Tells the fleet. Must not wait.
pub fn tell(parts: &Parts, message: FleetMessage) {
    if let Some(fleet) = parts.fleet.load_full() {
        // A fleet that has just ended finds its vehicles in the shared state; what it misses here is heard again.
        let _ = fleet.cast(message);
    }
}
