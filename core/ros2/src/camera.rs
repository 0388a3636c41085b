//! The topics of one camera: its pictures, and how it sees.
//!
//! Must never do: encode or decode a picture that nobody looks at.

use crate::endpoints::{Place, Voice};
use crate::interfaces::geometry::TransformStamped;
use crate::interfaces::sensor::{CameraInfo, CompressedImage};
use crate::stamp::Stamps;
use crate::{Ros2Error, picture, quality};
use skein_domain::payload::FrameHeader;
use skein_domain::{NodeTime, VehicleId};
use skein_runtime::{NodeHandle, Rendition, Viewer};

/// One camera.
pub struct Camera {
    image: Voice<CompressedImage>,
    info: Voice<CameraInfo>,
    optical_frame: String,
    vehicle: VehicleId,
    payload: String,
    last_sequence: u64,
    /// Looks at what is made of its H.264, as long as somebody here looks at that.
    files: Option<Viewer>,
}

impl Camera {
    /// The topics of a vehicle's payload under this name.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn new(
        place: &mut Place,
        (vehicle, payload): (VehicleId, &str),
        topics: &str,
        optical_frame: String,
    ) -> Result<Self, Ros2Error> {
        Ok(Self {
            image: place.voice(&format!("{topics}/image_raw/compressed"), &quality::pictures())?,
            info: place.voice(&format!("{topics}/camera_info"), &quality::pictures())?,
            optical_frame,
            vehicle,
            payload: payload.to_owned(),
            last_sequence: 0,
            files: None,
        })
    }

    /// Says the newest picture if somebody looks at it; where it was taken, if the camera tells that.
    pub fn say(
        &mut self,
        place: &Place,
        node: &NodeHandle,
        runtime: &tokio::runtime::Handle,
        stamps: &Stamps,
    ) -> Option<TransformStamped> {
        let (looked_at, info_heard) = (place.is_heard(&self.image), place.is_heard(&self.info));
        if !looked_at && !info_heard {
            self.files = None;
            return None;
        }
        if !node.streams().gives_no_pixels(self.vehicle, &self.payload) {
            self.files = None;
            return self.say_pixels(node, looked_at, stamps);
        }
        if looked_at {
            self.say_file(node, runtime, stamps);
        } else {
            // How large its pictures are is known without decoding one.
            self.files = None;
            self.say_size(node, stamps);
        }
        None
    }

    fn say_pixels(&mut self, node: &NodeHandle, looked_at: bool, stamps: &Stamps) -> Option<TransformStamped> {
        let frame = node.payload_frame(self.vehicle, &self.payload).ok().flatten()?;
        if frame.header.sequence == self.last_sequence {
            return None;
        }
        self.last_sequence = frame.header.sequence;
        let header = stamps.header(frame.header.time, &self.optical_frame);
        let pose = frame.header.pose.as_ref();
        let transform = pose.map(|pose| picture::transform(header.clone(), &self.optical_frame, pose));
        self.info.say(picture::info(header.clone(), &frame.header));
        if let Some(data) = looked_at.then(|| picture::jpeg(&frame.header, frame.bytes())).flatten() {
            self.image.say(picture::compressed(header, data));
        }
        transform
    }

    /// The newest picture that was made of H.264 since the last one.
    fn say_file(&mut self, node: &NodeHandle, runtime: &tokio::runtime::Handle, stamps: &Stamps) {
        if self.files.is_none() {
            // What makes the pictures runs there.
            let _within = runtime.enter();
            self.files = node
                .streams()
                .watch_video(self.vehicle, &self.payload, Rendition::FILES)
                .ok();
        }
        let Some(viewer) = &mut self.files else { return };
        let Some(given) = std::iter::from_fn(|| viewer.try_next()).last() else {
            return;
        };
        let frame = given.frame;
        self.say_info(frame.taken, (frame.width_px, frame.height_px), stamps);
        let header = stamps.header(frame.taken, &self.optical_frame);
        self.image.say(picture::compressed(header, frame.bytes.to_vec()));
    }

    fn say_size(&self, node: &NodeHandle, stamps: &Stamps) {
        if let Ok(video) = node.streams().video(self.vehicle, &self.payload) {
            self.say_info(stamps.node, video.health.size_px, stamps);
        }
    }

    fn say_info(&self, taken: NodeTime, (width_px, height_px): (u32, u32), stamps: &Stamps) {
        let header = stamps.header(taken, &self.optical_frame);
        let of = FrameHeader {
            width_px,
            height_px,
            ..FrameHeader::default()
        };
        self.info.say(picture::info(header, &of));
    }
}
