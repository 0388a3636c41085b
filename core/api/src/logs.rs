//! Logs that autopilots keep by themselves: listed, and fetched to lie beside the recordings of the node that flies the vehicle.
//!
//! Must never do: wait for a whole log.

use crate::app::App;
use crate::error::ApiError;
use crate::protocol::{AutopilotLogList, LogFetchAnswer};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use skein_domain::VehicleId;

type OfVehicle = Result<Path<VehicleId>, PathRejection>;

/// Which there are.
///
/// # Errors
/// When there is no such vehicle, it is armed, or its autopilot does not answer.
pub(crate) async fn list(State(app): State<App>, id: OfVehicle) -> Result<Json<AutopilotLogList>, ApiError> {
    let Path(id) = id?;
    let logs = skein_recorder::logs::list(&app.node, id).await?;
    Ok(Json(AutopilotLogList { logs }))
}

/// Begins to fetch one.
///
/// # Errors
/// The same, and when there is no such log.
pub(crate) async fn fetch(
    State(app): State<App>,
    of: Result<Path<(VehicleId, u16)>, PathRejection>,
) -> Result<Response, ApiError> {
    let Path((id, number)) = of?;
    let begun = skein_recorder::logs::fetch(&app.node, id, number).await?;
    Ok((StatusCode::ACCEPTED, Json(begun)).into_response())
}

/// How far that has come.
///
/// # Errors
/// When the path names no vehicle.
pub(crate) async fn fetched(State(app): State<App>, id: OfVehicle) -> Result<Json<LogFetchAnswer>, ApiError> {
    let Path(id) = id?;
    let fetch = app.node.log_fetches().remove(&id);
    Ok(Json(LogFetchAnswer { fetch }))
}
