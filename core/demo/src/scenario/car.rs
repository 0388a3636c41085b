//! Something that drives along below the swarm and whose place is told five times a second, as a car with a satellite receiver would
//! tell it: late, and without its velocity.
//!
//! Must never do: tell where the formation should be. It tells where itself is, at the height of the flight.

use crate::referee::Errors;
use parking_lot::Mutex;
use skein_coordination::ReferenceReport;
use skein_domain::PositionNed;
use skein_runtime::NodeHandle;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::Instant;

/// Time between two reports.
const REPORT_PERIOD: Duration = Duration::from_millis(200);
/// The way: straight, a quarter turn to the left, straight; in metres.
const FIRST_LEG_M: f64 = 45.0;
const TURN_RADIUS_M: f64 = 20.0;
const SECOND_LEG_M: f64 = 12.0;
/// It speeds up this hard, in metres per second squared.
const ACCELERATION_M_S2: f64 = 1.0;
/// Until the formation has set off, in seconds, its distance from the car does not count.
const SETTLING_S: f64 = 8.0;

/// A drive under way.
pub struct Car {
    task: JoinHandle<()>,
    seen: Arc<Mutex<CarSeen>>,
}

#[derive(Default)]
struct CarSeen {
    arrived: bool,
    off: Errors,
}

impl Car {
    /// Drives off westwards.
    pub fn drive(node: NodeHandle, name: &'static str, start: PositionNed, speed_m_s: f64) -> Self {
        let seen = Arc::new(Mutex::new(CarSeen::default()));
        let task = tokio::spawn(drive(node, name, start, speed_m_s, seen.clone()));
        Self { task, seen }
    }

    /// Whether it is at the end of its way.
    pub fn arrived(&self) -> bool {
        self.seen.lock().arrived
    }

    /// Ends the reports; gives how far the formation's anchor was off the car.
    pub fn stop(self) -> Errors {
        self.task.abort();
        self.seen.lock().off
    }
}

async fn drive(node: NodeHandle, name: &'static str, start: PositionNed, speed_m_s: f64, seen: Arc<Mutex<CarSeen>>) {
    let began = Instant::now();
    let mut clock = tokio::time::interval(REPORT_PERIOD);
    loop {
        clock.tick().await;
        let elapsed_s = began.elapsed().as_secs_f64();
        let (place, arrived) = place(&start, driven_m(elapsed_s, speed_m_s));
        let report = ReferenceReport {
            position: place,
            velocity: None,
            heading_rad: None,
        };
        // A refused report shows in the distance of the anchor.
        let _ = node.tell_reference(name, report);
        let mut seen = seen.lock();
        seen.arrived = arrived;
        if let Some(slots) = node.slots().filter(|_| elapsed_s > SETTLING_S && !arrived) {
            let age_s = node.now().seconds_since(slots.anchor.time);
            seen.off.add(
                slots
                    .anchor
                    .position
                    .after(&slots.anchor.velocity, age_s)
                    .distance_m(&place),
            );
        }
    }
}

/// How far it has come.
fn driven_m(elapsed_s: f64, speed_m_s: f64) -> f64 {
    let speeding_s = speed_m_s / ACCELERATION_M_S2;
    if elapsed_s < speeding_s {
        0.5 * ACCELERATION_M_S2 * elapsed_s * elapsed_s
    } else {
        0.5 * speed_m_s * speeding_s + speed_m_s * (elapsed_s - speeding_s)
    }
}

/// Where it is so far along its way, and whether that is the end: west, a turn to the left, south.
fn place(start: &PositionNed, driven_m: f64) -> (PositionNed, bool) {
    let arc_m = TURN_RADIUS_M * std::f64::consts::FRAC_PI_2;
    let (first_m, rest_m) = (driven_m.min(FIRST_LEG_M), (driven_m - FIRST_LEG_M).max(0.0));
    let angle_rad = (rest_m / TURN_RADIUS_M).min(std::f64::consts::FRAC_PI_2);
    let last_m = (rest_m - arc_m).clamp(0.0, SECOND_LEG_M);
    let south_m = TURN_RADIUS_M * (1.0 - angle_rad.cos()) + last_m;
    let west_m = first_m + TURN_RADIUS_M * angle_rad.sin();
    let place = start.moved(nalgebra::Vector3::new(-south_m, -west_m, 0.0));
    (place, rest_m >= arc_m + SECOND_LEG_M)
}
