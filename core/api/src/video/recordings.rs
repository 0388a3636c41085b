//! Videos recorded on this node: begun, ended, listed, fetched.

use super::Of;
use crate::app::App;
use crate::error::ApiError;
use crate::files;
use crate::protocol::{VideoRecording, VideoRecordingAnswer, VideoRecordingList};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use skein_runtime::RecordedVideo;

fn answer(recorded: RecordedVideo) -> VideoRecordingAnswer {
    VideoRecordingAnswer {
        file: recorded.file,
        seconds: recorded.seconds,
    }
}

pub(crate) async fn start(State(app): State<App>, of: Of) -> Result<Response, ApiError> {
    let Path((vehicle, payload)) = of?;
    let begun = app.node.streams().start_recording(vehicle, &payload)?;
    Ok((StatusCode::CREATED, Json(answer(begun))).into_response())
}

pub(crate) async fn stop(State(app): State<App>, of: Of) -> Result<Json<VideoRecordingAnswer>, ApiError> {
    let Path((vehicle, payload)) = of?;
    Ok(Json(answer(app.node.streams().stop_recording(vehicle, &payload)?)))
}

pub(crate) async fn recordings(State(app): State<App>) -> Json<VideoRecordingList> {
    let read = tokio::task::spawn_blocking(move || app.node.streams().recorded_videos()).await;
    let recordings = read.unwrap_or_default().into_iter().map(|one| VideoRecording {
        file: one.file,
        vehicle: one.vehicle,
        payload: one.payload,
        bytes: one.bytes,
        seconds: one.seconds,
        running: one.running,
    });
    Json(VideoRecordingList {
        recordings: recordings.collect(),
    })
}

/// A recording, or what stands beside it, as a file.
///
/// # Errors
/// When there is none of this name.
pub(crate) async fn file(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<Response, ApiError> {
    let Path(name) = name?;
    let not_found = || ApiError::UnknownRecording { file: name.clone() };
    let path = app.node.streams().recorded_file(&name).map_err(|_| not_found())?;
    let kind = if name.ends_with(".mp4") {
        "video/mp4"
    } else {
        "application/jsonl"
    };
    files::send(&path, &name, kind).await.map_err(|_| not_found())
}
