//! What is made for who looks at a camera, for as long as somebody does.
//!
//! Must never do: go on when nobody looks any more.

use crate::CameraStreams;
use crate::between;
use crate::making::Maker;
use crate::streams::Looked;
use skein_domain::{Refusal, VehicleId};
use skein_state::video::{Making, Quality, RemoteStream, Rendition, VideoStream, Viewer};
use skein_video::Coding;
use std::sync::Arc;

/// Pause before pictures are made anew.
const REMADE_AFTER: std::time::Duration = std::time::Duration::from_millis(100);

impl CameraStreams {
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
