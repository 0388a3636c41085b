//! Video over WebRTC as WHEP has it: an SDP offer in a POST, the answer in its response.

use super::{Of, QualityQuery, admit};
use crate::app::App;
use crate::error::ApiError;
use crate::webrtc::{LocalAddress, Session};
use axum::Extension;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use skein_video::Coding;
use str0m::change::SdpOffer;

/// What a viewer's offer is sent as.
const SDP: &str = "application/sdp";

/// Answers an offer: from then on the video goes to whoever made it.
///
/// # Errors
/// When there is no such camera, too many look already, or the offer is none that can be answered.
pub(crate) async fn answer(
    State(app): State<App>,
    Extension(LocalAddress(local)): Extension<LocalAddress>,
    of: Of,
    query: Result<Query<QualityQuery>, QueryRejection>,
    headers: HeaderMap,
    body: String,
) -> Result<Response, ApiError> {
    let (Path((vehicle, payload)), Query(query)) = (of?, query?);
    let kind = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    if kind.and_then(|kind| kind.split(';').next()).map(str::trim) != Some(SDP) {
        return Err(ApiError::NotSdp);
    }
    let offer = SdpOffer::from_sdp_string(&body).map_err(|error| unfit(&error))?;
    let permit = admit(&app)?;
    let viewer = app
        .node
        .streams()
        .watch_video(vehicle, &payload, query.quality.of(Coding::H264))?;
    let hub = app.webrtc.hub(local).await?;
    let (session, answer) = Session::answer(&hub, local, offer, viewer).map_err(|error| unfit(&error))?;
    let id = hub.serve(session, permit)?;
    let location = format!("/api/v1/video/sessions/{id}");
    let headers = [(header::CONTENT_TYPE, SDP.to_owned()), (header::LOCATION, location)];
    Ok((StatusCode::CREATED, headers, answer).into_response())
}

fn unfit(error: &dyn std::fmt::Display) -> ApiError {
    ApiError::Shape {
        problem: format!("this offer cannot be answered: {error}"),
    }
}

/// Ends a session.
///
/// # Errors
/// When there is none of this name.
pub(crate) async fn end(
    State(app): State<App>,
    id: Result<Path<String>, PathRejection>,
) -> Result<StatusCode, ApiError> {
    let Path(id) = id?;
    match app.webrtc.opened() {
        Some(hub) if hub.end(&id) => Ok(StatusCode::NO_CONTENT),
        _ => Err(ApiError::UnknownSession { session: id }),
    }
}
