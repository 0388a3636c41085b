//! Video that is looked at: a camera's pixels encoded, or its H.264 decoded and encoded anew, for as long as somebody wants that.
//!
//! Bound: one task for each rendition that is looked at, with one picture in work; what comes meanwhile is left out but for the newest. Must never
//! do: encode what nobody looks at, or compute on a thread that others wait for.

mod making;
mod recording;

use crate::handle::NodeHandle;
use making::Maker;
use skein_domain::payload::PayloadKind;
use skein_domain::{Refusal, VehicleId};
use skein_state::video::{Rendition, VideoHealth, Viewer};
use std::sync::Arc;

pub use making::VIDEO_SUB_PX;
pub use recording::RecordedVideo;

/// A camera and how its video is.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraVideo {
    /// Its vehicle.
    pub vehicle: VehicleId,
    /// Its name there.
    pub payload: String,
    /// How it is.
    pub health: VideoHealth,
    /// What the payload says is wrong; empty if nothing is.
    pub fault: String,
}

impl NodeHandle {
    /// The cameras of this node's vehicles.
    #[must_use]
    pub fn videos(&self) -> Vec<CameraVideo> {
        let now = self.now();
        let of_vehicle = |vehicle: Arc<skein_state::VehicleRecord>| {
            let cameras = vehicle.payloads().into_iter();
            let cameras = cameras.filter(|payload| payload.kind == PayloadKind::Camera);
            let id = vehicle.id;
            cameras.map(move |camera| CameraVideo {
                vehicle: id,
                payload: camera.name.clone(),
                health: camera.video.health(now),
                fault: fault_of(&camera),
            })
        };
        self.shared
            .vehicles
            .records()
            .into_iter()
            .flat_map(of_vehicle)
            .collect()
    }

    /// How the video of one camera is.
    ///
    /// # Errors
    /// When there is no such vehicle or payload, or it is no camera.
    pub fn video(&self, vehicle: VehicleId, payload: &str) -> Result<CameraVideo, Refusal> {
        let camera = self.camera(vehicle, payload)?;
        Ok(CameraVideo {
            vehicle,
            payload: payload.to_owned(),
            health: camera.video.health(self.now()),
            fault: fault_of(&camera),
        })
    }

    /// Looks at a camera from now on.
    ///
    /// # Errors
    /// When there is no such vehicle or payload, or it is no camera.
    pub fn watch_video(&self, vehicle: VehicleId, payload: &str, rendition: Rendition) -> Result<Viewer, Refusal> {
        let camera = self.camera(vehicle, payload)?;
        let stream = camera.video.stream(rendition);
        let viewer = stream.view();
        if let Some(making) = stream.begin_making() {
            let maker = Maker::new(self.shared.clone(), camera, rendition, stream);
            tokio::spawn(async move {
                maker.run().await;
                drop(making);
            });
        }
        Ok(viewer)
    }

    fn camera(&self, vehicle: VehicleId, payload: &str) -> Result<Arc<skein_state::PayloadRecord>, Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        let camera = self.payload(&record, payload)?;
        if camera.kind != PayloadKind::Camera {
            return Err(Refusal::not_supported(format!(
                "video of {payload}, which is no camera"
            )));
        }
        Ok(camera)
    }
}

/// What a camera reports to be wrong.
fn fault_of(camera: &skein_state::PayloadRecord) -> String {
    let published = camera.state();
    let fault = published.report.as_ref().and_then(|report| report.value.get("fault"));
    fault.and_then(|fault| fault.as_str()).unwrap_or_default().to_owned()
}
