//! Routes of the emergency stop: two steps, so that it is never one slip of a finger.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::{CommandReceipts, EmergencyStopBody};
use axum::Json;
use axum::extract::State;
use skein_runtime::EmergencyKey;

pub(crate) async fn unlock(State(app): State<App>) -> Json<EmergencyKey> {
    Json(app.node.unlock_emergency_stop())
}

pub(crate) async fn stop(
    State(app): State<App>,
    Body(body): Body<EmergencyStopBody>,
) -> Result<Json<CommandReceipts>, ApiError> {
    let receipts = app.node.emergency_stop(&body.key, &body.targets).await?;
    Ok(Json(CommandReceipts { receipts }))
}
