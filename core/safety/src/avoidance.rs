//! The separation filter: changes a vehicle's setpoint as little as keeps it away from everything else in the air.
//!
//! Each vehicle filters its own setpoint from what it knows of the others. Two that both do so share the work; whoever does not
//! is avoided in full. The README says from which papers this comes, what is guaranteed and what is not.
//!
//! Must never do: remember anything between two calls, refuse (whoever cannot be kept apart is kept apart as far as possible, and
//! the answer says so), or ask for more speed than the limits.

mod flown;
mod nearest;
mod pair;
mod settings;
mod surroundings;

pub use settings::{AvoidanceSettings, AvoidanceSettingsError};
pub use surroundings::Surroundings;

use crate::HalfSpace;
use nalgebra::{Rotation3, Vector3};
use nearest::{Row, SpeedLimits, nearest};
use pair::{Demand, Own, demand};
use serde::{Deserialize, Serialize};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, Setpoint, VehicleId, VelocityNed};

/// Whom one may come too close to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NeighbourId {
    /// A vehicle of the swarm.
    Vehicle(VehicleId),
    /// Anything else: a track, an aircraft that reports itself. The number is the caller's.
    Foreign(u64),
}

/// Whether a neighbour does its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cooperation {
    /// It runs the same filter on fresh states and its autopilot does what it is told.
    Shares,
    /// Anything else: link lost, silent, flown by a pilot or a failsafe, faulted, or not ours.
    DoesNot,
    /// As such a one, in a place where it may come to be, and is not as far as is known: given way to in full, but nobody leaves a fence for it.
    MayCome,
}

/// Something else in the air, as last measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Who.
    pub id: NeighbourId,
    /// Where it was measured.
    pub position: PositionNed,
    /// How fast.
    pub velocity: VelocityNed,
    /// When.
    pub measured: NodeTime,
    /// How far that place may be wrong, in metres (a bound that is hardly ever exceeded); for something large, its half size on top.
    pub uncertainty_m: f64,
    /// Whether it does its part.
    pub cooperation: Cooperation,
    /// One on the ground is no obstacle to a vehicle in the air.
    pub airborne: bool,
}

/// What was changed, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// By how much the velocity that will be flown differs from the one that was wanted, in metres per second.
    pub by_m_s: f64,
    /// The neighbour whose demand the wanted setpoint broke most; none if it broke only the caller's own conditions.
    pub because: Option<NeighbourId>,
    /// Its present distance in metres; infinite without one.
    pub distance_m: f64,
    /// The distance that the wanted velocity would have come to within the horizon, in metres; infinite without a neighbour.
    pub predicted_m: f64,
    /// Whether all demands are kept. If not, this is what breaks them least.
    pub feasible: bool,
}

/// A setpoint after the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filtered {
    /// What to send: bit for bit the wanted one if nothing was changed.
    pub setpoint: Setpoint,
    /// What was changed.
    pub change: Option<Change>,
}

/// What a setpoint is filtered against.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// Everything in the air, prepared once for the period with the same settings and time.
    pub surroundings: &'a Surroundings,
    /// The caller's own conditions on the velocity.
    pub bounds: &'a [HalfSpace],
    /// What the filter may assume and demand.
    pub settings: &'a AvoidanceSettings,
}

/// Filters one setpoint.
///
/// The setpoint comes back as it is if it, or the own state, is not in numbers: the gate refuses such ones.
#[must_use]
pub fn filter(
    own: VehicleId,
    own_kinematics: &VehicleKinematics,
    wanted: &Setpoint,
    conditions: &Conditions<'_>,
    now: NodeTime,
) -> Filtered {
    let (surroundings, settings) = (conditions.surroundings, conditions.settings);
    let Some(own) = own_now(own, own_kinematics, wanted, settings, now) else {
        return unchanged(wanted);
    };
    let reach_m = reach_m(&own, surroundings, settings);
    let demands: Vec<Demand> = surroundings
        .near(&own.position, reach_m)
        .filter(|peer| is_on(settings) && peer.id != NeighbourId::Vehicle(own.id))
        .filter_map(|peer| demand(&own, peer, settings))
        .collect();
    decide(&own, wanted, &demands, conditions.bounds, settings)
}

/// The velocity without a place that flies the same as a setpoint with one, for a moment. `None` if that cannot be told.
#[must_use]
pub fn as_velocity(
    own: VehicleId,
    own_kinematics: &VehicleKinematics,
    wanted: &Setpoint,
    settings: &AvoidanceSettings,
    now: NodeTime,
) -> Option<Setpoint> {
    let own = own_now(own, own_kinematics, wanted, settings, now)?;
    Some(flown::setpoint(wanted, &own.wanted, &[]))
}

/// How much of the speed at which this filter lets two vehicles that share close they close at, as a share: above 1 it would change their
/// setpoints. Zero if they go past each other, or the filter is off; none if they are nearer to each other than it lets them be, however slow.
/// For planners, so that it seldom has to.
///
/// `apart` is where the other is from one of them, in metres, and `closing` the velocity of the one relative to the other, in metres per
/// second; their states are `age_s` old.
#[must_use]
pub fn used_share(
    apart: &Vector3<f64>,
    closing: &Vector3<f64>,
    age_s: f64,
    settings: &AvoidanceSettings,
) -> Option<f64> {
    if is_on(settings) {
        pair::used_share(apart, closing, age_s, settings)
    } else {
        Some(0.0)
    }
}

fn unchanged(wanted: &Setpoint) -> Filtered {
    Filtered {
        setpoint: *wanted,
        change: None,
    }
}

/// Whether others are looked at. Written so that a distance that is not a number turns that off like none.
fn is_on(settings: &AvoidanceSettings) -> bool {
    settings.min_separation_m > 0.0
}

/// The own vehicle now; none if that cannot be told.
fn own_now(
    id: VehicleId,
    kinematics: &VehicleKinematics,
    wanted: &Setpoint,
    settings: &AvoidanceSettings,
    now: NodeTime,
) -> Option<Own> {
    let usable = kinematics.position.is_finite() && kinematics.velocity.is_finite() && wanted.is_well_formed();
    if !usable {
        return None;
    }
    let age_s = surroundings::age_s(kinematics.measured, now);
    let velocity = kinematics.velocity.vector();
    let position = surroundings::carried_on(&kinematics.position.vector(), &velocity, age_s);
    Some(Own {
        id,
        wanted: flown::velocity(wanted, &position, settings, &speed_limits(settings)),
        position,
        velocity,
        goal: wanted.position.map(|goal| goal.vector()),
        uncertain_m: settings.noise_m + surroundings::unknown_m(age_s, settings.peer_acceleration_m_s2),
        age_s,
    })
}

fn speed_limits(settings: &AvoidanceSettings) -> SpeedLimits {
    SpeedLimits {
        horizontal_m_s: settings.max_speed_m_s,
        up_m_s: settings.max_climb_m_s,
        down_m_s: settings.max_descent_m_s,
    }
}

/// The speed limits, with the bounds straight up and down among them: nobody is pressed into the ground, whoever comes from above.
fn limits_within(settings: &AvoidanceSettings, bounds: &[HalfSpace]) -> SpeedLimits {
    let along = |z: f64, most_m_s: f64| {
        let same = bounds.iter().filter(|b| b.normal.z * z >= STRAIGHT);
        same.map(|b| b.limit_m_s.max(0.0)).fold(most_m_s, f64::min)
    };
    let limits = speed_limits(settings);
    SpeedLimits {
        up_m_s: along(-1.0, limits.up_m_s),
        down_m_s: along(1.0, limits.down_m_s),
        ..limits
    }
}

/// A direction whose vertical part is at least this is straight up or down.
const STRAIGHT: f64 = 1.0 - 1e-9;

/// Beyond this distance no sharing neighbour can demand anything.
fn reach_m(own: &Own, surroundings: &Surroundings, settings: &AvoidanceSettings) -> f64 {
    let (uncertain_m, age_s) = surroundings.worst();
    let fastest = surroundings.fastest_against_m_s(&own.velocity);
    pair::reach_m(own, fastest, uncertain_m, age_s, settings)
}

/// The wanted setpoint if it keeps all demands, else the nearest that does.
fn decide(
    own: &Own,
    wanted: &Setpoint,
    demands: &[Demand],
    bounds: &[HalfSpace],
    settings: &AvoidanceSettings,
) -> Filtered {
    let worst = demands
        .iter()
        .map(|demand| (demand.row.excess(&own.wanted), demand))
        .filter(|(excess, _)| *excess > 0.0)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let breaks_bound = |bound: &HalfSpace| bound.normal.dot(&own.wanted) > bound.limit_m_s;
    if worst.is_none() && !bounds.iter().any(breaks_bound) {
        return unchanged(wanted);
    }
    let rows: Vec<Row> = demands
        .iter()
        .map(|demand| demand.row)
        .chain(bounds.iter().filter_map(row_of))
        .collect();
    let limits = limits_within(settings, bounds);
    let mut answer = nearest(&own.wanted, &rows, &limits);
    if let Some(turned) = way_round(&own.wanted, &answer.velocity, demands) {
        answer = nearest(&turned, &rows, &limits);
    }
    Filtered {
        setpoint: flown::setpoint(wanted, &answer.velocity, &rows),
        change: Some(Change {
            by_m_s: (answer.velocity - own.wanted).norm(),
            because: worst.map(|(_, demand)| demand.id),
            distance_m: worst.map_or(f64::INFINITY, |(_, demand)| demand.distance_m),
            predicted_m: worst.map_or(f64::INFINITY, |(_, demand)| {
                demand.predicted_m(&own.wanted, settings.horizon_s)
            }),
            feasible: answer.feasible,
        }),
    }
}

/// How readily a condition of the caller yields: less than any neighbour that gives way itself, so that a crowd presses nobody out of a fence,
/// and more than one that does not.
const BOUND_YIELDS: f64 = 0.03;

/// A condition of the caller as a row; one that is not in numbers says nothing.
fn row_of(bound: &HalfSpace) -> Option<Row> {
    let length = bound.normal.norm();
    let row = Row {
        normal: bound.normal / length,
        bound: bound.limit_m_s / length,
        yields: BOUND_YIELDS,
    };
    (length > 0.0 && length.is_finite() && row.bound.is_finite()).then_some(row)
}

/// Who is held up turns to the right, the more the less of the way is left: two that stand before each other would otherwise stand
/// there for ever. All turn the same way, so that many who meet in one point go round it. Who is held up by somebody in its very place waits
/// there: going round would only stir up the others.
fn way_round(wanted: &Vector3<f64>, allowed: &Vector3<f64>, demands: &[Demand]) -> Option<Vector3<f64>> {
    let speed = wanted.norm();
    let mut stopping = demands
        .iter()
        .filter(|demand| demand.stops && demand.row.excess(wanted) > 0.0)
        .peekable();
    if speed < SLOW_M_S || stopping.peek().is_none() || stopping.any(|demand| demand.in_place) {
        return None;
    }
    let progress = allowed.dot(wanted) / (speed * speed);
    let held_up = ((FREE_PART - progress) / FREE_PART).clamp(0.0, 1.0);
    if held_up <= 0.0 {
        return None;
    }
    let level = wanted.x.hypot(wanted.y);
    let angle = held_up * TURN_MAX_RAD;
    if level > 0.3 * speed {
        return Some(Rotation3::from_axis_angle(&Vector3::z_axis(), angle) * wanted);
    }
    // Straight up or down there is no right: away over north for who climbs, over south for who descends.
    let side = Vector3::new(-wanted.z.signum(), 0.0, 0.0) * speed;
    Some(wanted * angle.cos() + side * angle.sin())
}

/// Slower wishes than this, in metres per second, are not worth a way round.
const SLOW_M_S: f64 = 0.4;
/// Who still gets this part of the wanted speed is not held up.
const FREE_PART: f64 = 0.6;
/// The most that a wish is turned, in radians.
const TURN_MAX_RAD: f64 = 1.3;

#[cfg(test)]
mod tests;
