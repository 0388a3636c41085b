//! The swarm as a whole as a node of ROS 2: formation, tracks, transforms and diagnostics of all.
//!
//! Must never do: say anything of one vehicle that its own node says.

use crate::endpoints::{Place, Voice};
use crate::interfaces::diagnostic::{DiagnosticArray, DiagnosticStatus, KeyValue, Level};
use crate::interfaces::geometry::{TFMessage, TransformStamped};
use crate::interfaces::skein::Formation;
use crate::interfaces::vision::Detection3DArray;
use crate::stamp::Stamps;
use crate::{Ros2Error, Tasks, frames, names, quality, services, translate};
use ros2_client::{Context, Spinner};
use skein_runtime::NodeHandle;
use skein_view::ActorStatus;
use skein_view::FleetSnapshot;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The swarm. Its tasks end with it.
pub struct Swarm {
    _tasks: Tasks,
    formation: Voice<Formation>,
    tracks: Voice<Detection3DArray>,
    transforms: Voice<TFMessage>,
    diagnostics: Voice<DiagnosticArray>,
    dropped: Arc<AtomicU64>,
    place: Place,
}

impl Swarm {
    /// The node for it.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn new(
        context: &Context,
        node: &NodeHandle,
        runtime: &tokio::runtime::Handle,
        dropped: Arc<AtomicU64>,
    ) -> Result<Self, Ros2Error> {
        let settings = &node.config().ros2;
        let namespace = format!("/{}", settings.namespace);
        let mut place = Place::new(context, &namespace, names::SWARM_NODE, dropped.clone())?;
        let mut tasks = Tasks::new(runtime.clone());
        if settings.services {
            services::of_swarm(&mut place, node, &mut tasks)?;
        }
        Ok(Self {
            formation: place.voice("formation", &quality::latched())?,
            tracks: place.voice("tracks", &quality::status())?,
            transforms: place.voice("/tf", &quality::transforms())?,
            diagnostics: place.voice("/diagnostics", &quality::status())?,
            _tasks: tasks,
            dropped,
            place,
        })
    }

    /// What has to run for others to be seen: one for all nodes.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn spinner(&mut self) -> Result<Spinner, Ros2Error> {
        self.place.node.spinner().map_err(|e| Ros2Error::of("spinner", &e))
    }

    /// Says transforms of all vehicles at once.
    pub fn say_transforms(&self, transforms: Vec<TransformStamped>) {
        if !transforms.is_empty() {
            self.transforms.say(TFMessage { transforms });
        }
    }

    /// Says how the swarm is.
    pub fn say_status(&self, fleet: &FleetSnapshot, stamps: &Stamps) {
        self.formation.say(translate::formation(fleet, stamps));
        self.tracks.say(Detection3DArray {
            header: stamps.header(fleet.time, frames::MAP),
            detections: fleet
                .tracks
                .iter()
                .map(|track| translate::track(track, stamps))
                .collect(),
        });
    }

    /// Says how well all are.
    pub fn say_health(&self, fleet: &FleetSnapshot, vehicles: Vec<DiagnosticStatus>, stamps: &Stamps) {
        let ended: Vec<_> = fleet
            .actors
            .iter()
            .filter(|actor| actor.status != ActorStatus::Running)
            .collect();
        let dropped = self.dropped.load(Ordering::Relaxed);
        let values = [
            ("vehicles", fleet.vehicles.len().to_string()),
            ("messages_dropped_for_slow_readers", dropped.to_string()),
        ];
        let level = if ended.is_empty() { Level::Ok } else { Level::Warn };
        let own = DiagnosticStatus {
            level: level as u8,
            name: "skein: node".to_owned(),
            message: ended
                .iter()
                .map(|actor| format!("{}: {}", actor.name, actor.last_error))
                .collect::<Vec<_>>()
                .join("; "),
            hardware_id: String::new(),
            values: values
                .into_iter()
                .map(|(key, value)| KeyValue {
                    key: key.to_owned(),
                    value,
                })
                .collect(),
        };
        self.diagnostics.say(DiagnosticArray {
            header: stamps.header(fleet.time, ""),
            status: std::iter::once(own).chain(vehicles).collect(),
        });
    }
}
