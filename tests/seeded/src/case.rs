//! A case: everything that is drawn from a seed before the flight begins.
//!
//! Must never do: draw what no swarm could keep (said where it is drawn), or leave out what it should.

pub(crate) mod asks;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::{FormationRequest, VehicleId};
use skein_sim::{Airframe, NoiseSettings, WindSettings};

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// This formation.
    Form(FormationRequest),
    /// The leader flies a route: these legs from where it is then (metres north, east, down), this speed, these corners.
    Route {
        /// The legs.
        legs: Vec<Vector3<f64>>,
        /// Speed in metres per second.
        speed_m_s: f64,
        /// Radius of the corners in metres.
        corner_radius_m: f64,
    },
}

/// When it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum When {
    /// So long after the former change should be complete, in seconds.
    Settled(f64),
    /// In the middle of the former change: at this share of it.
    Midway(f64),
}

/// One step of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightStep {
    /// When.
    pub when: When,
    /// What.
    pub ask: Ask,
}

/// How a vehicle stops to answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fate {
    /// Its link is dead; it stops and hovers.
    Hovers,
    /// Its link is dead; it flies on for a second, then stops and hovers.
    FliesOn,
    /// Its link is dead; it drifts with the wind.
    Drifts,
    /// It falls out of the sky.
    Falls,
}

/// How a vehicle leaves the swarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Leave {
    /// It does not answer any more.
    Lost(Fate),
    /// An operator sends it somewhere: so far from where it is, in metres north, east, down.
    Called(Vector3<f64>),
    /// An operator sends it back to where it began, straight through whoever is on the way.
    Home,
}

/// An aircraft that is tracked and does not give way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foreign {
    /// Where it is when the flight begins.
    pub position: Vector3<f64>,
    /// Its velocity.
    pub velocity: Vector3<f64>,
}

/// Something that moves and is told of: formations may follow it. It goes along a line, stops, and is not told of any more some time later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// Where it is when the flight begins.
    pub position: Vector3<f64>,
    /// Its velocity until it stops.
    pub velocity: Vector3<f64>,
    /// When it stops, in seconds.
    pub stops_s: f64,
    /// How often it is told of, per second.
    pub rate_hz: f64,
    /// Whether its velocity is told too.
    pub tells_velocity: bool,
}

/// What one vehicle can do, where not all can do the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ability {
    /// Largest speed in metres per second.
    pub speed_m_s: f64,
    /// Largest climb rate in metres per second.
    pub climb_m_s: f64,
    /// Largest descent rate in metres per second.
    pub descent_m_s: f64,
    /// Largest planned acceleration in metres per second squared.
    pub acceleration_m_s2: f64,
}

/// A volume to be kept out of: an upright prism over a regular polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closed {
    /// Its middle, north and east in metres.
    pub middle_m: [f64; 2],
    /// Its radius in metres.
    pub radius_m: f64,
    /// How many corners it has.
    pub corners: usize,
    /// From this height above the origin in metres.
    pub floor_m: f64,
    /// To this height.
    pub ceiling_m: f64,
}

/// A fence: about the start, with so many corners cut off, and a ceiling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box2 {
    /// Half its length along north in metres.
    pub north_m: f64,
    /// Half its length along east in metres.
    pub east_m: f64,
    /// Its ceiling above the origin in metres.
    pub ceiling_m: f64,
    /// A corner that is cut out of it, as shares of its sides: then it is not convex.
    pub notch: Option<[f64; 2]>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The seed it was drawn from.
    pub seed: u64,
    /// Where each vehicle hovers at the beginning; ids from 1 in this order.
    pub starts: Vec<Vector3<f64>>,
    /// Yaw of each.
    pub yaws_rad: Vec<f64>,
    /// Vehicles that are still climbing, and when each is up, in seconds.
    pub joins: Vec<(VehicleId, f64)>,
    /// Vehicles that leave, when, how.
    pub leaves: Vec<(VehicleId, f64, Leave)>,
    /// Wind.
    pub wind: WindSettings,
    /// Errors of the estimates.
    pub noise: NoiseSettings,
    /// Shortest delay of each vehicle's telemetry in seconds.
    pub latencies_s: Vec<f64>,
    /// Share of messages lost in each direction.
    pub loss: f64,
    /// The fence.
    pub fence: Option<Box2>,
    /// Volumes to be kept out of.
    pub closed: Vec<Closed>,
    /// What each can do; none if all are alike.
    pub abilities: Vec<Ability>,
    /// Others, who do not give way.
    pub foreign: Vec<Foreign>,
    /// What formations may follow.
    pub moving: Moving,
    /// What is asked for, one after the other.
    pub steps: Vec<FlightStep>,
    /// What kind of vehicles they are.
    pub airframe: Airframe,
}

/// Vehicles that hover at the start are at least so far apart, in metres: nearer than the radius, they could not be kept apart.
const START_SPACING_M: f64 = 5.0;
/// How far a start may be from the middle of its square, in metres along each axis.
const START_JITTER_M: f64 = 0.7;

impl Case {
    /// Draws the case of a seed.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rng = &mut rng;
        // Log-uniform from 2 to 200, and small ones more often.
        let share: f64 = rng.random_range(0.0_f64..1.0).powf(1.5);
        let count = (2.0 * 100.0_f64.powf(share)).round() as usize;
        let height_m = if rng.random_bool(0.2) {
            rng.random_range(5.0..15.0)
        } else {
            rng.random_range(15.0..40.0)
        };
        let starts = starts(count, height_m, rng);
        let yaws_rad = (0..count).map(|_| rng.random_range(-3.0..3.0)).collect();
        let course = rng.random_range(0.0..std::f64::consts::TAU);
        let wind_m_s = rng.random_range(0.0..8.0);
        let wind = WindSettings {
            mean_north_m_s: wind_m_s * f64::cos(course),
            mean_east_m_s: wind_m_s * f64::sin(course),
            gust_m_s: rng.random_range(0.0..1.5),
            gust_time_s: rng.random_range(1.0..5.0),
        };
        let noise = noise(rng);
        let slowest_s: f64 = rng.random_range(0.03..0.15);
        let latencies_s = (0..count).map(|_| rng.random_range(0.02..=slowest_s)).collect();
        let loss = [0.0, 0.05, 0.2][rng.random_range(0..3)];
        let reserve = reserve(count, rng);
        let leaves = leaves(count, reserve.len(), rng);
        let fence = rng.random_bool(0.5).then(|| fence(&starts, height_m, rng));
        let others = if rng.random_bool(0.15) {
            rng.random_range(1..=3)
        } else {
            0
        };
        let foreign = (0..others).map(|_| foreign(&starts, height_m, rng)).collect();
        let closed = closed(&starts, height_m, rng);
        let abilities = abilities(count, rng);
        let moving = moving(height_m, rng);
        let steps = asks::draw(count, height_m, rng);
        let airframe = if rng.random_bool(0.2) {
            Airframe::Sih
        } else {
            Airframe::Quadrotor
        };
        let wind = pulling_alike(wind, airframe);
        Self {
            seed,
            starts,
            yaws_rad,
            joins: reserve,
            leaves,
            wind,
            noise,
            latencies_s,
            loss,
            fence,
            closed,
            abilities,
            foreign,
            moving,
            steps,
            airframe,
        }
    }
}

/// Wind that pulls at a vehicle of this kind as it would at the usual one: more, where the drag is four times as strong, no tilt could hold.
fn pulling_alike(wind: WindSettings, airframe: Airframe) -> WindSettings {
    let share = Airframe::Quadrotor.response().drag_per_s / airframe.response().drag_per_s;
    WindSettings {
        mean_north_m_s: share * wind.mean_north_m_s,
        mean_east_m_s: share * wind.mean_east_m_s,
        gust_m_s: share * wind.gust_m_s,
        ..wind
    }
}

/// What a vehicle does not know of where it is.
fn noise(rng: &mut ChaCha8Rng) -> NoiseSettings {
    let wander_m = rng.random_range(0.02..0.15);
    NoiseSettings {
        wander_horizontal_m: wander_m,
        wander_vertical_m: wander_m,
        // What the filter takes for the bound of a position's error, without the jitter.
        wander_limit_m: rng.random_range(0.05..0.27),
        wander_time_s: rng.random_range(8.0..60.0),
        jitter_m: rng.random_range(0.0..0.012),
        velocity_jitter_m_s: rng.random_range(0.0..0.05),
    }
}

/// Places on a square grid, not quite in its middle points.
fn starts(count: usize, height_m: f64, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let side = (count as f64).sqrt().ceil() as usize;
    let spacing_m = rng.random_range(START_SPACING_M + 2.0 * START_JITTER_M..10.0);
    let middle = 0.5 * (side as f64 - 1.0);
    (0..count)
        .map(|i| {
            let (row, column) = ((i / side) as f64 - middle, (i % side) as f64 - middle);
            let mut draw = || rng.random_range(-START_JITTER_M..START_JITTER_M);
            let jitter = Vector3::new(draw(), draw(), draw());
            Vector3::new(row * spacing_m, column * spacing_m, -height_m) + jitter
        })
        .collect()
}

/// The last few of the vehicles come up later.
fn reserve(count: usize, rng: &mut ChaCha8Rng) -> Vec<(VehicleId, f64)> {
    if count < 3 || rng.random_bool(0.5) {
        return Vec::new();
    }
    let most = (count / 3).min(5);
    let late = rng.random_range(1..=most);
    (count - late..count)
        .map(|i| (id_of(i), rng.random_range(3.0..40.0)))
        .collect()
}

/// Some of the others leave; two at least stay.
fn leaves(count: usize, reserve: usize, rng: &mut ChaCha8Rng) -> Vec<(VehicleId, f64, Leave)> {
    let could = count.saturating_sub(reserve + 2).min(1 + count / 8).min(8);
    if could == 0 || rng.random_bool(0.35) {
        return Vec::new();
    }
    let mut leaves: Vec<(VehicleId, f64, Leave)> = Vec::new();
    for _ in 0..rng.random_range(1..=could) {
        // The first vehicle leads as long as nobody is asked for: it is lost as often as all others together.
        let who = if rng.random_bool(0.3) {
            0
        } else {
            rng.random_range(0..count - reserve)
        };
        let id = id_of(who);
        if leaves.iter().any(|(known, ..)| *known == id) {
            continue;
        }
        let leave = match rng.random_range(0..7) {
            0 => Leave::Lost(Fate::Hovers),
            1 | 2 => Leave::Lost(Fate::FliesOn),
            3 => Leave::Lost(Fate::Drifts),
            4 => Leave::Lost(Fate::Falls),
            5 => Leave::Home,
            _ => Leave::Called(Vector3::new(
                rng.random_range(-30.0..30.0),
                rng.random_range(-30.0..30.0),
                rng.random_range(-15.0..0.0),
            )),
        };
        leaves.push((id, rng.random_range(3.0..45.0), leave));
    }
    leaves
}

/// About all starts, sometimes with little room to spare.
fn fence(starts: &[Vector3<f64>], height_m: f64, rng: &mut ChaCha8Rng) -> Box2 {
    let reach = |axis: usize| starts.iter().map(|s| s[axis].abs()).fold(0.0, f64::max);
    let mut beyond_m = || rng.random_range(6.0_f64..120.0);
    let mut fence = Box2 {
        north_m: reach(0) + beyond_m(),
        east_m: reach(1) + beyond_m(),
        ceiling_m: height_m + 0.5 * beyond_m(),
        notch: rng
            .random_bool(0.3)
            .then(|| [rng.random_range(0.05..0.4), rng.random_range(0.05..0.4)]),
    };
    // Nobody begins in the corner that is cut out.
    let cuts_off = |[of_north, of_east]: &[f64; 2]| {
        let (north_m, east_m) = (fence.north_m * (1.0 - of_north), fence.east_m * (1.0 - of_east));
        let is_in = |s: &Vector3<f64>| s.x > north_m - OFF_NOTCH_M && s.y > east_m - OFF_NOTCH_M;
        starts.iter().any(is_in)
    };
    if fence.notch.as_ref().is_some_and(cuts_off) {
        fence.notch = None;
    }
    fence
}

/// Everyone begins at least so far from a corner that is cut out, in metres.
const OFF_NOTCH_M: f64 = 3.0;

/// Up to two, in three flights of ten, off the place where all begin, some of them from the ground up, some to be flown under.
fn closed(starts: &[Vector3<f64>], height_m: f64, rng: &mut ChaCha8Rng) -> Vec<Closed> {
    let count = if rng.random_bool(0.3) {
        rng.random_range(1..=2)
    } else {
        0
    };
    let reach_m = starts.iter().map(|s| s.xy().norm()).fold(0.0, f64::max);
    let one = |rng: &mut ChaCha8Rng| {
        let radius_m = rng.random_range(4.0..25.0);
        let bearing: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let away_m = reach_m + radius_m + rng.random_range(6.0..50.0);
        Closed {
            middle_m: [bearing.cos() * away_m, bearing.sin() * away_m],
            radius_m,
            corners: rng.random_range(3..9),
            floor_m: if rng.random_bool(0.7) {
                0.0
            } else {
                height_m + rng.random_range(-10.0..10.0)
            },
            ceiling_m: height_m + rng.random_range(11.0..40.0),
        }
    };
    (0..count).map(|_| one(rng)).collect()
}

/// In a quarter of the flights not all can do the same.
fn abilities(count: usize, rng: &mut ChaCha8Rng) -> Vec<Ability> {
    if !rng.random_bool(0.25) {
        return Vec::new();
    }
    let one = |rng: &mut ChaCha8Rng| Ability {
        speed_m_s: rng.random_range(4.0..12.0),
        climb_m_s: rng.random_range(0.8..2.5),
        descent_m_s: rng.random_range(0.7..1.5),
        acceleration_m_s2: rng.random_range(1.0..2.5),
    };
    let kinds: Vec<Ability> = (0..rng.random_range(2..=3)).map(|_| one(rng)).collect();
    (0..count).map(|_| kinds[rng.random_range(0..kinds.len())]).collect()
}

/// From near the start, at the height of the swarm.
fn moving(height_m: f64, rng: &mut ChaCha8Rng) -> Moving {
    let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
    let speed_m_s = rng.random_range(0.0..5.0);
    Moving {
        position: Vector3::new(
            rng.random_range(-20.0..20.0),
            rng.random_range(-20.0..20.0),
            -height_m - rng.random_range(0.0..5.0),
        ),
        velocity: Vector3::new(course.cos(), course.sin(), 0.0) * speed_m_s,
        stops_s: rng.random_range(10.0..50.0),
        rate_hz: rng.random_range(1.0..10.0),
        tells_velocity: rng.random_bool(0.5),
    }
}

/// Through the middle of the swarm's start at its height or near it, seen long before.
fn foreign(starts: &[Vector3<f64>], height_m: f64, rng: &mut ChaCha8Rng) -> Foreign {
    let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
    let speed_m_s = rng.random_range(3.0..8.0);
    let climb = if rng.random_bool(0.3) {
        rng.random_range(-0.1..0.1)
    } else {
        0.0
    };
    let velocity = Vector3::new(course.cos(), course.sin(), climb) * speed_m_s;
    let reach = starts.iter().map(|s| s.xy().norm()).fold(0.0, f64::max);
    let middle = Vector3::new(rng.random_range(-10.0..10.0), rng.random_range(-10.0..10.0), -height_m);
    let at_s = (reach + 60.0) / speed_m_s + rng.random_range(0.0..20.0);
    Foreign {
        position: middle - velocity * at_s,
        velocity,
    }
}

/// The id of the vehicle at an index.
#[must_use]
pub fn id_of(index: usize) -> VehicleId {
    VehicleId(u16::try_from(index + 1).unwrap_or(u16::MAX))
}
