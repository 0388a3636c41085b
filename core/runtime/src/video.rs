//! Video that is looked at: a camera's pixels encoded, or its H.264 decoded and encoded anew, for as long as somebody wants that.
//!
//! Bound: one task for each rendition that is looked at, with one picture in work; what comes meanwhile is left out but for the newest. Must never
//! do: encode what nobody looks at, or compute on a thread that others wait for.

mod between;
mod making;
mod recording;
mod rtp;

use crate::handle::NodeHandle;
use making::Maker;
use skein_domain::payload::PayloadKind;
use skein_domain::{Refusal, VehicleId};
use skein_state::video::{Making, Quality, RemoteStream, Rendition, VideoHealth, VideoStream, Viewer};
use skein_video::Coding;
use std::sync::Arc;

pub use recording::RecordedVideo;
pub(crate) use rtp::RtpOut;

/// Pause before pictures are made anew.
const REMADE_AFTER: std::time::Duration = std::time::Duration::from_millis(100);

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

impl NodeHandle {
    /// The cameras of the swarm's vehicles, those of this node first.
    #[must_use]
    pub fn videos(&self) -> Vec<CameraVideo> {
        let mut all = self.videos_here();
        all.extend(self.videos_elsewhere());
        all
    }

    fn videos_elsewhere(&self) -> Vec<CameraVideo> {
        let (now, fleet) = (self.now(), self.snapshot());
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

    /// Whether a camera of this node gives H.264 and, of late, no pixels: whoever wants a picture of it has to look at [`Rendition::FILES`].
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

    /// Looks at a camera from now on.
    ///
    /// # Errors
    /// When there is no such vehicle or payload, or it is no camera.
    pub fn watch_video(&self, vehicle: VehicleId, payload: &str, rendition: Rendition) -> Result<Viewer, Refusal> {
        let (video, elsewhere) = match self.shared.host(vehicle) {
            Some(node) => {
                self.video(vehicle, payload)?;
                (self.shared.videos.camera(vehicle, payload), Some(node))
            }
            None => (self.camera(vehicle, payload)?.video.clone(), None),
        };
        let stream = video.stream(rendition);
        let viewer = stream.view();
        let Some(making) = stream.begin_making() else {
            return Ok(viewer);
        };
        let is_passed_on = elsewhere.is_none() && rendition == Rendition::OF_CAMERA && video.encodes(self.now());
        if !is_passed_on {
            // Nobody has looked for a while: the last pictures are of that time.
            stream.forget_pictures();
        }
        let looked = Looked {
            vehicle,
            payload: payload.to_owned(),
        };
        if let Some(node) = elsewhere.filter(|_| rendition.coding == Coding::H264) {
            let remote = RemoteStream {
                video,
                rendition,
                stream,
            };
            let node_here = self.clone();
            tokio::spawn(while_looked_at(remote.stream.clone(), making, move || {
                between::fetch(node_here.clone(), node, looked.clone(), remote.clone())
            }));
            return Ok(viewer);
        }
        // Of another node's camera JPEG is made of the H.264 that comes from there, in the same size.
        let source = Rendition {
            coding: Coding::H264,
            quality: if elsewhere.is_some() {
                rendition.quality
            } else {
                Quality::Main
            },
        };
        let node_here = self.clone();
        tokio::spawn(while_looked_at(stream.clone(), making, move || {
            let (looked, video, stream) = (looked.clone(), video.clone(), stream.clone());
            Maker::new(node_here.clone(), looked, video, source, rendition, stream).run()
        }));
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

/// Makes pictures until nobody looks any more. Who began to look while that was found out, and saw that somebody makes them, is not left alone.
async fn while_looked_at<F: Future<Output = ()>>(stream: Arc<VideoStream>, making: Making, make: impl Fn() -> F) {
    let mut making = Some(making);
    while let Some(present) = making.take() {
        make().await;
        drop(present);
        if stream.viewers() > 0 {
            tokio::time::sleep(REMADE_AFTER).await;
            making = stream.begin_making();
        }
    }
}

/// Which camera is looked at.
#[derive(Debug, Clone)]
struct Looked {
    vehicle: VehicleId,
    payload: String,
}

/// What a camera reports to be wrong.
fn fault_of(camera: &skein_state::PayloadRecord) -> String {
    let published = camera.state();
    let fault = published.report.as_ref().and_then(|report| report.value.get("fault"));
    fault.and_then(|fault| fault.as_str()).unwrap_or_default().to_owned()
}
