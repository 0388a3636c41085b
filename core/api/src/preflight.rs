//! Routes about the preflight report and its overrides.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::operators::Operator;
use crate::protocol::OverrideBody;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use skein_domain::{NodeTime, PreflightOverride, Refusal};
use skein_runtime::PreflightAnswer;

pub(crate) async fn report(State(app): State<App>) -> Json<PreflightAnswer> {
    Json(app.node.preflight_everywhere().await)
}

pub(crate) async fn give_override(
    State(app): State<App>,
    Operator(operator): Operator,
    Body(body): Body<OverrideBody>,
) -> Result<Json<PreflightOverride>, ApiError> {
    if !operator.may_override_preflight {
        return Err(Refusal::not_permitted(format!("{} may not override the preflight report", operator.name)).into());
    }
    let given = app.node.override_preflight(PreflightOverride {
        operator: operator.name,
        reason: body.reason,
        items: body.items,
        vehicle: body.vehicle,
        given_at: NodeTime::default(),
        valid_s: body.valid_s,
    })?;
    Ok(Json(given))
}

/// An operator is there.
pub(crate) async fn alive(State(app): State<App>) -> StatusCode {
    app.node.hear_operator();
    StatusCode::NO_CONTENT
}
