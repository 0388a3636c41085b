//! The flight: time steps, and everything in its turn as in a node.
//!
//! One control period: the air moves, states are sent and heard, all vehicles are put into one picture, the coordinator watches (and
//! reviews, every fifth period), each vehicle's model is asked and its setpoint steered.

use crate::case::{Ask, Case, FlightStep, Foreign, Leave, When};
use crate::craft::Craft;
use crate::ground::Ground;
use crate::judge::Judge;
use crate::outcome::Outcome;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_config::NodeConfig;
use skein_coordination::neighbours;
use skein_domain::payload::Track;
use skein_domain::{BreachAction, NodeTime, Route, VehicleCommand, ZoneKind};
use skein_safety::avoidance::Surroundings;
use skein_safety::{Fence, Fences, Gate, Limits, Zone};
use skein_sim::vehicle::plant::Air;
use skein_view::PeerSnapshot;

/// The control period in seconds, and how many steps the plants take in it.
const PERIOD_S: f64 = 0.02;
const STEPS: u32 = 5;
/// The coordinator reviews every so many periods.
const REVIEW_EVERY: u64 = 5;
/// Node time at the beginning, in seconds: nothing may hang on its being zero.
const BEGINS_S: f64 = 100.0;
/// When everything asked for should be flown, so long is left for everyone to come to rest, in seconds.
const SETTLING_S: f64 = 180.0;
/// So long everyone must be in place for it to count, in seconds.
const FOR_GOOD_S: f64 = 4.0;
/// A formation whose outermost vehicle is carried round faster than this turns, in metres per second.
const TURNS_M_S: f64 = 0.01;
/// No flight takes longer, in seconds.
const LONGEST_S: f64 = 600.0;

/// A flight.
struct World<'a> {
    case: &'a Case,
    now_s: f64,
    ticks: u64,
    air: Air,
    wind: Vector3<f64>,
    crafts: Vec<Craft>,
    ground: Ground,
    judge: Judge,
    peers: PeerSnapshot,
    rng: ChaCha8Rng,
    next_step: usize,
    asked_s: f64,
    /// Since when nothing more is to come, and since when everyone is in place.
    quiet_since_s: Option<f64>,
    there_since_s: Option<f64>,
    trace: bool,
}

/// Flies a case to its end.
#[must_use]
pub fn fly(case: &Case, trace: bool) -> Outcome {
    let mut world = World::new(case, trace);
    while !world.is_over() {
        world.period();
    }
    let end_s = world.now_s;
    let arrived_s = world.there_since_s;
    let under_way = world.quiet_since_s.is_none();
    let mut outcome = world
        .judge
        .close(end_s, under_way, &world.crafts, &world.ground, &world.peers);
    outcome.arrived_s = arrived_s;
    outcome
}

/// The gate of a node with the default settings, and the fence of the case.
fn gate(case: &Case, config: &NodeConfig) -> Gate {
    let safety = &config.safety;
    let limits = Limits {
        max_speed_m_s: safety.max_speed_m_s,
        max_climb_m_s: safety.max_climb_m_s,
        max_descent_m_s: safety.max_descent_m_s,
        min_separation_m: safety.min_separation_m,
        separation_horizon_s: safety.separation_horizon_s,
    };
    Gate::new(limits, Fences::new(zones(case))).with_min_height(safety.min_height_m)
}

/// The fence and what is closed within it.
fn zones(case: &Case) -> Vec<Zone> {
    let zone = |kind, volume| Zone {
        name: "fence".to_owned(),
        kind,
        action: BreachAction::Hold,
        volume,
    };
    let inclusion = case.fence.and_then(|fence| {
        let (n, e) = (fence.north_m, fence.east_m);
        let mut corners = vec![[n, -e], [-n, -e], [-n, e]];
        match fence.notch {
            None => corners.push([n, e]),
            Some([of_n, of_e]) => {
                let (in_n, in_e) = (n * (1.0 - of_n), e * (1.0 - of_e));
                corners.extend([[in_n, e], [in_n, in_e], [n, in_e]]);
            }
        }
        Fence::new(corners, 2.0, fence.ceiling_m).ok()
    });
    let closed = case.closed.iter().filter_map(|closed| {
        let corner = |i: usize| {
            let at = std::f64::consts::TAU * i as f64 / closed.corners as f64;
            let [north_m, east_m] = closed.middle_m;
            [
                north_m + closed.radius_m * at.cos(),
                east_m + closed.radius_m * at.sin(),
            ]
        };
        Fence::new(
            (0..closed.corners).map(corner).collect(),
            closed.floor_m,
            closed.ceiling_m,
        )
        .ok()
    });
    let inclusion = inclusion.into_iter().map(|volume| zone(ZoneKind::Inclusion, volume));
    let closed = closed.map(|volume| zone(ZoneKind::Exclusion, volume));
    inclusion.chain(closed).collect()
}

impl<'a> World<'a> {
    fn new(case: &'a Case, trace: bool) -> Self {
        let config = NodeConfig::default();
        let now = NodeTime::from_seconds(BEGINS_S);
        let ground = Ground::new(config.clone(), gate(case, &config));
        Self {
            air: Air::new(&case.wind, case.seed ^ 0xa1),
            wind: Vector3::zeros(),
            crafts: (0..case.starts.len()).map(|i| Craft::new(case, i, now)).collect(),
            judge: Judge::new(case, &ground),
            ground,
            peers: PeerSnapshot::default(),
            rng: ChaCha8Rng::seed_from_u64(case.seed ^ 0x0c),
            now_s: 0.0,
            ticks: 0,
            next_step: 0,
            asked_s: 0.0,
            quiet_since_s: None,
            there_since_s: None,
            trace,
            case,
        }
    }

    fn now(&self) -> NodeTime {
        NodeTime::from_seconds(BEGINS_S + self.now_s)
    }

    fn tell(&mut self, what: impl Into<String>) {
        self.judge.outcome.story.push((self.now_s, what.into()));
    }

    fn period(&mut self) {
        self.now_s = (self.ticks + 1) as f64 * PERIOD_S;
        self.ticks += 1;
        let dt_s = PERIOD_S / f64::from(STEPS);
        for _ in 0..STEPS {
            self.wind = self.air.step(dt_s);
            for craft in self.crafts.iter_mut().filter(|c| c.flies()) {
                craft.plant.step(dt_s, &self.wind);
            }
        }
        let foreign = self.foreign();
        self.judge
            .watch(self.now_s, &self.crafts, &self.ground, &self.peers, &foreign);
        self.happen();
        let (now_s, now) = (self.now_s, self.now());
        for craft in &mut self.crafts {
            craft.failsafe(now_s, &self.wind);
            craft.exchange(now_s, now);
            craft.hear(now_s, now, &self.ground.config.link);
        }
        self.look();
        self.coordinate();
        self.control();
        for text in std::mem::take(&mut self.ground.story) {
            self.tell(text);
        }
        self.see_whether_there();
        if self.trace && self.ticks.is_multiple_of(25) {
            self.print();
        }
    }

    /// What was drawn to happen at this time.
    fn happen(&mut self) {
        let (from_s, to_s) = (self.now_s - PERIOD_S, self.now_s);
        let due = |at_s: f64| at_s > from_s && at_s <= to_s;
        for (id, at_s) in self.case.joins.clone() {
            if due(at_s) {
                self.tell(format!("{id} is up"));
                self.crafts[usize::from(id.0) - 1].climbing = false;
            }
        }
        for (id, at_s, leave) in self.case.leaves.clone() {
            let index = usize::from(id.0) - 1;
            if !due(at_s) {
                continue;
            }
            self.tell(format!("{id}: {leave:?}"));
            match leave {
                Leave::Lost(fate) => self.crafts[index].lose(fate, to_s),
                Leave::Called(_) | Leave::Home => {
                    let position = match leave {
                        Leave::Called(offset) => self.crafts[index].plant.position() + offset,
                        _ => self.case.starts[index],
                    }
                    .into();
                    let go = VehicleCommand::GoTo {
                        position,
                        yaw_rad: None,
                        speed_m_s: None,
                    };
                    let command = match self.ground.gate.command(&go, None) {
                        Ok(()) => go,
                        Err(_) => VehicleCommand::Hold,
                    };
                    self.ground.withdrawn.insert(id);
                    self.crafts[index].command(command);
                }
            }
        }
    }

    /// Where the others are.
    fn foreign(&self) -> Vec<Vector3<f64>> {
        let place = |foreign: &Foreign| foreign.position + foreign.velocity * self.now_s;
        self.case.foreign.iter().map(place).collect()
    }

    /// The picture of this period.
    fn look(&mut self) {
        let now = self.now();
        let entries: Vec<_> = self.crafts.iter().map(Craft::published).collect();
        let mut all: Vec<_> = entries.iter().flat_map(|e| neighbours::vehicle(e, now)).collect();
        for (track, (place, foreign)) in (1..).zip(self.foreign().into_iter().zip(&self.case.foreign)) {
            all.push(neighbours::track(&Track {
                track,
                position: place.into(),
                velocity: foreign.velocity.into(),
                time: now,
                error_m: None,
            }));
        }
        self.ground.see(&self.case.moving, self.now_s, PERIOD_S, now);
        let surroundings = Surroundings::new(&all, &self.ground.gate.avoidance(), now);
        let led = entries.iter().find_map(|e| e.anchor);
        let anchor = self.ground.anchor(led.as_ref(), now);
        self.peers = PeerSnapshot {
            made: now,
            entries,
            surroundings,
            anchor,
        };
    }

    fn coordinate(&mut self) {
        let now = self.now();
        let plan_s = self.rng.random_range(0.01..0.08);
        self.ground.take_plans(&mut self.crafts, &self.peers, now);
        self.ground.watch(&mut self.crafts, &self.peers, now);
        if self.ticks.is_multiple_of(REVIEW_EVERY) {
            self.ground.review(&self.crafts, &self.peers, plan_s, now);
        }
        let Some(step) = self.case.steps.get(self.next_step) else {
            return;
        };
        if !self.ground.is_planning() && self.is_due(step) {
            self.next_step += 1;
            self.asked_s = self.now_s;
            self.ask(&step.ask, plan_s, now);
        }
    }

    fn is_due(&self, step: &FlightStep) -> bool {
        let formation = self.ground.coordination.formation.as_ref();
        let (from_s, to_s) = formation.map_or((self.asked_s, self.asked_s), |f| {
            (f.decided.as_seconds() - BEGINS_S, f.settled_at.as_seconds() - BEGINS_S)
        });
        let at_s = match step.when {
            When::Settled(later_s) => to_s + later_s,
            When::Midway(share) => from_s + share * (to_s - from_s),
        };
        self.now_s >= at_s.max(self.asked_s + 0.5)
    }

    fn ask(&mut self, ask: &Ask, plan_s: f64, now: NodeTime) {
        match ask {
            Ask::Form(request) => {
                let what = format!(
                    "asked: {:?}, {:.1} m, {:?}, {:?}, {:?}",
                    request.shape, request.spacing_m, request.control, request.heading, request.anchor
                );
                self.tell(what);
                self.ground.ask(request.clone(), &self.peers, plan_s, now);
            }
            Ask::Route {
                legs,
                speed_m_s,
                corner_radius_m,
            } => {
                let formation = self.ground.coordination.formation.as_ref();
                let leader = formation.and_then(|f| f.leader).and_then(|id| self.peers.entry(id));
                let Some(start) = leader.and_then(|e| e.kinematics) else {
                    self.tell("a route, but nobody leads");
                    return;
                };
                let mut place = start.position.vector();
                let route = Route {
                    waypoints: legs
                        .iter()
                        .map(|leg| {
                            place += leg;
                            place.into()
                        })
                        .collect(),
                    speed_m_s: speed_m_s.min(self.ground.config.safety.max_speed_m_s),
                    corner_radius_m: *corner_radius_m,
                };
                self.ground.route(route, &mut self.crafts, &self.peers, now);
            }
        }
    }

    fn control(&mut self) {
        let (now_s, now) = (self.now_s, self.now());
        let Ground {
            gate, intent, config, ..
        } = &self.ground;
        let mut told = Vec::new();
        for craft in self.crafts.iter_mut().filter(|c| c.flies()) {
            let texts = craft.period(now_s, now, gate, &self.peers, intent, &config.link);
            told.extend(texts.into_iter().map(|text| format!("  {}: {text}", craft.id)));
        }
        for text in told {
            self.tell(text);
        }
    }

    /// Whether everyone is in place, once everything that was drawn has happened.
    fn see_whether_there(&mut self) {
        let formation = self.ground.coordination.formation.as_ref();
        let settled_s = formation.map_or(self.asked_s + 2.0, |f| f.settled_at.as_seconds() - BEGINS_S);
        let joins = self.case.joins.iter().map(|(_, at_s)| *at_s);
        let last_s = joins
            .chain(self.case.leaves.iter().map(|(_, at_s, _)| *at_s))
            .fold(0.0, f64::max)
            + 3.0;
        let on_route = self.ground.coordination.route.as_ref().is_some_and(|r| !r.finished);
        let led = || {
            self.peers
                .entries
                .iter()
                .find_map(|e| e.anchor.map(|a| a.heading_rate_rad_s))
        };
        let turning_rad_s = self.peers.anchor.map(|a| a.heading_rate_rad_s).or_else(led);
        // Who is far out is carried on by a turn that hardly shows near the anchor.
        let reach_m = formation.map_or(0.0, skein_coordination::Formation::reach_m);
        let moving = self.peers.anchor.is_some_and(|a| a.velocity.norm() > 0.01)
            || turning_rad_s.is_some_and(|rate| rate.abs() * reach_m.max(10.0) > TURNS_M_S);
        let quiet = self.next_step >= self.case.steps.len()
            && !self.ground.is_planning()
            && self.now_s > settled_s.max(last_s) + 1.0
            && !on_route
            && !moving;
        if !quiet {
            self.quiet_since_s = None;
            self.there_since_s = None;
            return;
        }
        self.quiet_since_s.get_or_insert(self.now_s);
        if self.judge.all_there(&self.crafts, &self.ground, &self.peers) {
            self.there_since_s.get_or_insert(self.now_s);
        } else {
            self.there_since_s = None;
        }
    }

    fn is_over(&self) -> bool {
        let since = |at_s: Option<f64>, s: f64| at_s.is_some_and(|at_s| self.now_s > at_s + s);
        since(self.there_since_s, FOR_GOOD_S) || since(self.quiet_since_s, SETTLING_S) || self.now_s > LONGEST_S
    }

    /// Everyone's state, for who looks into a failed seed.
    fn print(&self) {
        for craft in &self.crafts {
            let (p, v) = (craft.plant.position(), craft.plant.velocity());
            println!(
                "{:8.2} {:>4} at {:7.2} {:7.2} {:7.2}  v {:6.2} {:6.2} {:6.2}  {}{} {}",
                self.now_s,
                craft.id.to_string(),
                p.x,
                p.y,
                p.z,
                v.x,
                v.y,
                v.z,
                craft.entry.flight_state,
                if craft.answers() { "" } else { " (silent)" },
                craft.change.map_or_else(String::new, |c| format!(
                    "because {:?} {:.2} m away, by {:.2} m/s, feasible {}",
                    c.because, c.distance_m, c.by_m_s, c.feasible
                )),
            );
        }
    }
}
