//! Which videos are being recorded on this node, and how far each is.

use parking_lot::Mutex;
use skein_domain::VehicleId;
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::Notify;

/// A recording under way.
#[derive(Debug, Clone)]
pub struct Recording {
    /// The file's name in the folder of recordings.
    pub file: String,
    /// How long it is, in seconds.
    pub seconds: f64,
    /// What it has written, in bytes.
    pub bytes: u64,
}

#[derive(Debug)]
struct UnderWay {
    recording: Recording,
    end: Arc<Notify>,
}

/// The recordings under way, one a camera at most.
#[derive(Debug, Default)]
pub struct Recordings(Mutex<BTreeMap<(VehicleId, String), UnderWay>>);

impl Recordings {
    /// One begins; the sign for its end. `None` if one of this camera is under way.
    pub fn begin(&self, vehicle: VehicleId, payload: &str, file: String) -> Option<Arc<Notify>> {
        let mut under_way = self.0.lock();
        let key = (vehicle, payload.to_owned());
        if under_way.contains_key(&key) {
            return None;
        }
        let end = Arc::new(Notify::new());
        let recording = Recording {
            file,
            seconds: 0.0,
            bytes: 0,
        };
        let end_of = end.clone();
        under_way.insert(key, UnderWay { recording, end });
        Some(end_of)
    }

    /// How far one is.
    pub fn note(&self, vehicle: VehicleId, payload: &str, change: impl FnOnce(&mut Recording)) {
        if let Some(one) = self.0.lock().get_mut(&(vehicle, payload.to_owned())) {
            change(&mut one.recording);
        }
    }

    /// Ends one; what it was. `None` if there is none.
    pub fn end(&self, vehicle: VehicleId, payload: &str) -> Option<Recording> {
        let ended = self.0.lock().remove(&(vehicle, payload.to_owned()))?;
        ended.end.notify_one();
        Some(ended.recording)
    }

    /// All under way, with their cameras.
    pub fn list(&self) -> Vec<(VehicleId, String, Recording)> {
        let under_way = self.0.lock();
        let all = under_way.iter();
        all.map(|((vehicle, payload), one)| (*vehicle, payload.clone(), one.recording.clone()))
            .collect()
    }
}
