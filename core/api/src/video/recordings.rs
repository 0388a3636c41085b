//! Videos recorded on this node: begun, ended, listed, fetched.

use super::Of;
use crate::app::App;
use crate::error::ApiError;
use crate::protocol::{VideoRecording, VideoRecordingAnswer, VideoRecordingList};
use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use skein_runtime::RecordedVideo;
use tokio::io::AsyncReadExt;

/// A file is sent in pieces of this size.
const PIECE_BYTES: usize = 64 << 10;

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
    let file = tokio::fs::File::open(path).await.map_err(|_| not_found())?;
    let pieces = futures_util::stream::try_unfold(file, |mut file| async move {
        let mut piece = vec![0; PIECE_BYTES];
        let len = file.read(&mut piece).await?;
        piece.truncate(len);
        Ok::<_, std::io::Error>((len > 0).then_some((Bytes::from(piece), file)))
    });
    let kind = if name.ends_with(".mp4") {
        "video/mp4"
    } else {
        "application/jsonl"
    };
    let disposition = format!("attachment; filename=\"{}\"", name.replace('"', ""));
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    Ok((headers, Body::from_stream(pieces)).into_response())
}
