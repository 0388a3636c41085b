//! What the referee sees of vehicles that no simulator of ours moves: their autopilots' own reports, brought to one moment.
//!
//! Must never do: ask a vehicle for anything, or fill in what it did not report.

use super::referee::Referee;
use nalgebra::Vector3;
use skein_domain::{AccelerationNed, LandedState, VehicleId, VelocityNed};
use skein_runtime::NodeHandle;
use skein_sim::stalls::StallProbe;
use skein_sim::{ModeCause, ModeChange, TruthFrame, VehicleTruth};
use skein_view::{EventKind, FleetSnapshot, VehicleSnapshot};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::task::JoinHandle;

/// How often it is looked whether there is a new picture of the fleet; they are made 20 times a second.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Over this time the acceleration is taken from the velocity, in seconds: one picture's noise would be all there is.
const ACCELERATION_OVER_S: f64 = 0.2;
/// A position older than this is none, in seconds.
const POSITION_WITHIN_S: f64 = 1.0;

/// So long a setpoint is followed, in seconds: who has none to send has not been given one for this time.
const FOLLOWED_S: f64 = 0.5;
/// The gap that is permitted beside what the machine stood still, in seconds: as of simulated vehicles.
const GAP_S: f64 = 0.2;

/// Feeds the referee. Dropping it ends it.
pub struct Watch {
    task: JoinHandle<()>,
    missing: Arc<AtomicU64>,
}

impl Watch {
    /// How many times a link had no fresh setpoint to send, and not because the machine stood still.
    pub fn missing(&self) -> u64 {
        self.missing.load(Ordering::Relaxed)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Shows the referee every new picture of the fleet.
///
/// # Errors
/// When there can be no thread that watches for stalls.
pub fn watch(referee: &Referee, node: NodeHandle) -> std::io::Result<Watch> {
    let show = referee.shown();
    let missing = Arc::new(AtomicU64::new(0));
    let mut reports = Reports {
        stalls: Stalls::watch()?,
        missing: missing.clone(),
        velocities: BTreeMap::new(),
        taken_over: BTreeMap::new(),
        events: 0,
    };
    let task = tokio::spawn(async move {
        let mut clock = tokio::time::interval(LOOK_EVERY);
        let mut sequence = 0;
        loop {
            clock.tick().await;
            let fleet = node.snapshot();
            if fleet.sequence != sequence {
                sequence = fleet.sequence;
                show(&reports.frame(&fleet, &node));
            }
        }
    });
    Ok(Watch { task, missing })
}

/// How long the machine has stood still, with the node's time of each look.
struct Stalls {
    probe: StallProbe,
    looks: VecDeque<(f64, Duration)>,
}

impl Stalls {
    /// Looks that are kept: more than are made in the time that a setpoint is followed.
    const KEPT: usize = 64;

    fn watch() -> std::io::Result<Self> {
        Ok(Self {
            probe: StallProbe::start()?,
            looks: VecDeque::new(),
        })
    }

    fn look(&mut self, time_s: f64) {
        self.looks.push_back((time_s, self.probe.until(Instant::now())));
        if self.looks.len() > Self::KEPT {
            self.looks.pop_front();
        }
    }

    /// Seconds of standing still in the time a setpoint is followed, before a moment that has just been looked at.
    fn before_s(&self, time_s: f64) -> f64 {
        let after = self
            .looks
            .iter()
            .find(|(at_s, _)| *at_s >= time_s)
            .or(self.looks.back());
        let before = self.looks.iter().rev().find(|(at_s, _)| *at_s <= time_s - FOLLOWED_S);
        match (before.or(self.looks.front()), after) {
            (Some((_, before)), Some((_, after))) => after.saturating_sub(*before).as_secs_f64(),
            _ => 0.0,
        }
    }
}

/// What is remembered from one picture to the next.
struct Reports {
    stalls: Stalls,
    missing: Arc<AtomicU64>,
    velocities: BTreeMap<VehicleId, (f64, Vector3<f64>, Vector3<f64>)>,
    taken_over: BTreeMap<VehicleId, Vec<ModeChange>>,
    events: u64,
}

impl Reports {
    fn frame(&mut self, fleet: &FleetSnapshot, node: &NodeHandle) -> TruthFrame {
        let time_s = fleet.time.as_seconds();
        self.stalls.look(time_s);
        for event in node.events_after(self.events) {
            self.events = event.seq;
            if event.kind == EventKind::Stream && FOLLOWED_S - self.stalls.before_s(event.time.as_seconds()) > GAP_S {
                self.missing.fetch_add(1, Ordering::Relaxed);
            }
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
            longest_stall_s: self.stalls.probe.longest().as_secs_f64(),
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
