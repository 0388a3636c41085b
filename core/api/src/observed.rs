//! Where the cameras of all vehicles look, as one answer, from the newest snapshot of the fleet.
//!
//! A camera's last frame says it best. A camera that gives this node no frames, because it is another node's or streams past us, looks
//! where its vehicle's gimbal points; one without a gimbal is left out then: how it is mounted nobody says.
//!
//! Must never do: ask a vehicle or a payload anything.

use crate::app::App;
use crate::protocol::{CameraView, CameraViewList, TrackList, ViewSource};
use axum::Json;
use axum::extract::State;
use serde::de::DeserializeOwned;
use skein_domain::payload::{CameraPose, CameraState, GimbalState, PayloadKind};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, VehicleId};
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
