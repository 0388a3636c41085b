//! The supervision tree as one answer: what runs, in which state, how often it was started, and what a call of it costs.
//!
//! Must never do: start or end anything. It reads the newest snapshot.

use crate::app::App;
use crate::protocol::{SupervisedPayload, SupervisedVehicle, SupervisionTree};
use axum::Json;
use axum::extract::State;
use skein_view::VehicleSnapshot;

pub(crate) async fn tree(State(app): State<App>) -> Json<SupervisionTree> {
    let snapshot = app.node.snapshot();
    Json(SupervisionTree {
        time: app.node.now(),
        actors: snapshot.actors.clone(),
        vehicles: snapshot.vehicles.iter().map(of_vehicle).collect(),
    })
}

fn of_vehicle(vehicle: &VehicleSnapshot) -> SupervisedVehicle {
    let payloads = vehicle.payloads.iter().map(|payload| SupervisedPayload {
        name: payload.name.clone(),
        kind: payload.kind,
        actor: payload.actor.clone(),
        plugin: payload.plugin.clone(),
        transport_fault: payload.transport_fault.clone(),
    });
    SupervisedVehicle {
        id: vehicle.id,
        node: vehicle.node,
        name: vehicle.name.clone(),
        actor: vehicle.actor.clone(),
        model: vehicle.model.clone(),
        payloads: payloads.collect(),
        degraded: vehicle.degraded.clone(),
    }
}
