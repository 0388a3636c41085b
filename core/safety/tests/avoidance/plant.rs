//! Point masses under a control cascade like PX4's, in wind, with estimates that are wrong and states that arrive late or not at
//! all. Everything random comes from the seed. This is what the separation filter is judged against, so it knows the truth.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, Setpoint, VehicleId};
use skein_safety::avoidance::{
    AvoidanceSettings, Conditions, Cooperation, Neighbour, NeighbourId, Surroundings, filter,
};

pub const DT_S: f64 = 0.02;
/// States are sent every second period: 25 Hz.
const SENT_EVERY: usize = 2;
const HISTORY: usize = 32;
/// The others learn this long after it that a vehicle does not answer any more (its mode says so), in seconds.
const KNOWN_AFTER_S: f64 = 0.3;

/// What disturbs the flight.
#[derive(Debug, Clone, Copy)]
pub struct Disturbance {
    /// The estimate is at most this wrong, in metres.
    pub noise_m: f64,
    /// Peers' states are up to this old when they arrive, in seconds.
    pub latency_s: f64,
    /// This part of them does not arrive.
    pub loss: f64,
    pub wind_m_s: f64,
    pub gust_m_s: f64,
}

/// What a vehicle does that no longer answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Silent {
    FliesOn,
    Hovers,
    Drifts,
}

/// What is in the air.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// Filters its setpoints.
    Ours { goal: Vector3<f64> },
    /// Does so until that moment; the others learn of it a little later.
    Fails {
        goal: Vector3<f64>,
        at_s: f64,
        then: Silent,
    },
    /// Keeps a place in a formation that flies north.
    Slot { at: Vector3<f64>, speed_m_s: f64 },
    /// Flies straight on for ever; known as such.
    Foreign,
}

pub struct Craft {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub kind: Kind,
    acceleration: Vector3<f64>,
    integral: Vector3<f64>,
    error: Vector3<f64>,
    error_to: Vector3<f64>,
    velocity_error: Vector3<f64>,
    gust: Vector3<f64>,
    setpoint: Setpoint,
    sent: Vec<VehicleKinematics>,
}

/// What a flight came to.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    pub least_m: f64,
    pub least_at_s: f64,
    pub least_pair: (usize, usize),
    /// When the last one arrived for good; none if somebody did not.
    pub arrived_s: Option<f64>,
    pub not_arrived: usize,
    pub calls: usize,
    pub changed: usize,
    pub infeasible: usize,
    pub change_sum_m_s: f64,
    /// Sum of the steps of the commanded velocity from period to period, where filtered.
    pub step_sum_m_s: f64,
}

impl Outcome {
    pub fn mean_change_m_s(&self) -> f64 {
        self.change_sum_m_s / self.calls.max(1) as f64
    }
}

pub struct World {
    pub craft: Vec<Craft>,
    pub settings: AvoidanceSettings,
    pub disturbance: Disturbance,
    /// Acceleration every craft is capable of, in m/s².
    pub capable_m_s2: f64,
    wind: Vector3<f64>,
    rng: ChaCha8Rng,
    /// For each receiver and sender: which of the sent states came last, and how late they come.
    known: Vec<Option<usize>>,
    late: Vec<usize>,
    step: usize,
}

/// A vector drawn from a ball.
pub fn in_ball(rng: &mut ChaCha8Rng, radius: f64) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..=1.0));
        if v.norm() <= 1.0 {
            return v * radius;
        }
    }
}

impl World {
    pub fn new(starts: &[(Vector3<f64>, Vector3<f64>, Kind)], disturbance: Disturbance, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let course = rng.random_range(0.0..std::f64::consts::TAU);
        let craft: Vec<Craft> = starts
            .iter()
            .map(|(position, velocity, kind)| Craft {
                position: *position,
                velocity: *velocity,
                kind: *kind,
                acceleration: Vector3::zeros(),
                integral: Vector3::zeros(),
                error: in_ball(&mut rng, disturbance.noise_m),
                error_to: in_ball(&mut rng, disturbance.noise_m),
                velocity_error: Vector3::zeros(),
                gust: Vector3::zeros(),
                setpoint: Setpoint::hold((*position).into(), None),
                sent: Vec::new(),
            })
            .collect();
        let late_max = disturbance.latency_s / DT_S / SENT_EVERY as f64;
        let late = (0..craft.len() * craft.len())
            .map(|_| (rng.random_range(0.0..=1.0) * late_max).round() as usize)
            .collect();
        Self {
            known: vec![None; craft.len() * craft.len()],
            late,
            craft,
            settings: AvoidanceSettings {
                max_speed_m_s: 8.0,
                noise_m: disturbance.noise_m,
                ..AvoidanceSettings::default()
            },
            disturbance,
            capable_m_s2: 4.5,
            wind: Vector3::new(course.cos(), course.sin(), 0.0) * disturbance.wind_m_s,
            rng,
            step: 0,
        }
    }

    fn now(&self) -> NodeTime {
        NodeTime::from_seconds(100.0 + self.step as f64 * DT_S)
    }

    fn measured(&self, i: usize) -> VehicleKinematics {
        let craft = &self.craft[i];
        VehicleKinematics {
            position: (craft.position + craft.error).into(),
            velocity: (craft.velocity + craft.velocity_error).into(),
            yaw_rad: 0.0,
            measured: self.now(),
        }
    }

    /// Estimates wander, states are sent, some arrive.
    fn measure_and_send(&mut self) {
        let noise_m = self.disturbance.noise_m;
        for craft in &mut self.craft {
            if self.step.is_multiple_of(50) {
                craft.error_to = in_ball(&mut self.rng, noise_m);
            }
            craft.error += (craft.error_to - craft.error) * (DT_S / 0.5);
            let draw = in_ball(&mut self.rng, noise_m.min(0.3));
            craft.velocity_error += (draw - craft.velocity_error) * (DT_S / 0.1);
        }
        if !self.step.is_multiple_of(SENT_EVERY) {
            return;
        }
        let count = self.craft.len();
        for j in 0..count {
            let state = self.measured(j);
            self.craft[j].sent.push(state);
        }
        let last = self.craft[0].sent.len() - 1;
        for pair in 0..count * count {
            let arrives = self.rng.random_range(0.0..1.0) >= self.disturbance.loss;
            // What was sent before the flight began is known.
            let index = last.saturating_sub(self.late[pair].min(HISTORY));
            if arrives || self.known[pair].is_none() {
                self.known[pair] = Some(index);
            }
        }
    }

    fn neighbours(&self, i: usize, t_s: f64) -> Vec<Neighbour> {
        let count = self.craft.len();
        (0..count)
            .filter(|j| *j != i)
            .map(|j| {
                let craft = &self.craft[j];
                let state = craft.sent[self.known[i * count + j].expect("is known")];
                let (id, shares) = match craft.kind {
                    Kind::Ours { .. } | Kind::Slot { .. } => (NeighbourId::Vehicle(VehicleId(j as u16)), true),
                    Kind::Fails { at_s, .. } => (NeighbourId::Vehicle(VehicleId(j as u16)), t_s < at_s + KNOWN_AFTER_S),
                    Kind::Foreign => (NeighbourId::Foreign(j as u64), false),
                };
                Neighbour {
                    id,
                    position: state.position,
                    velocity: state.velocity,
                    measured: state.measured,
                    uncertainty_m: self.disturbance.noise_m,
                    cooperation: if shares {
                        Cooperation::Shares
                    } else {
                        Cooperation::DoesNot
                    },
                    airborne: true,
                }
            })
            .collect()
    }

    /// Every vehicle's setpoint for this period.
    fn control(&mut self, outcome: &mut Outcome) {
        let t_s = self.step as f64 * DT_S;
        for i in 0..self.craft.len() {
            let wanted = match self.craft[i].kind {
                Kind::Foreign => continue,
                Kind::Ours { goal } => Setpoint::hold(goal.into(), None),
                Kind::Slot { at, speed_m_s } => Setpoint {
                    velocity: Some(Vector3::new(speed_m_s, 0.0, 0.0).into()),
                    ..Setpoint::hold((at + Vector3::x() * (speed_m_s * t_s)).into(), None)
                },
                Kind::Fails { goal, at_s, then } => {
                    if t_s >= at_s {
                        self.fail(i, then);
                        continue;
                    }
                    Setpoint::hold(goal.into(), None)
                }
            };
            let own = self.measured(i);
            let neighbours = self.neighbours(i, t_s);
            let id = VehicleId(i as u16);
            let conditions = Conditions {
                surroundings: &Surroundings::new(&neighbours, &self.settings, self.now()),
                bounds: &[],
                settings: &self.settings,
            };
            let filtered = filter(id, &own, &wanted, &conditions, self.now());
            outcome.calls += 1;
            if let Some(change) = &filtered.change {
                outcome.changed += 1;
                outcome.infeasible += usize::from(!change.feasible);
                outcome.change_sum_m_s += change.by_m_s;
                if let (Some(old), Some(new)) = (self.craft[i].setpoint.velocity, filtered.setpoint.velocity) {
                    outcome.step_sum_m_s += (old.vector() - new.vector()).norm();
                }
            }
            self.craft[i].setpoint = filtered.setpoint;
        }
    }

    fn fail(&mut self, i: usize, then: Silent) {
        let craft = &mut self.craft[i];
        let place = (craft.position + craft.error).into();
        match then {
            Silent::FliesOn if craft.setpoint.position.is_some() || craft.setpoint.acceleration.is_none() => {
                // Marked with an acceleration, so that this happens once.
                craft.setpoint = Setpoint {
                    velocity: Some(craft.velocity.into()),
                    acceleration: Some(Vector3::zeros().into()),
                    ..Setpoint::default()
                };
            }
            Silent::Hovers if craft.setpoint.yaw_rad.is_none() => craft.setpoint = Setpoint::hold(place, Some(0.0)),
            Silent::Drifts => {
                craft.setpoint = Setpoint {
                    velocity: Some((self.wind * 0.4).into()),
                    ..Setpoint::default()
                };
            }
            _ => {}
        }
    }

    fn move_on(&mut self) {
        let keep = (-DT_S / 2.0_f64).exp();
        let spread = self.disturbance.gust_m_s * (1.0 - keep * keep).sqrt() * 1.7;
        let limits = self.settings;
        for craft in &mut self.craft {
            if matches!(craft.kind, Kind::Foreign) {
                craft.position += craft.velocity * DT_S;
                continue;
            }
            craft.gust = craft.gust * keep + in_ball(&mut self.rng, spread);
            let asked = asked_velocity(craft, &limits);
            let error = asked - (craft.velocity + craft.velocity_error);
            let forward = craft.setpoint.acceleration.unwrap_or_default().vector();
            let mut thrust = error * 2.2 + craft.integral + forward;
            let level = thrust.xy().norm();
            if level > self.capable_m_s2 {
                thrust.x *= self.capable_m_s2 / level;
                thrust.y *= self.capable_m_s2 / level;
            } else {
                craft.integral += error * (0.4 * DT_S);
            }
            thrust.z = thrust.z.clamp(-self.capable_m_s2, self.capable_m_s2);
            // Tilt and motors follow within 0.12 s.
            craft.acceleration += (thrust - craft.acceleration) * (DT_S / (0.12 + DT_S));
            let drag = (self.wind + craft.gust - craft.velocity) * 0.08;
            craft.velocity += (craft.acceleration + drag) * DT_S;
            craft.position += craft.velocity * DT_S;
        }
    }

    fn least_distance(&self, outcome: &mut Outcome) {
        for (i, a) in self.craft.iter().enumerate() {
            for (j, b) in self.craft.iter().enumerate().skip(i + 1) {
                let (fixed_a, fixed_b) = (self.has_failed(i), self.has_failed(j));
                if fixed_a && fixed_b {
                    // Nobody of the two could do anything about it.
                    continue;
                }
                let distance_m = (a.position - b.position).norm();
                if distance_m < outcome.least_m {
                    outcome.least_m = distance_m;
                    outcome.least_at_s = self.step as f64 * DT_S;
                    outcome.least_pair = (i, j);
                }
            }
        }
    }

    fn has_failed(&self, i: usize) -> bool {
        match self.craft[i].kind {
            Kind::Ours { .. } | Kind::Slot { .. } => false,
            Kind::Foreign => true,
            Kind::Fails { at_s, .. } => self.step as f64 * DT_S >= at_s,
        }
    }

    fn away(&self) -> usize {
        let is_away = |craft: &&Craft| match craft.kind {
            Kind::Ours { goal } => (goal - craft.position).norm() > 1.0,
            _ => false,
        };
        self.craft.iter().filter(is_away).count()
    }

    /// Flies until all are where they want to be, and two seconds more, or until the time is up.
    pub fn fly(&mut self, seconds: f64) -> Outcome {
        let mut outcome = Outcome {
            least_m: f64::INFINITY,
            ..Outcome::default()
        };
        let lasting = self
            .craft
            .iter()
            .any(|c| matches!(c.kind, Kind::Foreign | Kind::Slot { .. }));
        let mut there_since = None;
        for step in 0..(seconds / DT_S) as usize {
            self.step = step;
            self.measure_and_send();
            self.control(&mut outcome);
            self.move_on();
            self.least_distance(&mut outcome);
            outcome.not_arrived = self.away();
            // Foreign ones pass about eight seconds after the start.
            if outcome.not_arrived > 0 || lasting && step < 600 {
                there_since = None;
                continue;
            }
            let since = *there_since.get_or_insert(step);
            if step > since + 100 {
                outcome.arrived_s = Some(since as f64 * DT_S);
                break;
            }
        }
        outcome
    }
}

/// What PX4's position control makes of the setpoint: see `core/sim` for the same in full.
fn asked_velocity(craft: &Craft, limits: &AvoidanceSettings) -> Vector3<f64> {
    let mut asked = craft.setpoint.velocity.map_or_else(Vector3::zeros, |v| v.vector());
    if let Some(place) = craft.setpoint.position {
        asked += (place.vector() - craft.position - craft.error) * 0.95;
    }
    let level = asked.xy().norm();
    if level > limits.max_speed_m_s {
        asked.x *= limits.max_speed_m_s / level;
        asked.y *= limits.max_speed_m_s / level;
    }
    asked.z = asked.z.clamp(-limits.max_climb_m_s, limits.max_descent_m_s);
    asked
}
