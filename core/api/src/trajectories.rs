//! Routes about trajectories of single vehicles that fly in step.

use crate::app::App;
use crate::body::Body;
use crate::control::{FromConsole, may_move};
use crate::error::ApiError;
use crate::protocol::{TrajectoriesEnded, TrajectoryList};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use skein_domain::{Refusal, TrajectoryPlan, TrajectoryRequest, VehicleId};
use std::collections::BTreeSet;

pub(crate) async fn list(State(app): State<App>) -> Json<TrajectoryList> {
    Json(TrajectoryList {
        time: app.node.now(),
        trajectories: app.node.trajectories(),
    })
}

pub(crate) async fn fly(
    State(app): State<App>,
    console: FromConsole,
    Body(request): Body<TrajectoryRequest>,
) -> Result<Response, ApiError> {
    let vehicles = each_once(&request)?;
    may_move(&app, &console, Some(&vehicles))?;
    let plan = app
        .node
        .fly_trajectories(request)
        .await
        .map_err(ApiError::Trajectories)?;
    Ok((StatusCode::ACCEPTED, Json(plan)).into_response())
}

pub(crate) async fn preview(
    State(app): State<App>,
    Body(request): Body<TrajectoryRequest>,
) -> Result<Json<TrajectoryPlan>, ApiError> {
    each_once(&request)?;
    let plan = app.node.preview_trajectories(request).await;
    plan.map(Json).map_err(ApiError::Trajectories)
}

/// Whose ways they are: each vehicle has one.
fn each_once(request: &TrajectoryRequest) -> Result<Vec<VehicleId>, ApiError> {
    let vehicles: Vec<_> = request.vehicles.iter().map(|journey| journey.vehicle).collect();
    let mut seen = BTreeSet::new();
    match vehicles.iter().find(|vehicle| !seen.insert(**vehicle)) {
        Some(twice) => Err(Refusal::invalid(format!("vehicle {twice} is there twice")).into()),
        None => Ok(vehicles),
    }
}

pub(crate) async fn end(State(app): State<App>) -> Result<Json<TrajectoriesEnded>, ApiError> {
    let vehicles = app.node.end_trajectories().await?;
    Ok(Json(TrajectoriesEnded { vehicles }))
}
