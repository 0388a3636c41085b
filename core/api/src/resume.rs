//! The operator's answer after a restart of the node in flight. What is asked is part of the fleet's state.

use crate::app::App;
use crate::body::Body;
use crate::control::{FromConsole, may_move};
use crate::error::ApiError;
use crate::protocol::ResumeBody;
use axum::extract::State;
use axum::http::StatusCode;

pub(crate) async fn resume(
    State(app): State<App>,
    console: FromConsole,
    Body(body): Body<ResumeBody>,
) -> Result<StatusCode, ApiError> {
    if let Some(question) = &app.node.snapshot().resume {
        may_move(&app, &console, Some(&question.vehicles))?;
    }
    app.node.resume(body.fly_on).await?;
    app.node.next_snapshot().await;
    Ok(StatusCode::NO_CONTENT)
}
