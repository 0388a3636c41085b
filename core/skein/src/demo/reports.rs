//! What the referee sees of vehicles that no simulator of ours moves: their autopilots' own reports, brought to one moment.
//!
//! Must never do: ask a vehicle for anything, or fill in what it did not report.

use super::referee::Referee;
use nalgebra::Vector3;
use skein_domain::{AccelerationNed, LandedState, VehicleId, VelocityNed};
use skein_runtime::{EventKind, FleetSnapshot, NodeHandle, VehicleSnapshot};
use skein_sim::{ModeCause, ModeChange, TruthFrame, VehicleTruth};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;

/// How often it is looked whether there is a new picture of the fleet; they are made 20 times a second.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Over this time the acceleration is taken from the velocity, in seconds: one picture's noise would be all there is.
const ACCELERATION_OVER_S: f64 = 0.2;
/// A position older than this is none, in seconds.
const POSITION_WITHIN_S: f64 = 1.0;

/// Feeds the referee. Dropping it ends it.
pub struct Watch(JoinHandle<()>);

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Shows the referee every new picture of the fleet.
pub fn watch(referee: &Referee, node: NodeHandle) -> Watch {
    let show = referee.shown();
    Watch(tokio::spawn(async move {
        let mut clock = tokio::time::interval(LOOK_EVERY);
        let mut reports = Reports::default();
        let mut sequence = 0;
        loop {
            clock.tick().await;
            let fleet = node.snapshot();
            if fleet.sequence != sequence {
                sequence = fleet.sequence;
                show(&reports.frame(&fleet, &node));
            }
        }
    }))
}

/// What is remembered from one picture to the next.
#[derive(Default)]
struct Reports {
    velocities: BTreeMap<VehicleId, (f64, Vector3<f64>, Vector3<f64>)>,
    taken_over: BTreeMap<VehicleId, Vec<ModeChange>>,
    events: u64,
}

impl Reports {
    fn frame(&mut self, fleet: &FleetSnapshot, node: &NodeHandle) -> TruthFrame {
        let time_s = fleet.time.as_seconds();
        for event in node.events_after(self.events) {
            self.events = event.seq;
            if let (EventKind::TakenOver { failsafe, from, to }, Some(vehicle)) = (&event.kind, event.vehicle) {
                let cause = if *failsafe {
                    ModeCause::Failsafe
                } else {
                    ModeCause::Pilot
                };
                self.taken_over.entry(vehicle).or_default().push(ModeChange {
                    time_s: event.time.as_seconds(),
                    from: *from,
                    to: *to,
                    cause,
                });
            }
        }
        TruthFrame {
            time_s,
            sequence: fleet.sequence,
            vehicles: fleet
                .vehicles
                .iter()
                .filter_map(|vehicle| self.vehicle(time_s, fleet, vehicle))
                .collect(),
            ..TruthFrame::default()
        }
    }

    fn vehicle(&mut self, time_s: f64, fleet: &FleetSnapshot, told: &VehicleSnapshot) -> Option<VehicleTruth> {
        let motion = told.kinematics?;
        let age_s = fleet.time.seconds_since(motion.measured);
        Some(VehicleTruth {
            system_id: told.system_id.0,
            alive: told.link.connected && age_s <= POSITION_WITHIN_S,
            // All at one moment: two reports are up to a tenth of a second apart.
            position: motion.position.after(&motion.velocity, age_s),
            geodetic: told.global?,
            velocity: motion.velocity,
            acceleration: self.acceleration(told.id, time_s, &motion.velocity),
            yaw_rad: motion.yaw_rad,
            armed: told.armed,
            landed: told.landed,
            touches_ground: told.landed == LandedState::OnGround,
            mode: told.mode,
            battery: f64::from(told.battery.remaining.unwrap_or(0.0)),
            mode_changes: Arc::new(self.taken_over.get(&told.id).cloned().unwrap_or_default()),
            ..VehicleTruth::default()
        })
    }

    fn acceleration(&mut self, id: VehicleId, time_s: f64, velocity: &VelocityNed) -> AccelerationNed {
        let now = velocity.vector();
        let (since_s, from, found) = self
            .velocities
            .entry(id)
            .or_insert_with(|| (time_s, now, Vector3::zeros()));
        let dt_s = time_s - *since_s;
        if dt_s >= ACCELERATION_OVER_S {
            *found = (now - *from) / dt_s;
            (*since_s, *from) = (time_s, now);
        }
        AccelerationNed::new(found.x, found.y, found.z)
    }
}
