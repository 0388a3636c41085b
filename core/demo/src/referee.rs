//! The referee: watches the simulator's truth at 50 Hz, or what autopilots report where no simulator of ours moves them, and measures
//! what the criteria are about. Of the node it takes only which slot each vehicle was given.

mod pointing;

use nalgebra::Vector3;
use parking_lot::Mutex;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{Geodetic, LandedState, PositionNed, SwarmFrame, VehicleId};
use skein_flight::transition;
use skein_runtime::{FormationSlots, NodeHandle};
use skein_sim::{ModeCause, Simulation, TruthFrame, VehicleTruth};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A leader within this of the route's speed, in metres per second, flies at it.
const AT_SPEED_M_S: f64 = 0.5;
/// A formation whose heading turns slower than this, in radians per second, flies straight.
const STRAIGHT_RAD_S: f64 = 0.01;
/// Straight flight counts after it has lasted so long, in seconds: until then it is the end of a turn.
const STEADY_AFTER_S: f64 = 1.5;
/// A leader faster than this, in metres per second, is under way.
const UNDER_WAY_M_S: f64 = 1.0;

/// Between two looks there is less than that, unless the machine does not let the program run.
const STOOD_STILL: Duration = Duration::from_millis(250);
/// What a vehicle or a gimbal did meanwhile is made good after this; until then nobody judges how well it flies, only how near it comes to another.
const MADE_GOOD_AFTER: Duration = Duration::from_secs(10);

/// A landing spot assigned to a vehicle.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The spot in the swarm frame.
    pub spot: PositionNed,
    /// The same as a place on Earth.
    pub place: Geodetic,
}

/// What was measured.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Smallest distance between two vehicles of which at least one was off the ground, in metres, and which two.
    pub smallest_distance: Option<(f64, u8, u8)>,
    /// The same in words, with when and where.
    pub nearest: String,
    /// Formation error in straight legs at speed.
    pub straight: Errors,
    /// Formation error while the formation turns.
    pub turning: Errors,
    /// Per change of formation, the distance of the farthest vehicle from its slot in metres.
    pub slots: Vec<(String, f64)>,
    /// How far gimbals were off what they were to look at, in radians.
    pub pointing: Errors,
    /// Landing spots.
    pub landings: Vec<Landing>,
    /// Speed at which straight flight counts, in metres per second.
    pub cruise_m_s: f64,
    /// System ids of vehicles with which something was done that takes them out of the swarm's control: neither their modes nor their
    /// setpoints count.
    pub excused: BTreeSet<u8>,
    /// System ids of vehicles that are not expected to land.
    pub lost: BTreeSet<u8>,
    /// System ids of vehicles that were told to land on the way.
    pub may_land: BTreeSet<u8>,
    /// System ids of vehicles that came down although nobody had told them to.
    pub came_down: BTreeSet<u8>,
    /// Looks at vehicles in flight, and at how many the separation filter changed what was flown.
    filtered: (u64, u64),
    up: BTreeSet<u8>,
    looks: Option<pointing::Looks>,
    looked_at: Option<Instant>,
    stood_still_at: Option<Instant>,
    steady_since_s: Option<f64>,
    airborne: bool,
}

impl Figures {
    /// Whether gimbals were told to look at something.
    pub fn expects_gimbals(&self) -> bool {
        self.looks.is_some()
    }

    /// Whether the machine did not let the program run a moment ago.
    fn is_disturbed(&self) -> bool {
        self.stood_still_at.is_some_and(|at| at.elapsed() < MADE_GOOD_AFTER)
    }

    fn note_look(&mut self, now: Instant) {
        let last = self.looked_at.replace(now);
        if last.is_some_and(|last| now.duration_since(last) > STOOD_STILL) {
            self.stood_still_at = Some(now);
        }
    }

    /// In what share of the flight, all vehicles together, the separation filter changed what was flown; in percent.
    pub fn filtered_percent(&self) -> Option<f64> {
        let (of, filtered) = self.filtered;
        (of > 0).then(|| 100.0 * filtered as f64 / of as f64)
    }
}

/// Errors of a kind, gathered; in the unit of what is measured.
#[derive(Debug, Clone, Copy, Default)]
pub struct Errors {
    /// How many.
    pub samples: u64,
    sum_squares: f64,
    /// The largest.
    pub largest: f64,
}

impl Errors {
    /// One more.
    pub fn add(&mut self, error: f64) {
        self.samples += 1;
        self.sum_squares += error * error;
        self.largest = self.largest.max(error);
    }

    /// Root mean square; `None` without samples.
    pub fn rms(&self) -> Option<f64> {
        (self.samples > 0).then(|| (self.sum_squares / self.samples as f64).sqrt())
    }
}

/// The referee of one flight.
pub struct Referee {
    figures: Arc<Mutex<Figures>>,
    last: Arc<Mutex<TruthFrame>>,
    node: NodeHandle,
}

impl Referee {
    /// Watches from now on.
    ///
    /// # Errors
    /// When the simulation has ended.
    pub fn watch(simulation: &Simulation, node: NodeHandle) -> anyhow::Result<Self> {
        let referee = Self::new(node);
        simulation.observe(Box::new(referee.shown()))?;
        Ok(referee)
    }

    /// One that sees only what it is [shown](Self::shown).
    pub fn new(node: NodeHandle) -> Self {
        let figures = Arc::new(Mutex::new(Figures {
            cruise_m_s: super::layout::SPEED_M_S,
            ..Figures::default()
        }));
        let last = Arc::new(Mutex::new(TruthFrame::default()));
        Self { figures, last, node }
    }

    /// Through what it is shown one frame after the other.
    pub fn shown(&self) -> impl Fn(&TruthFrame) + Send + Sync + 'static {
        let (seen, newest, handle) = (self.figures.clone(), self.last.clone(), self.node.clone());
        move |truth| {
            look(&mut seen.lock(), truth, &handle);
            newest.lock().clone_from(truth);
        }
    }

    /// Everything measured so far.
    pub fn figures(&self) -> Figures {
        self.figures.lock().clone()
    }

    /// The newest truth.
    pub fn truth(&self) -> TruthFrame {
        self.last.lock().clone()
    }

    /// All vehicles are up: from here on formation errors count.
    pub fn airborne(&self) {
        self.figures.lock().airborne = true;
    }

    /// From now on straight flight counts at this speed.
    pub fn cruise(&self, speed_m_s: f64) {
        self.figures.lock().cruise_m_s = speed_m_s;
    }

    /// Modes and setpoint gaps of this vehicle do not count: something is done to it from outside.
    pub fn excuse(&self, system_id: u8) {
        self.figures.lock().excused.insert(system_id);
    }

    /// This vehicle is told to land before the others.
    pub fn may_land(&self, system_id: u8) {
        self.figures.lock().may_land.insert(system_id);
    }

    /// Begins the next part of a flight: gives the formation errors, straight and turning, of the one that ends.
    pub fn next_part(&self) -> (Errors, Errors) {
        let mut figures = self.figures.lock();
        figures.steady_since_s = None;
        (
            std::mem::take(&mut figures.straight),
            std::mem::take(&mut figures.turning),
        )
    }

    /// Whether the machine did not let the program run a moment ago, and what came of that is not made good yet.
    pub fn is_disturbed(&self) -> bool {
        self.figures.lock().is_disturbed()
    }

    /// How far the farthest vehicle is from its slot now, in metres.
    pub fn farthest_from_slot_m(&self) -> f64 {
        let Some(slots) = self.node.slots() else {
            return f64::INFINITY;
        };
        let errors = slot_errors(&self.truth(), &slots, self.node.now());
        // A follower that the truth does not know is as far away as can be.
        if errors.len() == slots.slots.len() {
            errors.into_iter().fold(0.0, f64::max)
        } else {
            f64::INFINITY
        }
    }

    /// Notes how far the farthest vehicle is from its slot now; gives it in metres.
    pub fn slots_reached(&self, shape: &str) -> f64 {
        let worst_m = self.farthest_from_slot_m();
        self.figures.lock().slots.push((shape.to_owned(), worst_m));
        worst_m
    }

    /// Notes whose gimbals are to be on the leader.
    pub fn expect_gimbals(&self, leader: VehicleId, observers: Vec<VehicleId>) {
        let from_s = self.truth().time_s + pointing::TURNING_S;
        self.figures.lock().looks = Some(pointing::Looks {
            leader,
            observers,
            from_s,
        });
    }

    /// Notes the spots the vehicles are to land on.
    pub fn expect_landings(&self, landings: &[Landing]) {
        self.figures.lock().landings = landings.to_vec();
    }
}

/// One look at the truth.
fn look(figures: &mut Figures, truth: &TruthFrame, node: &NodeHandle) {
    figures.note_look(Instant::now());
    watch_distances(figures, truth);
    let judged = !figures.is_disturbed();
    if judged {
        pointing::watch(figures, truth);
    }
    if !figures.airborne || !figures.landings.is_empty() {
        return;
    }
    watch_heights(figures, truth);
    if !judged {
        figures.steady_since_s = None;
        return;
    }
    for vehicle in node
        .snapshot()
        .vehicles
        .iter()
        .filter(|v| v.flight_state.is_available_in_air())
    {
        figures.filtered.0 += 1;
        figures.filtered.1 += u64::from(vehicle.avoiding.as_ref().is_some_and(|a| a.because.is_some()));
    }
    let now = node.now();
    let Some(slots) = node.slots().filter(|s| now.seconds_since(s.settled_at) > 1.0) else {
        figures.steady_since_s = None;
        return;
    };
    let Some((velocity, acceleration)) = anchor_motion(truth, &slots) else {
        return;
    };
    let speed_m_s = velocity.xy().norm();
    let at_speed = (speed_m_s - figures.cruise_m_s).abs() < AT_SPEED_M_S;
    let turning = slots.anchor.heading_rate_rad_s.abs() > STRAIGHT_RAD_S || turns(&velocity, &acceleration);
    let errors = slot_errors(truth, &slots, now);
    if turning && speed_m_s > UNDER_WAY_M_S {
        figures.steady_since_s = None;
        errors.into_iter().for_each(|e| figures.turning.add(e));
    } else if at_speed {
        let since_s = *figures.steady_since_s.get_or_insert(truth.time_s);
        if truth.time_s - since_s > STEADY_AFTER_S {
            errors.into_iter().for_each(|e| figures.straight.add(e));
        }
    } else {
        figures.steady_since_s = None;
    }
}

/// How the anchor really moves: the true leader, or what has no truth but itself.
fn anchor_motion(truth: &TruthFrame, slots: &FormationSlots) -> Option<(Vector3<f64>, Vector3<f64>)> {
    match slots.leader {
        Some(leader) => vehicle(truth, leader).map(|v| (v.velocity.vector(), v.acceleration.vector())),
        None => Some((slots.anchor.velocity.vector(), slots.anchor.acceleration.vector())),
    }
}

/// Whether the anchor's own course changes, from its lateral acceleration: a fixed heading turns with its route all the same.
fn turns(velocity: &Vector3<f64>, acceleration: &Vector3<f64>) -> bool {
    let speed_m_s = velocity.xy().norm();
    let lateral_m_s2 = velocity.xy().perp(&acceleration.xy()) / speed_m_s.max(UNDER_WAY_M_S);
    speed_m_s > UNDER_WAY_M_S && (lateral_m_s2 / speed_m_s).abs() > 0.15
}

/// Who was up and comes down before the landing.
fn watch_heights(figures: &mut Figures, truth: &TruthFrame) {
    for vehicle in truth.vehicles.iter().filter(|v| v.alive) {
        let id = vehicle.system_id;
        if !vehicle.touches_ground {
            figures.up.insert(id);
        } else if figures.up.contains(&id) && !figures.excused.contains(&id) && !figures.may_land.contains(&id) {
            figures.came_down.insert(id);
        }
    }
}

fn watch_distances(figures: &mut Figures, truth: &TruthFrame) {
    let alive: Vec<&VehicleTruth> = truth.vehicles.iter().filter(|v| v.alive).collect();
    for (i, a) in alive.iter().enumerate() {
        for b in alive.iter().skip(i + 1) {
            if a.touches_ground && b.touches_ground {
                continue;
            }
            let distance_m = a.position.distance_m(&b.position);
            if figures
                .smallest_distance
                .is_none_or(|(smallest, ..)| distance_m < smallest)
            {
                figures.smallest_distance = Some((distance_m, a.system_id, b.system_id));
                let place = |v: &VehicleTruth| {
                    let p = &v.position;
                    format!(
                        "{} at {:.1}, {:.1}, {:.1} m",
                        v.system_id, p.north_m, p.east_m, -p.down_m
                    )
                };
                let (a, b, at_s) = (place(a), place(b), truth.time_s);
                figures.nearest = format!("{distance_m:.2} m at {at_s:.1} s: {a}; {b} (north, east, height)");
            }
        }
    }
}

/// Each follower's true distance from its slot behind the true leader, or about the anchor, in metres.
pub fn slot_errors(truth: &TruthFrame, slots: &FormationSlots, now: skein_domain::NodeTime) -> Vec<f64> {
    let age_s = now.seconds_since(slots.anchor.time);
    let carried_on = || slots.anchor.position.after(&slots.anchor.velocity, age_s);
    let base = match slots.leader {
        Some(leader) => vehicle(truth, leader).map(|v| v.position),
        None => Some(carried_on()),
    };
    let Some(base) = base else { return Vec::new() };
    let heading_rad = wrap_angle_rad(slots.anchor.heading_rad + slots.anchor.heading_rate_rad_s * age_s);
    slots
        .slots
        .iter()
        .filter_map(|(id, slot)| {
            let follower = vehicle(truth, *id)?;
            let offset = transition::sample(slot, now).offset;
            Some(follower.position.distance_m(&base.moved(offset.rotated(heading_rad))))
        })
        .collect()
}

/// In the demonstration a vehicle's id is its system id.
pub fn vehicle(truth: &TruthFrame, id: VehicleId) -> Option<&VehicleTruth> {
    u8::try_from(id.0)
        .ok()
        .and_then(|system_id| truth.vehicle(system_id))
        .filter(|v| v.alive)
}

/// Horizontal distance of each landed vehicle from its spot in metres, by vehicle; infinite for one that is not down.
pub fn landing_errors(truth: &TruthFrame, landings: &[Landing]) -> Vec<(VehicleId, f64)> {
    landings
        .iter()
        .map(|landing| {
            let error_m = vehicle(truth, landing.vehicle)
                .filter(|v| is_down(v))
                .map_or(f64::INFINITY, |v| {
                    SwarmFrame::new(landing.place)
                        .position(&v.geodetic)
                        .vector()
                        .xy()
                        .norm()
                });
            (landing.vehicle, error_m)
        })
        .collect()
}

/// Whether it stands on the ground, disarmed, and knows it.
pub fn is_down(vehicle: &VehicleTruth) -> bool {
    vehicle.touches_ground && !vehicle.armed && vehicle.landed == LandedState::OnGround
}

/// Changes of mode that nobody had planned, in words, with the system id.
pub fn unplanned_mode_changes(truth: &TruthFrame) -> Vec<(u8, String)> {
    let mut found = Vec::new();
    for vehicle in &truth.vehicles {
        for change in vehicle.mode_changes.iter() {
            if matches!(
                change.cause,
                ModeCause::Failsafe | ModeCause::Recovered | ModeCause::Pilot | ModeCause::Rebooted
            ) {
                let (id, at_s, cause) = (vehicle.system_id, change.time_s, change.cause);
                let text = format!(
                    "system id {id} at {at_s:.1} s: {} to {} ({cause:?})",
                    change.from, change.to
                );
                found.push((id, text));
            }
        }
    }
    found
}
