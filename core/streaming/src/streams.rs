//! Who looks at which camera, and what is made for them: a camera's pixels encoded, its H.264 decoded and encoded anew, another node's fetched.
//!
//! Must never do: go on when nobody looks any more.

use skein_config::NodeConfig;
use skein_domain::payload::PayloadKind;
use skein_domain::{NodeTime, Refusal, VehicleId};
use skein_link_mavlink::LinkTable;
use skein_state::SharedState;
use skein_state::video::VideoHealth;
use std::sync::Arc;

/// A camera that encodes and gives pixels beside that, as some do, has given some within so long, in seconds.
const PIXELS_COUNT_S: f64 = 3.0;

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

/// The video of the swarm's cameras, as this node has it. Cheap to clone.
#[derive(Clone)]
pub struct CameraStreams {
    pub(crate) shared: Arc<SharedState>,
    pub(crate) links: Arc<LinkTable>,
}

impl CameraStreams {
    /// Of a node's shared state and its MAVLink links, on which ground stations are told of what is sent as RTP.
    #[must_use]
    pub fn new(shared: Arc<SharedState>, links: Arc<LinkTable>) -> Self {
        Self { shared, links }
    }

    pub(crate) fn shared(&self) -> &Arc<SharedState> {
        &self.shared
    }

    pub(crate) fn config(&self) -> &NodeConfig {
        &self.shared.config
    }

    pub(crate) fn now(&self) -> NodeTime {
        self.shared.now()
    }

    /// The cameras of the swarm's vehicles, those of this node first.
    #[must_use]
    pub fn videos(&self) -> Vec<CameraVideo> {
        let mut all = self.videos_here();
        all.extend(self.videos_elsewhere());
        all
    }

    fn videos_elsewhere(&self) -> Vec<CameraVideo> {
        let (now, fleet) = (self.now(), self.shared.picture());
        let vehicles = fleet.vehicles.iter();
        let elsewhere = vehicles.filter(|vehicle| self.shared.host(vehicle.id).is_some());
        let cameras = elsewhere.flat_map(|vehicle| {
            let cameras = vehicle.payloads.iter();
            let cameras = cameras.filter(|payload| payload.kind == PayloadKind::Camera);
            cameras.map(|camera| (vehicle.id, camera))
        });
        cameras
            .map(|(vehicle, camera)| CameraVideo {
                vehicle,
                payload: camera.name.clone(),
                health: self.shared.videos.camera(vehicle, &camera.name).health(now),
                fault: String::new(),
            })
            .collect()
    }

    fn videos_here(&self) -> Vec<CameraVideo> {
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
        let unknown = || Refusal::UnknownPayload {
            vehicle,
            payload: payload.to_owned(),
        };
        if self.shared.host(vehicle).is_some() {
            let mut cameras = self.videos_elsewhere().into_iter();
            return cameras
                .find(|video| video.vehicle == vehicle && video.payload == payload)
                .ok_or_else(unknown);
        }
        let camera = self.camera(vehicle, payload)?;
        Ok(CameraVideo {
            vehicle,
            payload: payload.to_owned(),
            health: camera.video.health(self.now()),
            fault: fault_of(&camera),
        })
    }

    /// Whether a camera of this node gives H.264 and, of late, no pixels: whoever wants a picture of it has to look at [`skein_state::video::Rendition::FILES`].
    #[must_use]
    pub fn gives_no_pixels(&self, vehicle: VehicleId, payload: &str) -> bool {
        let now = self.now();
        self.camera(vehicle, payload).is_ok_and(|camera| {
            let pixels_at = camera.frame().map(|frame| frame.header.time);
            let has_pixels = pixels_at.is_some_and(|at| now.seconds_since(at) < PIXELS_COUNT_S);
            camera.video.encodes(now) && !has_pixels
        })
    }

    /// A viewer tells how long it takes from the camera's picture to the eyes: median and 99th percentile in seconds. Of a camera that is not there it
    /// is forgotten.
    pub fn note_seen(&self, vehicle: VehicleId, payload: &str, p50_s: f64, p99_s: f64) {
        let video = match self.shared.host(vehicle) {
            Some(_) => Some(self.shared.videos.camera(vehicle, payload)),
            None => self.camera(vehicle, payload).ok().map(|camera| camera.video.clone()),
        };
        if let Some(video) = video {
            video.note_seen(self.now(), p50_s, p99_s);
        }
    }

    pub(crate) fn camera(&self, vehicle: VehicleId, payload: &str) -> Result<Arc<skein_state::PayloadRecord>, Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        let camera = record.known_payload(payload)?;
        if camera.kind != PayloadKind::Camera {
            return Err(Refusal::not_supported(format!(
                "video of {payload}, which is no camera"
            )));
        }
        Ok(camera)
    }
}

/// Which camera is looked at.
#[derive(Debug, Clone)]
pub(crate) struct Looked {
    pub(crate) vehicle: VehicleId,
    pub(crate) payload: String,
}

/// What a camera reports to be wrong.
fn fault_of(camera: &skein_state::PayloadRecord) -> String {
    let published = camera.state();
    let fault = published.report.as_ref().and_then(|report| report.value.get("fault"));
    fault.and_then(|fault| fault.as_str()).unwrap_or_default().to_owned()
}
