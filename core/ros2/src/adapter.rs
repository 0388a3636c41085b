//! The thread that speaks: one context for all nodes of ROS 2, vehicles that come and go, and what is said at which rate.
//!
//! Must never do: block anything but itself, or make the nodes of many vehicles at once: each is announced to everybody.

use crate::rate::Rate;
use crate::stamp::Stamps;
use crate::swarm::Swarm;
use crate::vehicle::Ros2Vehicle;
use crate::{Ros2Error, names};
use ros2_client::Context;
use skein_dds::Place;
use skein_domain::VehicleId;
use skein_runtime::NodeHandle;
use skein_view::FleetSnapshot;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant, SystemTime};
use tokio::sync::oneshot;

/// How often it is looked whether something is to be said.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// One more vehicle gets its node after so long at the soonest.
const NEXT_VEHICLE_AFTER: Duration = Duration::from_millis(50);
/// Diagnostics per second.
const HEALTH_HZ: f64 = 1.0;
/// Sockets and wake-ups of many vehicles need more files than a shell usually permits.
const FILES: u64 = 65_536;

/// What speaks. It ends soon after this is dropped.
pub struct Running {
    _stop: mpsc::Sender<()>,
    ended: oneshot::Receiver<Ros2Error>,
}

impl Running {
    /// Waits until it has failed; for ever, if it does not.
    pub async fn failed(self) -> Ros2Error {
        self.ended.await.unwrap_or_else(|_| Ros2Error::Thread {
            reason: "it has ended".to_owned(),
        })
    }
}

/// Shows a node to ROS 2, as its configuration has it. To be called within the node's runtime, where its services are answered.
///
/// # Errors
/// When there is no thread to be had.
pub fn start(node: NodeHandle, place: Arc<Place>) -> Result<Running, Ros2Error> {
    let no_thread = |reason: String| Ros2Error::Thread { reason };
    let runtime = tokio::runtime::Handle::try_current().map_err(|e| no_thread(e.to_string()))?;
    let (stop, stopped) = mpsc::channel();
    let (end, ended) = oneshot::channel();
    let speak = move || {
        if let Err(error) = speak(&node, &place, &runtime, &stopped) {
            // Who does not wait for it does not want to know.
            let _ = end.send(error);
        }
    };
    let thread = std::thread::Builder::new().name("skein-ros2".to_owned());
    thread.spawn(speak).map_err(|e| no_thread(e.to_string()))?;
    Ok(Running { _stop: stop, ended })
}

struct Speaker<'a> {
    node: &'a NodeHandle,
    runtime: &'a tokio::runtime::Handle,
    // Before the context: nodes go before it does.
    vehicles: BTreeMap<VehicleId, Ros2Vehicle>,
    swarm: Swarm,
    context: Context,
    names: names::Names,
    dropped: Arc<AtomicU64>,
    next_vehicle: Instant,
}

fn speak(
    node: &NodeHandle,
    place: &Place,
    runtime: &tokio::runtime::Handle,
    stopped: &mpsc::Receiver<()>,
) -> Result<(), Ros2Error> {
    permit_files();
    let start = |reason: &dyn std::fmt::Display| Ros2Error::Start {
        reason: reason.to_string(),
    };
    let participant = place.participant().map_err(|e| start(&e))?;
    let context = Context::from_domain_participant(participant).map_err(|e| start(&e))?;
    let dropped = Arc::new(AtomicU64::new(0));
    let mut swarm = Swarm::new(&context, node, runtime, dropped.clone())?;
    let spinning = runtime.spawn(swarm.spinner()?.spin());
    let mut speaker = Speaker {
        node,
        runtime,
        vehicles: BTreeMap::new(),
        swarm,
        context,
        names: names::Names::default(),
        dropped,
        next_vehicle: Instant::now(),
    };
    let ended = speaker.run(stopped);
    drop(speaker);
    // It has been told to by the end of its node; it holds the context until then.
    spinning.abort();
    ended
}

impl Speaker<'_> {
    fn run(&mut self, stopped: &mpsc::Receiver<()>) -> Result<(), Ros2Error> {
        let (settings, now) = (self.node.config().ros2.clone(), Instant::now());
        let mut motion = Rate::new(settings.motion_rate_hz, now);
        let mut status = Rate::new(settings.status_rate_hz, now);
        let mut pictures = Rate::new(settings.image_rate_hz, now);
        let mut health = Rate::new(HEALTH_HZ, now);
        let mut said = None;
        while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(LOOK_EVERY) {
            let now = Instant::now();
            let fleet = self.node.snapshot();
            self.keep(&fleet, now)?;
            let stamps = self.stamps();
            if said != Some(fleet.sequence) && motion.is_due(now) {
                said = Some(fleet.sequence);
                self.say_motion(&fleet, &stamps)?;
            }
            if status.is_due(now) {
                self.say_status(&fleet, &stamps)?;
            }
            if pictures.is_due(now) {
                self.say_pictures(&fleet, &stamps)?;
            }
            if health.is_due(now) {
                self.say_health(&fleet, &stamps);
            }
        }
        Ok(())
    }

    fn stamps(&self) -> Stamps {
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        Stamps {
            node: self.node.now(),
            system: since_1970.unwrap_or_default(),
        }
    }

    /// Vehicles that are gone lose their node; of those that are new the next one gets it.
    fn keep(&mut self, fleet: &FleetSnapshot, now: Instant) -> Result<(), Ros2Error> {
        let is_there = |id: &VehicleId| fleet.vehicles.iter().any(|vehicle| vehicle.id == *id);
        self.vehicles.retain(|id, _| is_there(id));
        let newcomer = fleet
            .vehicles
            .iter()
            .find(|vehicle| !self.vehicles.contains_key(&vehicle.id));
        let Some(newcomer) = newcomer.filter(|_| now >= self.next_vehicle) else {
            return Ok(());
        };
        self.next_vehicle = now + NEXT_VEHICLE_AFTER;
        let name = self.names.of(newcomer.id, &newcomer.name);
        let vehicle = Ros2Vehicle::new(
            &self.context,
            self.node,
            self.runtime,
            newcomer.id,
            name,
            self.dropped.clone(),
        )?;
        self.vehicles.insert(newcomer.id, vehicle);
        Ok(())
    }

    fn say_motion(&mut self, fleet: &FleetSnapshot, stamps: &Stamps) -> Result<(), Ros2Error> {
        let mut transforms = Vec::new();
        for vehicle in &fleet.vehicles {
            if let Some(node) = self.vehicles.get_mut(&vehicle.id) {
                transforms.extend(node.say_motion(vehicle, fleet, stamps).into_iter().flatten());
                // What another node's plugins say of time is by that node's clock.
                if self.node.host_elsewhere(vehicle.id).is_none() {
                    node.say_detections(vehicle, stamps)?;
                }
            }
        }
        self.swarm.say_transforms(transforms);
        Ok(())
    }

    fn say_status(&mut self, fleet: &FleetSnapshot, stamps: &Stamps) -> Result<(), Ros2Error> {
        for vehicle in &fleet.vehicles {
            if let Some(node) = self.vehicles.get_mut(&vehicle.id) {
                node.say_status(vehicle, fleet, stamps)?;
            }
        }
        self.swarm.say_status(fleet, stamps);
        Ok(())
    }

    fn say_pictures(&mut self, fleet: &FleetSnapshot, stamps: &Stamps) -> Result<(), Ros2Error> {
        let mut transforms = Vec::new();
        for vehicle in &fleet.vehicles {
            if let Some(node) = self.vehicles.get_mut(&vehicle.id) {
                transforms.extend(node.say_pictures(vehicle, self.node, stamps)?);
            }
        }
        self.swarm.say_transforms(transforms);
        Ok(())
    }

    fn say_health(&self, fleet: &FleetSnapshot, stamps: &Stamps) {
        let of = |vehicle: &skein_view::VehicleSnapshot| Some(self.vehicles.get(&vehicle.id)?.health(vehicle));
        let vehicles = fleet.vehicles.iter().filter_map(of).collect();
        self.swarm.say_health(fleet, vehicles, stamps);
    }
}

/// As many open files as this process may have.
fn permit_files() {
    use rustix::process::{Resource, getrlimit, setrlimit};
    let mut limit = getrlimit(Resource::Nofile);
    let most = limit.maximum.map_or(FILES, |maximum| maximum.min(FILES));
    if limit.current.is_some_and(|current| current < most) {
        limit.current = Some(most);
        if let Err(error) = setrlimit(Resource::Nofile, limit) {
            tracing::warn!("the limit of open files cannot be raised: {error}");
        }
    }
}
