//! Live video: which streams there are, and the ways to a viewer: H.264 or JPEG over a WebSocket, H.264 over WebRTC, JPEG over HTTP.
//!
//! Must never do: encode or decode, or keep pictures for a viewer that does not take them.

mod multipart;
mod recordings;
mod socket;
mod whep;

use crate::app::{App, MAX_VIEWERS};
use crate::error::ApiError;
use crate::protocol::{VideoStateWord, VideoStreamList, VideoStreamView};
use axum::Json;
use axum::extract::State;
use axum::extract::rejection::PathRejection;
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::VehicleId;
use skein_runtime::CameraVideo;
use skein_state::video::{Quality, Rendition, VideoState};
use skein_video::Coding;

pub(crate) use multipart::multipart;
pub(crate) use recordings::{file, recordings, start, stop};
pub(crate) use socket::{SocketQuery, open};
pub(crate) use whep::{answer, end};

/// How long a single picture is waited for, and how old it may be in seconds to be taken for that of now.
const STILL_WITHIN: std::time::Duration = std::time::Duration::from_secs(5);
const STILL_AGE_S: f64 = 0.5;

/// A vehicle and one of its payloads.
type Of = Result<axum::extract::Path<(VehicleId, String)>, PathRejection>;

/// How large the pictures are wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub(crate) enum WantedQuality {
    /// As the camera gives them.
    #[default]
    Main,
    /// At most 320x240 and 10/s.
    Sub,
}

impl WantedQuality {
    fn of(self, coding: Coding) -> Rendition {
        let quality = match self {
            Self::Main => Quality::Main,
            Self::Sub => Quality::Sub,
        };
        Rendition { coding, quality }
    }
}

/// What may be said when a stream is asked for.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct QualityQuery {
    /// How large the pictures are wanted.
    #[serde(default)]
    quality: WantedQuality,
}

pub(crate) async fn list(State(app): State<App>) -> Json<VideoStreamList> {
    let streams = app.node.streams().videos().into_iter().map(view).collect();
    Json(VideoStreamList { streams })
}

fn view(video: CameraVideo) -> VideoStreamView {
    let health = video.health;
    let (state, reason) = match health.state {
        VideoState::Live => (VideoStateWord::Live, String::new()),
        VideoState::Starting => (VideoStateWord::Starting, video.fault),
        VideoState::Stalled => (VideoStateWord::Stalled, video.fault),
        VideoState::NoKeyPicture => (VideoStateWord::NoKeyPicture, video.fault),
        VideoState::NoPictures => (VideoStateWord::NoPictures, video.fault),
        VideoState::Failed(reason) => (VideoStateWord::Failed, reason),
    };
    VideoStreamView {
        vehicle: video.vehicle,
        payload: video.payload,
        state,
        reason,
        codec: health.format.map_or_else(String::new, |format| format.codec()),
        width_px: health.size_px.0,
        height_px: health.size_px.1,
        rate_hz: health.measured.rate_hz,
        bytes_per_s: health.measured.bytes_per_s,
        lost: health.measured.lost,
        age_s: health.age_s,
        viewers: u32::try_from(health.viewers).unwrap_or(u32::MAX),
    }
}

/// The newest picture of a camera that gives H.264, made as for a viewer, who looks until then; none if it gives none in time.
pub(crate) async fn still(app: &App, vehicle: VehicleId, payload: &str) -> Result<Option<Vec<u8>>, ApiError> {
    let _permit = admit(app)?;
    let mut viewer = app.node.streams().watch_video(vehicle, payload, Rendition::FILES)?;
    let until = tokio::time::Instant::now() + STILL_WITHIN;
    let mut newest = None;
    // Decoding begins with the last key picture, which may be seconds old, and has soon come to the present.
    while let Ok(given) = tokio::time::timeout_at(until, viewer.next()).await {
        let age_s = app.node.now().seconds_since(given.frame.taken);
        newest = Some(given.frame.bytes.to_vec());
        if age_s < STILL_AGE_S {
            break;
        }
    }
    Ok(newest)
}

/// A place for one more viewer.
fn admit(app: &App) -> Result<tokio::sync::OwnedSemaphorePermit, ApiError> {
    let too_many = |_| ApiError::TooManyStreams { limit: MAX_VIEWERS };
    app.viewers.clone().try_acquire_owned().map_err(too_many)
}
