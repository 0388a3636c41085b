//! The recorded flight that a node stands for: where it is, what happened in it, going to another moment.
//!
//! Must never do: let anything else be changed.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::ReplayAnswer;
use axum::Json;
use axum::extract::{Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;
use skein_replay::{Replay, ReplayChange, ReplayState, Timeline};
use std::sync::Arc;

/// The one path on which a replay takes something else than a question.
const PATH: &str = "/api/v1/replay";

/// Around every route: of a recorded flight nothing can be commanded.
///
/// # Errors
/// For a request that would change something else than what is shown.
pub(crate) async fn refuse_changes(State(app): State<App>, request: Request, next: Next) -> Result<Response, ApiError> {
    let reads_only = matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    if app.replay.is_some() && !reads_only && request.uri().path() != PATH {
        return Err(ApiError::Replaying);
    }
    Ok(next.run(request).await)
}

fn of(app: &App) -> Result<&Arc<Replay>, ApiError> {
    app.replay.as_ref().ok_or(ApiError::NotReplaying)
}

/// Whether this is a recorded flight, and where it is.
pub(crate) async fn state(State(app): State<App>) -> Json<ReplayAnswer> {
    Json(ReplayAnswer {
        replay: app.replay.as_ref().map(|replay| replay.state()),
    })
}

/// Goes to another moment, at another pace, or stands still.
///
/// # Errors
/// When this is no recorded flight.
pub(crate) async fn change(
    State(app): State<App>,
    Body(change): Body<ReplayChange>,
) -> Result<Json<ReplayState>, ApiError> {
    let changed = of(&app)?.change(change).await;
    changed.map(Json).map_err(|_| ApiError::NotReplaying)
}

/// What happened in it.
///
/// # Errors
/// When this is no recorded flight.
pub(crate) async fn timeline(State(app): State<App>) -> Result<Json<Timeline>, ApiError> {
    Ok(Json(of(&app)?.timeline()))
}
