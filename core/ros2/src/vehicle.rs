//! One vehicle as a node of ROS 2: what it says, and the tasks that answer for it.
//!
//! Must never do: say an old position as a new one, or encode a picture that nobody looks at.

use crate::camera::Camera;
use crate::cmd_vel::{self, Report};
use crate::endpoints::{Place, Voice};
use crate::interfaces::diagnostic::DiagnosticStatus;
use crate::interfaces::geometry::{PoseStamped, TransformStamped, Twist};
use crate::interfaces::nav::Odometry;
use crate::interfaces::sensor::{BatteryState, NavSatFix};
use crate::interfaces::skein::{GimbalState, VehicleState};
use crate::interfaces::vision::Detection2DArray;
use crate::stamp::Stamps;
use crate::{Ros2Error, Tasks, detections, names, quality, services, translate};
use parking_lot::Mutex;
use ros2_client::Context;
use skein_domain::payload::PayloadKind;
use skein_domain::{NodeTime, VehicleId};
use skein_runtime::NodeHandle;
use skein_view::{FleetSnapshot, VehicleSnapshot};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

struct Detector {
    detections: Voice<Detection2DArray>,
    /// When the last picture was taken of which was told.
    last: Option<NodeTime>,
}

/// One vehicle. Its tasks end with it.
pub struct Ros2Vehicle {
    // Before the node: its tasks hold servers of it.
    _tasks: Tasks,
    id: VehicleId,
    name: String,
    pose: Voice<PoseStamped>,
    odometry: Voice<Odometry>,
    fix: Voice<NavSatFix>,
    battery: Voice<BatteryState>,
    state: Voice<VehicleState>,
    gimbals: BTreeMap<String, Voice<GimbalState>>,
    cameras: BTreeMap<String, Camera>,
    detectors: BTreeMap<String, Detector>,
    measured: Option<NodeTime>,
    cmd_vel: Arc<Mutex<Report>>,
    runtime: tokio::runtime::Handle,
    place: Place,
}

impl Ros2Vehicle {
    /// A node for a vehicle of this name.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn new(
        context: &Context,
        node: &NodeHandle,
        runtime: &tokio::runtime::Handle,
        id: VehicleId,
        name: String,
        dropped: Arc<AtomicU64>,
    ) -> Result<Self, Ros2Error> {
        let settings = &node.config().ros2;
        let namespace = format!("/{}/{name}", settings.namespace);
        let mut place = Place::new(context, &namespace, names::VEHICLE_NODE, dropped)?;
        let (motion, status) = (quality::motion(settings.reliable_motion), quality::status());
        let mut tasks = Tasks::new(runtime.clone());
        let cmd_vel = Arc::new(Mutex::new(Report::default()));
        if settings.services {
            services::of_vehicle(&mut place, node, id, &name, &mut tasks)?;
        }
        if settings.cmd_vel {
            let velocities = place.ear::<Twist>("cmd_vel", &quality::velocities())?;
            tasks.add(cmd_vel::driver::drive(node.clone(), id, velocities, cmd_vel.clone()));
        }
        Ok(Self {
            pose: place.voice("pose", &motion)?,
            odometry: place.voice("odometry", &motion)?,
            fix: place.voice("nav_sat_fix", &status)?,
            battery: place.voice("battery", &status)?,
            state: place.voice("state", &quality::latched())?,
            gimbals: BTreeMap::new(),
            cameras: BTreeMap::new(),
            detectors: BTreeMap::new(),
            measured: None,
            _tasks: tasks,
            id,
            name,
            cmd_vel,
            runtime: runtime.clone(),
            place,
        })
    }

    /// Says where it is, if that is known and new; the transforms to be said with those of the others.
    pub fn say_motion(
        &mut self,
        vehicle: &VehicleSnapshot,
        fleet: &FleetSnapshot,
        stamps: &Stamps,
    ) -> Option<[TransformStamped; 2]> {
        let at = vehicle.kinematics.filter(|at| Some(at.measured) != self.measured)?;
        self.measured = Some(at.measured);
        let origin = translate::odom_origin(vehicle, fleet.frame.as_ref());
        self.pose.say(translate::pose_stamped(vehicle, &at, stamps));
        let odometry = translate::odometry(vehicle, &self.name, &at, &origin, stamps);
        let transforms = translate::transforms(&odometry, &origin);
        self.odometry.say(odometry);
        Some(transforms)
    }

    /// Says how it is.
    ///
    /// # Errors
    /// When DDS refuses a topic of a payload that has come.
    pub fn say_status(
        &mut self,
        vehicle: &VehicleSnapshot,
        fleet: &FleetSnapshot,
        stamps: &Stamps,
    ) -> Result<(), Ros2Error> {
        self.state.say(translate::state(vehicle, fleet, &self.name, stamps));
        self.battery.say(translate::battery(vehicle, &self.name, stamps));
        if let Some(fix) = translate::fix(vehicle, &self.name, stamps) {
            self.fix.say(fix);
        }
        for payload in vehicle.payloads.iter().filter(|p| p.kind == PayloadKind::Gimbal) {
            let Some(state) = translate::gimbal(payload, stamps) else {
                continue;
            };
            let voice = match self.gimbals.entry(payload.name.clone()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    let topic = format!("{}/state", payload_part(&payload.name));
                    new.insert(self.place.voice(&topic, &quality::status())?)
                }
            };
            voice.say(state);
        }
        Ok(())
    }

    /// Says what detectors found in pictures that nothing was told of.
    ///
    /// # Errors
    /// When DDS refuses a topic of a detector that has come.
    pub fn say_detections(&mut self, vehicle: &VehicleSnapshot, stamps: &Stamps) -> Result<(), Ros2Error> {
        for payload in vehicle.payloads.iter().filter(|p| p.kind == PayloadKind::Detector) {
            let Some(state) = detections::state(payload) else {
                continue;
            };
            let detector = match self.detectors.entry(payload.name.clone()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    let topic = format!("{}/detections", payload_part(&payload.name));
                    new.insert(Detector {
                        detections: self.place.voice(&topic, &quality::status())?,
                        last: None,
                    })
                }
            };
            // No picture is of the future, whatever a plugin says.
            let new = detector.last.replace(state.time) != Some(state.time) && state.time <= stamps.node;
            if let Some(camera) = detections::camera(vehicle, &state).filter(|_| new) {
                let header = stamps.header(state.time, &optical_frame(&self.name, camera));
                detector.detections.say(detections::array(&header, &state));
            }
        }
        Ok(())
    }

    /// Says the newest pictures of cameras that somebody looks at; where each was taken.
    ///
    /// # Errors
    /// When DDS refuses a topic of a camera that has come.
    pub fn say_pictures(
        &mut self,
        vehicle: &VehicleSnapshot,
        node: &NodeHandle,
        stamps: &Stamps,
    ) -> Result<Vec<TransformStamped>, Ros2Error> {
        let mut transforms = Vec::new();
        for payload in vehicle.payloads.iter().filter(|p| p.kind == PayloadKind::Camera) {
            let camera = match self.cameras.entry(payload.name.clone()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    let frame = optical_frame(&self.name, &payload.name);
                    let topics = payload_part(&payload.name);
                    new.insert(Camera::new(&mut self.place, (self.id, &payload.name), &topics, frame)?)
                }
            };
            transforms.extend(camera.say(&self.place, node, &self.runtime, stamps));
        }
        Ok(transforms)
    }

    /// How well it is.
    #[must_use]
    pub fn health(&self, vehicle: &VehicleSnapshot) -> DiagnosticStatus {
        let report = self.cmd_vel.lock().clone();
        let more = vec![
            ("cmd_vel_engaged", report.engaged.to_string()),
            ("cmd_vel_taken", report.taken.to_string()),
            ("cmd_vel_refused", report.refused.to_string()),
            ("cmd_vel_reason", report.reason),
        ];
        translate::health(vehicle, &self.name, more)
    }
}

/// The frame of a camera's picture: right, down, along its axis.
fn optical_frame(vehicle: &str, payload: &str) -> String {
    format!("{vehicle}/{}_optical", payload_part(payload))
}

/// A payload's name as a part of a topic.
fn payload_part(name: &str) -> String {
    match names::sanitised(name) {
        part if part.is_empty() => "payload".to_owned(),
        part => part,
    }
}
