//! Routes about trajectories of single vehicles that fly in step.

use crate::app::App;
use crate::body::{Body, MakesSense, Place};
use crate::control::{FromConsole, may_move};
use crate::error::ApiError;
use crate::protocol::{TrajectoriesEnded, TrajectoryList};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use skein_domain::{TrajectoryPlan, TrajectoryRequest, TrajectoryStart};

/// More vehicles are not planned together: each pair's distance is worked out.
const MAX_VEHICLES: usize = 64;
/// Most waypoints of one vehicle.
const MAX_WAYPOINTS: usize = 200;
/// Nothing begins later than this, in seconds.
const LATEST_S: f64 = 3600.0;
/// No multicopter flies faster, in metres per second.
const MAX_SPEED_M_S: f64 = 200.0;

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
    let vehicles: Vec<_> = request.vehicles.iter().map(|journey| journey.vehicle).collect();
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
    let plan = app.node.preview_trajectories(request).await;
    plan.map(Json).map_err(ApiError::Trajectories)
}

pub(crate) async fn end(State(app): State<App>) -> Result<Json<TrajectoriesEnded>, ApiError> {
    let vehicles = app.node.end_trajectories().await?;
    Ok(Json(TrajectoriesEnded { vehicles }))
}

impl MakesSense for TrajectoryRequest {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        let vehicles = place.field("vehicles");
        vehicles.length(self.vehicles.len(), MAX_VEHICLES)?;
        let ids: Vec<_> = self.vehicles.iter().map(|journey| journey.vehicle).collect();
        vehicles.vehicles(&ids)?;
        for (index, journey) in self.vehicles.iter().enumerate() {
            let journey_place = vehicles.item(index);
            let waypoints = journey_place.field("waypoints");
            waypoints.length(journey.waypoints.len(), MAX_WAYPOINTS)?;
            for (index, waypoint) in journey.waypoints.iter().enumerate() {
                waypoints.item(index).position(waypoint)?;
            }
        }
        if let TrajectoryStart::In { in_s } = self.start {
            place.field("start").field("in_s").number(in_s, 0.0, LATEST_S)?;
        }
        let speed = place.field("max_speed_m_s");
        self.max_speed_m_s
            .map_or(Ok(()), |speed_m_s| speed.positive(speed_m_s, MAX_SPEED_M_S))
    }
}
