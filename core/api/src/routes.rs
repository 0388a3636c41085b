//! What each route does. Short on purpose: read a snapshot or hand the node a request, and say what came of it.

use crate::app::App;
use crate::body::Body;
use crate::control::{FromConsole, may_move};
use crate::error::ApiError;
use crate::metrics;
use crate::protocol::{
    Accepted, AcknowledgeBody, Acknowledged, CommandBody, CommandReceipts, EventList, FormationAnswer, Health,
    HealthStatus, PROTOCOL_VERSION, RouteBody, VehicleList, VersionInfo,
};
use axum::Json;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::{FormationRequest, Refusal, VehicleId};
use skein_runtime::Fault;
use skein_view::FormationReceipt;
use skein_view::VehicleSnapshot;
use skein_view::{ActorHealth, ActorStatus};

/// A picture of the fleet older than this is nothing to rely on. It is renewed many times a second.
const STALLED_AFTER_S: f64 = 1.0;

pub(crate) async fn version(State(app): State<App>) -> Json<VersionInfo> {
    Json(VersionInfo {
        program: "skein".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        node: app.node.name().to_owned(),
        protocol: PROTOCOL_VERSION,
    })
}

pub(crate) async fn health(State(app): State<App>) -> Response {
    let (snapshot, now) = (app.node.snapshot(), app.node.now());
    let snapshot_age_s = now.seconds_since(snapshot.time).max(0.0);
    let of_vehicles = snapshot.vehicles.iter().flat_map(|vehicle| {
        let of_payloads = vehicle.payloads.iter().map(|payload| payload.plugin.as_actor());
        [vehicle.actor.clone(), vehicle.model.as_actor()]
            .into_iter()
            .chain(of_payloads)
    });
    let not_running: Vec<ActorHealth> = snapshot
        .actors
        .iter()
        .cloned()
        .chain(of_vehicles)
        .filter(|health| health.status != ActorStatus::Running)
        .collect();
    let (code, status) = if snapshot_age_s > STALLED_AFTER_S {
        (StatusCode::SERVICE_UNAVAILABLE, HealthStatus::Stalled)
    } else if not_running.is_empty() {
        (StatusCode::OK, HealthStatus::Ok)
    } else {
        (StatusCode::OK, HealthStatus::Degraded)
    };
    let connected = snapshot
        .vehicles
        .iter()
        .filter(|vehicle| vehicle.link.connected)
        .count();
    let health = Health {
        status,
        time: now,
        snapshot_age_s,
        vehicles: count(snapshot.vehicles.len()),
        vehicles_connected: count(connected),
        vehicles_unadopted: count(snapshot.unadopted.len()),
        not_running,
        recorder: app.node.recorder().as_ref().clone(),
    };
    (code, Json(health)).into_response()
}

fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

pub(crate) async fn fleet(State(app): State<App>) -> Response {
    Json(app.node.snapshot().as_ref()).into_response()
}

pub(crate) async fn vehicles(State(app): State<App>) -> Json<VehicleList> {
    let snapshot = app.node.snapshot();
    Json(VehicleList {
        time: snapshot.time,
        vehicles: snapshot.vehicles.clone(),
        unadopted: snapshot.unadopted.clone(),
    })
}

pub(crate) async fn vehicle(
    State(app): State<App>,
    id: Result<Path<VehicleId>, PathRejection>,
) -> Result<Json<VehicleSnapshot>, ApiError> {
    let Path(id) = id?;
    let snapshot = app.node.snapshot();
    let found = snapshot.vehicles.iter().find(|vehicle| vehicle.id == id);
    Ok(Json(found.cloned().ok_or(Refusal::UnknownVehicle { vehicle: id })?))
}

pub(crate) async fn command(
    State(app): State<App>,
    console: FromConsole,
    Body(body): Body<CommandBody>,
) -> Result<Json<CommandReceipts>, ApiError> {
    let receipts = app.node.command_from(console.id(), &body.targets, body.command).await;
    if receipts.is_empty() {
        // "All" of none. Silence would look like success.
        return Err(Refusal::NotEnoughVehicles { have: 0, need: 1 }.into());
    }
    let unknown = |refusal: &Option<Refusal>| matches!(refusal, Some(Refusal::UnknownVehicle { .. }));
    let none_known = receipts.iter().all(|receipt| unknown(&receipt.refusal));
    let receipts = CommandReceipts { receipts };
    if none_known {
        Err(ApiError::NoneKnown(receipts))
    } else {
        Ok(Json(receipts))
    }
}

pub(crate) async fn formation(State(app): State<App>) -> Json<FormationAnswer> {
    Json(FormationAnswer {
        formation: app.node.snapshot().formation.clone(),
    })
}

pub(crate) async fn set_formation(
    State(app): State<App>,
    console: FromConsole,
    Body(request): Body<FormationRequest>,
) -> Result<Json<FormationReceipt>, ApiError> {
    may_move(&app, &console, request.members.as_deref())?;
    let receipt = app.node.set_formation(request).await?;
    app.node.next_snapshot().await;
    Ok(Json(receipt))
}

pub(crate) async fn dissolve_formation(State(app): State<App>) -> Result<StatusCode, ApiError> {
    app.node.dissolve_formation().await?;
    app.node.next_snapshot().await;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn set_route(
    State(app): State<App>,
    console: FromConsole,
    Body(body): Body<RouteBody>,
) -> Result<Response, ApiError> {
    let members = app
        .node
        .snapshot()
        .formation
        .as_ref()
        .map(|formation| formation.members.clone());
    may_move(&app, &console, Some(&members.unwrap_or_default()))?;
    let flown = app.node.set_route(body.route).await?;
    app.node.next_snapshot().await;
    Ok((StatusCode::ACCEPTED, Json(flown)).into_response())
}

pub(crate) async fn inject_fault(State(app): State<App>, Body(fault): Body<Fault>) -> Result<Response, ApiError> {
    app.node.inject_fault(fault).await?;
    Ok(accepted())
}

fn accepted() -> Response {
    (StatusCode::ACCEPTED, Json(Accepted { accepted: true })).into_response()
}

/// Which events are asked for.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EventQuery {
    /// Number of the last event that is known already; everything that is kept if left out.
    #[serde(default)]
    #[schemars(range(max = u64::MAX))]
    after: u64,
}

pub(crate) async fn events(
    State(app): State<App>,
    query: Result<Query<EventQuery>, QueryRejection>,
) -> Result<Json<EventList>, ApiError> {
    let Query(EventQuery { after }) = query?;
    let events = app.node.events_after(after);
    let missed = events
        .first()
        .map_or(0, |first| first.seq.saturating_sub(after.saturating_add(1)));
    Ok(Json(EventList {
        events: events.iter().map(|event| event.as_ref().clone()).collect(),
        missed,
    }))
}

pub(crate) async fn acknowledge(State(app): State<App>, Body(body): Body<AcknowledgeBody>) -> Json<Acknowledged> {
    Json(Acknowledged {
        alerts: app.node.acknowledge(&body.events),
    })
}

pub(crate) async fn document(State(app): State<App>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], app.document).into_response()
}

pub(crate) async fn prometheus(State(app): State<App>) -> Response {
    (
        [(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")],
        metrics::render(&app.node),
    )
        .into_response()
}
