//! Routes about fences: those in force, others in their place, and what a file of another program means.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::{FenceFileBody, FencePlanBody, ImportedFencePlan};
use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use skein_domain::Refusal;
use skein_runtime::FenceAnswer;
use std::path::Path;

pub(crate) async fn in_force(State(app): State<App>) -> Json<FenceAnswer> {
    Json(app.node.fences())
}

pub(crate) async fn set(
    State(app): State<App>,
    Body(body): Body<FencePlanBody>,
) -> Result<Json<FenceAnswer>, ApiError> {
    Ok(Json(app.node.set_fences(body.plan).await?))
}

/// What a GeoJSON or a plan of QGroundControl says; nothing is put in force by it.
pub(crate) async fn import(Body(body): Body<FenceFileBody>) -> Result<Json<ImportedFencePlan>, ApiError> {
    let name = body.name.as_deref().unwrap_or("file");
    let imported = skein_config::parse_fences(&body.text, Path::new(name)).map_err(invalid)?;
    Ok(Json(ImportedFencePlan {
        plan: imported.plan,
        notes: imported.notes,
    }))
}

/// The fences in force as GeoJSON.
pub(crate) async fn export(State(app): State<App>) -> Result<Response, ApiError> {
    let frame = app.node.snapshot().frame;
    let text = skein_config::to_geojson(&app.node.fences().plan, frame.as_ref()).map_err(invalid)?;
    Ok(([(header::CONTENT_TYPE, "application/geo+json")], text).into_response())
}

fn invalid(error: impl std::fmt::Display) -> Refusal {
    Refusal::invalid(error.to_string())
}
