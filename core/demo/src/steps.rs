//! How evenly setpoints move: the largest step of anyone's position setpoint beyond what its flight explains, from the pictures of the
//! fleet.

use super::scenario_runner::ScenarioRunner;
use parking_lot::Mutex;
use skein_domain::{NodeTime, PositionNed, VehicleId};
use skein_runtime::NodeHandle;
use skein_view::FleetSnapshot;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;

/// How often it is looked whether there is a new picture; they are made 20 times a second.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// The largest step seen.
#[derive(Debug, Clone, Copy)]
pub struct SetpointStep {
    /// Whose.
    pub vehicle: VehicleId,
    /// How far beyond what its speed explains, in metres.
    pub beyond_m: f64,
    /// When.
    pub time: NodeTime,
    /// The whole step.
    pub step_m: nalgebra::Vector3<f64>,
}

/// A watch under way. Dropping it ends it.
pub struct StepWatch {
    task: JoinHandle<()>,
    largest: Arc<Mutex<Option<SetpointStep>>>,
}

impl SetpointStep {
    /// In words.
    pub fn describe(&self) -> String {
        let (vehicle, beyond_m, at_s) = (self.vehicle, self.beyond_m, self.time.as_seconds());
        let (north_m, east_m, down_m) = (self.step_m.x, self.step_m.y, self.step_m.z);
        format!(
            "the largest step of a setpoint was vehicle {vehicle}'s at {at_s:.2} s: {north_m:.1} m north, {east_m:.1} m east, \
             {down_m:.1} m down, {beyond_m:.2} m more than its speed explains"
        )
    }
}

impl StepWatch {
    /// Watches everyone but `except`, at a speed of the formation in metres per second.
    pub fn begin(node: &NodeHandle, except: Option<VehicleId>, speed_m_s: f64) -> Self {
        let largest = Arc::new(Mutex::new(None));
        let (node, seen) = (node.clone(), largest.clone());
        let task = tokio::spawn(async move {
            let mut places = BTreeMap::new();
            let mut clock = tokio::time::interval(LOOK_EVERY);
            let mut sequence = 0;
            loop {
                clock.tick().await;
                let fleet = node.snapshot();
                if fleet.sequence != sequence {
                    sequence = fleet.sequence;
                    look(&fleet, except, speed_m_s, &mut places, &seen);
                }
            }
        });
        Self { task, largest }
    }

    /// Ends it; gives the largest step.
    pub fn end(self, runner: &ScenarioRunner<'_>) -> Option<SetpointStep> {
        let largest = *self.largest.lock();
        if let Some(step) = &largest {
            runner.say(&step.describe());
        }
        largest
    }
}

impl Drop for StepWatch {
    fn drop(&mut self) {
        self.task.abort();
    }
}

type Places = BTreeMap<VehicleId, (NodeTime, PositionNed)>;

fn look(
    fleet: &FleetSnapshot,
    except: Option<VehicleId>,
    speed_m_s: f64,
    places: &mut Places,
    largest: &Mutex<Option<SetpointStep>>,
) {
    for vehicle in fleet.vehicles.iter().filter(|v| Some(v.id) != except) {
        let Some(place) = vehicle.slot else {
            places.remove(&vehicle.id);
            continue;
        };
        if let Some((before, from)) = places.insert(vehicle.id, (fleet.time, place)) {
            let own_m_s = vehicle.kinematics.map_or(0.0, |k| k.velocity.norm());
            let explained_m = own_m_s.max(speed_m_s) * fleet.time.seconds_since(before);
            let beyond_m = from.distance_m(&place) - explained_m;
            let mut largest = largest.lock();
            if largest.is_none_or(|l| beyond_m > l.beyond_m) {
                *largest = Some(SetpointStep {
                    vehicle: vehicle.id,
                    beyond_m,
                    time: fleet.time,
                    step_m: place.vector() - from.vector(),
                });
            }
        }
    }
}
