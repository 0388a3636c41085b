//! Routes about the swarm of several nodes.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::CoordinatorBody;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use skein_domain::Refusal;
use skein_view::SwarmSnapshot;

pub(crate) async fn swarm(State(app): State<App>) -> Result<Json<SwarmSnapshot>, ApiError> {
    let alone = Refusal::not_permitted("this node flies its vehicles alone; it is in no swarm (swarm.id)");
    Ok(Json(app.node.swarm().ok_or(alone)?))
}

pub(crate) async fn make_coordinator(
    State(app): State<App>,
    Body(body): Body<CoordinatorBody>,
) -> Result<StatusCode, ApiError> {
    app.node.make_coordinator(body.node).await?;
    Ok(StatusCode::NO_CONTENT)
}
