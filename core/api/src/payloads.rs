//! Routes about payloads, plugins and tracks: hand the node a request and say what came of it.

use crate::app::App;
use crate::body::{Body, PayloadCommandBody, TracksBody};
use crate::control::{FromConsole, may_move};
use crate::error::ApiError;
use crate::protocol::{Accepted, PayloadList, PluginList, RestartList};
use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::{BytesRejection, PathRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Deserialize;
use skein_config::PayloadRule;
use skein_domain::payload::PixelFormat;
use skein_domain::{Refusal, VehicleId};
use skein_runtime::{PluginRefusal, UpgradeReceipt};
use skein_view::CommandReceipt;

/// A vehicle and one of its payloads.
type Of = Result<Path<(VehicleId, String)>, PathRejection>;

pub(crate) async fn list(
    State(app): State<App>,
    id: Result<Path<VehicleId>, PathRejection>,
) -> Result<Json<PayloadList>, ApiError> {
    let Path(id) = id?;
    let snapshot = app.node.snapshot();
    let vehicle = snapshot.vehicles.iter().find(|vehicle| vehicle.id == id);
    let vehicle = vehicle.ok_or(Refusal::UnknownVehicle { vehicle: id })?;
    Ok(Json(PayloadList {
        payloads: vehicle.payloads.clone(),
    }))
}

pub(crate) async fn attach(
    State(app): State<App>,
    id: Result<Path<VehicleId>, PathRejection>,
    Body(rule): Body<PayloadRule>,
) -> Result<Response, ApiError> {
    let Path(id) = id?;
    app.node.attach_payload(id, rule).await?;
    Ok(accepted())
}

pub(crate) async fn detach(State(app): State<App>, of: Of) -> Result<StatusCode, ApiError> {
    let Path((vehicle, payload)) = of?;
    app.node.detach_payload(vehicle, payload).await?;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn command(
    State(app): State<App>,
    console: FromConsole,
    of: Of,
    Body(command): Body<PayloadCommandBody>,
) -> Result<Json<CommandReceipt>, ApiError> {
    let Path((vehicle, payload)) = of?;
    may_move(&app, &console, Some(&[vehicle]))?;
    let receipt = app.node.command_payload(vehicle, &payload, &command.0.into()).await;
    match receipt.refusal {
        Some(refusal) => Err(refusal.into()),
        None => Ok(Json(receipt)),
    }
}

pub(crate) async fn restart(State(app): State<App>, of: Of) -> Result<Response, ApiError> {
    let Path((vehicle, payload)) = of?;
    app.node.restart_plugin(vehicle, Some(&payload))?;
    Ok(accepted())
}

pub(crate) async fn restart_model(
    State(app): State<App>,
    id: Result<Path<VehicleId>, PathRejection>,
) -> Result<Response, ApiError> {
    let Path(id) = id?;
    app.node.restart_plugin(id, None)?;
    Ok(accepted())
}

/// The last frame as a picture that browsers show: JPEG as it is, or made of a camera's H.264; pixels as PNG.
pub(crate) async fn frame(State(app): State<App>, of: Of) -> Result<Response, ApiError> {
    let Path((vehicle, payload)) = of?;
    let none = || ApiError::NotFound {
        path: format!("the frame of payload {payload} of vehicle {vehicle}"),
    };
    let (kind, picture) = if app.node.streams().gives_no_pixels(vehicle, &payload) {
        let picture = crate::video::still(&app, vehicle, &payload).await?;
        ("image/jpeg", picture.ok_or_else(none)?)
    } else {
        let frame = app.node.payload_frame(vehicle, &payload)?.ok_or_else(none)?;
        let kind = match frame.header.format {
            PixelFormat::Jpeg => "image/jpeg",
            PixelFormat::Gray8 | PixelFormat::Rgb8 | PixelFormat::H264 => "image/png",
        };
        let made = tokio::task::spawn_blocking(move || crate::picture::encode(&frame.header, frame.bytes())).await;
        (kind, made.unwrap_or_default())
    };
    let headers = [(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, "no-store")];
    Ok((headers, picture).into_response())
}

pub(crate) async fn tracks(State(app): State<App>, Body(body): Body<TracksBody>) -> Result<Response, ApiError> {
    app.node.set_tracks(body.tracks)?;
    Ok(accepted())
}

pub(crate) async fn plugins(State(app): State<App>) -> Json<PluginList> {
    Json(PluginList {
        plugins: app.node.plugins(),
        problems: app.node.plugin_problems(),
    })
}

pub(crate) async fn rescan(State(app): State<App>) -> Json<PluginList> {
    app.node.rescan_plugins().await;
    plugins(State(app)).await
}

pub(crate) async fn upgrade(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<Json<UpgradeReceipt>, ApiError> {
    let Path(name) = name?;
    Ok(Json(app.node.upgrade_plugin(&name).await?))
}

pub(crate) async fn roll_back(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<Json<UpgradeReceipt>, ApiError> {
    let Path(name) = name?;
    Ok(Json(app.node.roll_back_plugin(&name).await?))
}

pub(crate) async fn remove(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<StatusCode, ApiError> {
    let Path(name) = name?;
    app.node.remove_plugin(&name)?;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn restarts(State(app): State<App>) -> Json<RestartList> {
    Json(RestartList {
        restarts: app.node.restarts(),
    })
}

/// How an uploaded library is to be called.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UploadQuery {
    /// File name, for example `libgimbal_plugin.so`.
    file: String,
}

pub(crate) async fn upload(
    State(app): State<App>,
    query: Result<Query<UploadQuery>, QueryRejection>,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, ApiError> {
    let Query(UploadQuery { file }) = query?;
    let bytes = body.map_err(|rejection| ApiError::Shape {
        problem: rejection.body_text(),
    })?;
    let node = app.node.clone();
    // A slow disk must not hold up what flies.
    let kept = tokio::task::spawn_blocking(move || node.keep_upload(&file, &bytes)).await;
    kept.unwrap_or_else(|error| {
        Err(PluginRefusal::BadUpload {
            detail: error.to_string(),
        })
    })?;
    Ok(accepted())
}

pub(crate) async fn enable_upload(
    State(app): State<App>,
    query: Result<Query<UploadQuery>, QueryRejection>,
) -> Result<Json<PluginList>, ApiError> {
    let Query(UploadQuery { file }) = query?;
    app.node.enable_upload(&file)?;
    Ok(rescan(State(app)).await)
}

fn accepted() -> Response {
    (StatusCode::ACCEPTED, Json(Accepted { accepted: true })).into_response()
}
