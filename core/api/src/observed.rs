//! Routes about what the swarm sees: tracks and what is asked of them, what other sensors tell, and where the cameras of all vehicles look, from the newest
//! snapshot of the fleet.
//!
//! A camera's last frame says it best. A camera that gives this node no frames, because it is another node's or streams past us, looks
//! where its vehicle's gimbal points; one without a gimbal is left out then: how it is mounted nobody says.
//!
//! Must never do: ask a vehicle anything but to keep a track in view.

use crate::app::App;
use crate::body::{Body, DetectionsBody, TrackChangeBody};
use crate::control::FromConsole;
use crate::error::ApiError;
use crate::protocol::{AskedObserverList, CameraView, CameraViewList, ObserverList, TrackList, ViewSource};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::de::DeserializeOwned;
use skein_domain::payload::{CameraPose, CameraState, GimbalState, PayloadKind};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, VehicleId};
use skein_runtime::{Detected, ObserveRequest};
use skein_view::{PayloadSnapshot, VehicleSnapshot};

/// A frame older than this says nothing of where the camera looks now, in seconds.
const FRAME_COUNTS_S: f64 = 2.0;

pub(crate) async fn views(State(app): State<App>) -> Json<CameraViewList> {
    let now = app.node.now();
    let snapshot = app.node.snapshot();
    Json(CameraViewList {
        time: now,
        views: snapshot
            .vehicles
            .iter()
            .flat_map(|vehicle| of_vehicle(vehicle, now))
            .collect(),
    })
}

pub(crate) async fn tracks(State(app): State<App>) -> Json<TrackList> {
    Json(TrackList {
        time: app.node.now(),
        tracks: app.node.snapshot().tracks.clone(),
    })
}

/// Takes what another sensor saw: all of it, or none if one of it cannot be true.
pub(crate) async fn detections(
    State(app): State<App>,
    Body(body): Body<DetectionsBody>,
) -> Result<(StatusCode, Json<Detected>), ApiError> {
    let told = app.node.tell_detections(&body.source, body.detections);
    let detected = told.map_err(|(index, problem)| ApiError::OutOfRange {
        field: format!("detections[{index}]"),
        problem,
    })?;
    if detected.refused > 0 {
        return Err(ApiError::TooManyDetections(detected));
    }
    Ok((StatusCode::ACCEPTED, Json(detected)))
}

/// A track's number.
type Of = Result<Path<u64>, PathRejection>;

pub(crate) async fn change(
    State(app): State<App>,
    track: Of,
    Body(body): Body<TrackChangeBody>,
) -> Result<StatusCode, ApiError> {
    let Path(track) = track?;
    app.node.change_track(track, body.name, body.pinned).await?;
    app.node.next_snapshot().await;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn drop_track(State(app): State<App>, track: Of) -> Result<StatusCode, ApiError> {
    let Path(track) = track?;
    app.node.drop_track(track).await?;
    app.node.next_snapshot().await;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn observers(State(app): State<App>, track: Of) -> Result<Json<ObserverList>, ApiError> {
    let Path(track) = track?;
    let observers = app.node.observers_of(track)?;
    Ok(Json(ObserverList { track, observers }))
}

pub(crate) async fn observe(
    State(app): State<App>,
    console: FromConsole,
    track: Of,
    Body(request): Body<ObserveRequest>,
) -> Result<Json<AskedObserverList>, ApiError> {
    let Path(track) = track?;
    let asked = app.node.observe_track(console.id(), track, &request).await?;
    Ok(Json(AskedObserverList { track, asked }))
}

fn of_vehicle(vehicle: &VehicleSnapshot, now: NodeTime) -> Vec<CameraView> {
    let carrier = Carrier {
        id: vehicle.id,
        at: vehicle.kinematics,
        age_s: vehicle.age_s,
        payloads: &vehicle.payloads,
    };
    carrier.views(now)
}

/// What of a vehicle its cameras' views follow from.
struct Carrier<'a> {
    id: VehicleId,
    at: Option<VehicleKinematics>,
    age_s: f64,
    payloads: &'a [PayloadSnapshot],
}

impl Carrier<'_> {
    fn views(&self, now: NodeTime) -> Vec<CameraView> {
        self.payloads
            .iter()
            .filter(|payload| payload.kind == PayloadKind::Camera)
            .filter_map(|camera| self.by_frame(camera, now).or_else(|| self.by_gimbal(camera)))
            .collect()
    }

    fn by_frame(&self, camera: &PayloadSnapshot, now: NodeTime) -> Option<CameraView> {
        let frame = camera.frame.as_ref()?;
        let age_s = now.seconds_since(frame.time).max(0.0);
        Some(CameraView {
            vehicle: self.id,
            payload: camera.name.clone(),
            pose: frame.pose.filter(|_| age_s <= FRAME_COUNTS_S)?,
            width_px: frame.width_px,
            height_px: frame.height_px,
            known_from: ViewSource::Frame,
            age_s,
        })
    }

    fn by_gimbal(&self, camera: &PayloadSnapshot) -> Option<CameraView> {
        let state: CameraState = reported(camera)?;
        let at = self.at?;
        let gimbal = self
            .payloads
            .iter()
            .filter(|payload| payload.kind == PayloadKind::Gimbal)
            .find_map(reported::<GimbalState>)
            .filter(|gimbal| gimbal.connected && state.connected)?;
        Some(CameraView {
            vehicle: self.id,
            payload: camera.name.clone(),
            pose: CameraPose {
                position: at.position,
                roll_rad: gimbal.roll_rad,
                pitch_rad: gimbal.pitch_rad,
                // From the nose: the vehicle's yaw is newer here than it was in the gimbal's report.
                yaw_rad: at.yaw_rad + gimbal.yaw_vehicle_rad,
                field_of_view_rad: state.field_of_view_rad?,
            },
            width_px: state.width_px.filter(|px| *px > 0)?,
            height_px: state.height_px.filter(|px| *px > 0)?,
            known_from: ViewSource::Gimbal,
            age_s: self.age_s,
        })
    }
}

/// What a payload says of itself, if it is what its kind says.
fn reported<T: DeserializeOwned>(payload: &PayloadSnapshot) -> Option<T> {
    T::deserialize(payload.state.as_ref()?).ok()
}

#[cfg(test)]
mod tests;
