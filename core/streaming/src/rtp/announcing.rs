//! Tells ground stations of the cameras that are sent as RTP, on the MAVLink links of their vehicles.
//!
//! Must never do: speak for a vehicle that this node does not fly.

use crate::CameraStreams;
use skein_config::{RtpQuality, RtpSettings};
use skein_domain::VehicleId;
use skein_link_mavlink::{Px4Link, ToldCamera, ToldStream};
use skein_state::video::VideoState;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

/// How the streams are is told so often.
const TELL_EVERY: Duration = Duration::from_secs(1);
/// Pictures of this quality are not larger, nor more in a second.
const SUB_PX: (f64, f64) = (320.0, 240.0);
const SUB_RATE_HZ: f64 = 10.0;

/// Tells as long as it runs.
pub(super) async fn announce(node: CameraStreams) {
    let mut told: BTreeMap<VehicleId, Arc<Px4Link>> = BTreeMap::new();
    let mut every = interval(TELL_EVERY);
    every.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        every.tick().await;
        let mut cameras: BTreeMap<VehicleId, Vec<ToldCamera>> = BTreeMap::new();
        for rtp in &node.config().video.rtp {
            add(&node, rtp, cameras.entry(VehicleId(rtp.vehicle)).or_default());
        }
        for (vehicle, cameras) in cameras {
            let link = link_of(&node, vehicle);
            let before = match &link {
                Some(link) => told.insert(vehicle, link.clone()),
                None => told.remove(&vehicle),
            };
            if let Some(before) = before.filter(|before| link.as_ref().is_none_or(|link| !Arc::ptr_eq(link, before))) {
                before.tell_cameras(node.now(), Vec::new());
            }
            if let Some(link) = link {
                link.tell_cameras(node.now(), cameras);
            }
        }
    }
}

/// The MAVLink link over which this node flies a vehicle, if it does.
fn link_of(node: &CameraStreams, vehicle: VehicleId) -> Option<Arc<Px4Link>> {
    let record = node.shared().vehicles.record(vehicle)?;
    let is_here = node.shared().host(vehicle).is_none();
    let link = is_here.then(|| node.links.link(record.link().system_id().0));
    link.flatten()
}

/// One more stream of a camera, if that is there.
fn add(node: &CameraStreams, rtp: &RtpSettings, cameras: &mut Vec<ToldCamera>) {
    let Ok(video) = node.video(VehicleId(rtp.vehicle), &rtp.camera) else {
        return;
    };
    let (health, is_main) = (video.health, rtp.quality == RtpQuality::Main);
    let stream = ToldStream {
        name: if is_main {
            rtp.camera.clone()
        } else {
            format!("{} small", rtp.camera)
        },
        port: rtp.to.port(),
        running: health.state == VideoState::Live,
        rate_hz: if is_main {
            health.measured.rate_hz
        } else {
            health.measured.rate_hz.min(SUB_RATE_HZ)
        },
        size_px: if is_main {
            health.size_px
        } else {
            fitted(health.size_px)
        },
        // Of pixels it is not measured.
        bits_per_s: if is_main {
            health.measured.bytes_per_s * 8.0
        } else {
            0.0
        },
    };
    match cameras.iter_mut().find(|camera| camera.name == rtp.camera) {
        Some(camera) => camera.streams.push(stream),
        None => cameras.push(ToldCamera {
            name: rtp.camera.clone(),
            streams: vec![stream],
        }),
    }
}

fn fitted(size_px: (u32, u32)) -> (u32, u32) {
    let (width_px, height_px) = (f64::from(size_px.0.max(1)), f64::from(size_px.1.max(1)));
    let scale = (SUB_PX.0 / width_px).min(SUB_PX.1 / height_px).min(1.0);
    ((width_px * scale) as u32, (height_px * scale) as u32)
}
