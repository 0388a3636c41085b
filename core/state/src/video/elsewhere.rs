//! Video between nodes: the cameras of other nodes that are looked at here, and the streams that other nodes want of this one.

use super::{Rendition, Video, VideoStream};
use parking_lot::Mutex;
use skein_domain::{NodeId, NodeTime, VehicleId};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A stream that is wanted goes on for so long after it was last asked for, in seconds.
const WANTED_FOR_S: f64 = 3.5;

/// A stream of another node, as its pictures find their way.
#[derive(Debug, Clone)]
pub struct RemoteStream {
    /// The camera's video.
    pub video: Arc<Video>,
    /// In which rendition it comes.
    pub rendition: Rendition,
    /// Where its pictures go.
    pub stream: Arc<VideoStream>,
}

/// A stream that another node wants of this one.
#[derive(Debug)]
struct Wanted {
    until: NodeTime,
    key: Arc<AtomicBool>,
}

/// Video between nodes.
#[derive(Debug, Default)]
pub struct VideosElsewhere {
    cameras: Mutex<BTreeMap<(VehicleId, String), Arc<Video>>>,
    wanted: Mutex<BTreeMap<(NodeId, u32), Wanted>>,
}

impl VideosElsewhere {
    /// The video of another node's camera.
    pub fn camera(&self, vehicle: VehicleId, payload: &str) -> Arc<Video> {
        let mut cameras = self.cameras.lock();
        cameras.entry((vehicle, payload.to_owned())).or_default().clone()
    }

    /// Another node wants a stream under its number for it. If it is new, the sign by which it asks for key pictures.
    pub fn want(&self, now: NodeTime, by: NodeId, number: u32) -> Option<Arc<AtomicBool>> {
        let until = now.plus_seconds(WANTED_FOR_S);
        let mut wanted = self.wanted.lock();
        if let Some(known) = wanted.get_mut(&(by, number)) {
            known.until = until;
            return None;
        }
        let key = Arc::new(AtomicBool::new(true));
        let sign = key.clone();
        wanted.insert((by, number), Wanted { until, key });
        Some(sign)
    }

    /// Whether it is still wanted.
    pub fn is_wanted(&self, now: NodeTime, by: NodeId, number: u32) -> bool {
        let wanted = self.wanted.lock();
        wanted.get(&(by, number)).is_some_and(|known| now < known.until)
    }

    /// It is not sent any more: who still wants it begins anew with the next ask.
    pub fn forget(&self, by: NodeId, number: u32) {
        self.wanted.lock().remove(&(by, number));
    }

    /// It cannot go on without a key picture.
    pub fn want_key(&self, by: NodeId, number: u32) {
        if let Some(known) = self.wanted.lock().get(&(by, number)) {
            known.key.store(true, Ordering::Relaxed);
        }
    }
}
