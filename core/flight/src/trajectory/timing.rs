//! How long each leg takes: from the limits first, then again and again from what the trajectories turn out to need, and last scaled as
//! a whole so that nothing is above its limit.

use super::peaks::{Peaks, of_piece};
use super::sampling::{LONGEST_S, piece_at};
use super::spline::{Basis, Begin, through};
use super::{Journey, Smoothness, TrajectoryError};
use nalgebra::Vector3;
use skein_domain::{FlightLimits, TrajectoryPiece};

/// No leg is shorter, in seconds.
const SHORTEST_LEG_S: f64 = 0.1;
/// How often the legs' durations are adapted to what they need.
const ROUNDS: u32 = 30;
/// So many rounds in a row without getting better by half a percent are enough.
const PATIENCE: u32 = 3;
/// How often the whole is made slower until it is within the limits. From rest once is enough.
const SLOWER_ROUNDS: u32 = 40;
/// A leg swings out when it is farther from the straight way than this share of its length and so many metres.
const SWING_SHARE: f64 = 0.35;
const SWING_M: f64 = 2.0;
/// How often places are looked for at which stopping is better than passing.
const STOP_ROUNDS: u32 = 4;
/// So much above the start's own motion is allowed while it lasts: what a bound may be above the true peak.
const START_ALLOWANCE: f64 = 1.0011;
/// Times a first guess of the time to brake, tried in this order.
const BRAKING_FACTORS: [f64; 10] = [1.05, 1.3, 0.8, 1.7, 0.6, 2.4, 0.4, 3.5, 0.25, 0.15];

/// What was planned.
pub(super) struct Planned {
    /// Per vehicle.
    pub pieces: Vec<Vec<TrajectoryPiece>>,
    /// When the k-th waypoint is passed, in seconds.
    pub passes_s: Vec<f64>,
}

/// One vehicle while it is planned for.
struct TimedVehicle {
    limits: FlightLimits,
    begin: Begin,
    places: Vec<Vector3<f64>>,
    /// What it has at the start, a little above.
    allowed: Peaks,
    /// It brakes first, on this piece.
    braking: Option<TrajectoryPiece>,
    /// Per place, whether it stops there; at the last it does anyhow.
    stops: Vec<bool>,
}

/// Plans for all: passing the places where that goes well, stopping where not.
///
/// The smoothest way through places at given times may swing out far on a long leg beside a short one, for its smoothness is bought with
/// the time there is. Such places are stopped at. Stopping everywhere always works and is taken if it is quicker.
pub(super) fn together(journeys: &[Journey], smoothness: Smoothness) -> Result<Planned, TrajectoryError> {
    let mut vehicles = journeys
        .iter()
        .enumerate()
        .map(|(index, journey)| TimedVehicle::new(index, journey))
        .collect::<Result<Vec<_>, _>>()?;
    let unsolvable = TrajectoryError::TooLong { limit_s: LONGEST_S };
    let basis = Basis::new(smoothness).ok_or(unsolvable)?;
    let mut passing = None;
    for _ in 0..STOP_ROUNDS {
        let settled = settle(&vehicles, &basis)?;
        if !mend(&mut vehicles, &settled, smoothness)? {
            passing = Some(settled);
            break;
        }
    }
    let passes_somewhere = |v: &TimedVehicle| v.stops.iter().rev().skip(1).any(|stop| !stop);
    if passing.is_none() || vehicles.iter().any(passes_somewhere) {
        for vehicle in &mut vehicles {
            vehicle.stops.fill(true);
            if vehicle.sets_out_moving() {
                vehicle.brake(smoothness, 0).ok();
            }
        }
        let stopping = settle(&vehicles, &basis)?;
        if stopping.too_fast.is_empty() && passing.as_ref().is_none_or(|p| stopping.total_s() < 0.95 * p.total_s()) {
            passing = Some(stopping);
        }
    }
    let found = passing.ok_or(TrajectoryError::TooLong { limit_s: LONGEST_S })?;
    let passed_at = |at_s: &mut f64, duration_s: &f64| {
        *at_s += duration_s;
        Some(*at_s)
    };
    Ok(Planned {
        passes_s: found.durations_s.iter().scan(0.0, passed_at).collect(),
        pieces: found.pieces,
    })
}

/// Lets vehicles brake or stop where their way is not good yet; whether anything changed.
fn mend(vehicles: &mut [TimedVehicle], settled: &Settled, smoothness: Smoothness) -> Result<bool, TrajectoryError> {
    let mut mended = false;
    for (index, vehicle) in vehicles.iter_mut().enumerate() {
        let swinging = settled
            .pieces
            .get(index)
            .map_or_else(Vec::new, |pieces| vehicle.swinging(pieces));
        let too_fast = settled.too_fast.contains(&index);
        if vehicle.sets_out_moving() && (too_fast || swinging.first() == Some(&0)) {
            vehicle.brake(smoothness, index)?;
            mended = true;
            continue;
        }
        for leg in swinging {
            mended |= vehicle.stop_beside(leg, &settled.durations_s);
        }
        if too_fast {
            for place in 0..vehicle.places.len() {
                vehicle.stop_at(place);
            }
            mended = true;
        }
    }
    Ok(mended)
}

impl TimedVehicle {
    fn new(index: usize, journey: &Journey) -> Result<Self, TrajectoryError> {
        let Journey {
            start,
            waypoints,
            limits,
        } = journey;
        if waypoints.is_empty() {
            return Err(TrajectoryError::NoWaypoints { index });
        }
        if !limits.is_usable() {
            return Err(TrajectoryError::InvalidLimits { index });
        }
        if !(start.position.is_finite() && start.velocity.is_finite() && start.acceleration.is_finite()) {
            return Err(TrajectoryError::StartNotFinite { index });
        }
        let places: Vec<Vector3<f64>> = waypoints.iter().map(|w| w.vector()).collect();
        let mut at = start.position.vector();
        for (waypoint, place) in places.iter().enumerate() {
            // A day's flight at the speed of sound: beyond that it is a slip, and squares would overflow much later.
            let usable = (place - at).norm() < 3e7;
            if !usable {
                return Err(TrajectoryError::WaypointNotUsable { index, waypoint });
            }
            at = *place;
        }
        let state = Peaks::of_state(start);
        Ok(Self {
            stops: vec![false; places.len()],
            limits: *limits,
            begin: Begin {
                position: start.position.vector(),
                velocity: start.velocity.vector(),
                acceleration: start.acceleration.vector(),
            },
            places,
            allowed: Peaks {
                speed_m_s: state.speed_m_s * START_ALLOWANCE,
                climb_m_s: state.climb_m_s * START_ALLOWANCE,
                descent_m_s: state.descent_m_s * START_ALLOWANCE,
                acceleration_m_s2: state.acceleration_m_s2 * START_ALLOWANCE,
            },
            braking: None,
        })
    }

    /// A first guess of the legs' durations.
    fn first_guess(&self) -> Vec<f64> {
        let limits = &self.limits;
        std::iter::once(&self.begin.position)
            .chain(&self.places)
            .zip(&self.places)
            .map(|(from, to)| {
                let way = to - from;
                let vertical_s = if way.z < 0.0 {
                    -way.z / limits.max_climb_m_s
                } else {
                    way.z / limits.max_descent_m_s
                };
                let by_speed_s = 1.3 * (way.xy().norm() / limits.max_speed_m_s).max(vertical_s);
                by_speed_s.max((2.0 * way.norm() / limits.max_acceleration_m_s2).sqrt())
            })
            .collect()
    }

    /// Whether its trajectory begins with a motion that it has to take over.
    fn sets_out_moving(&self) -> bool {
        self.braking.is_none() && (self.begin.velocity.norm() > 0.0 || self.begin.acceleration.norm() > 0.0)
    }

    fn braking_s(&self) -> f64 {
        self.braking.as_ref().map_or(0.0, |piece| piece.duration_s)
    }

    /// Its pieces for these durations of the legs: one spline from stop to stop.
    fn pieces(&self, basis: &Basis, durations_s: &[f64]) -> Option<Vec<TrajectoryPiece>> {
        let at_rest = |position: Vector3<f64>| Begin {
            position,
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
        };
        let mut pieces: Vec<TrajectoryPiece> = self.braking.iter().cloned().collect();
        let mut begin = match &self.braking {
            Some(braking) => at_rest(piece_at(braking, braking.duration_s)[0]),
            None => self.begin,
        };
        let (mut places, mut times_s) = (Vec::new(), Vec::new());
        for (i, (place, duration_s)) in self.places.iter().zip(durations_s).enumerate() {
            let braked_s = if i == 0 { self.braking_s() } else { 0.0 };
            places.push(*place);
            times_s.push((duration_s - braked_s).max(SHORTEST_LEG_S));
            if self.stops.get(i) == Some(&true) || i + 1 == self.places.len() {
                pieces.extend(through(basis, &begin, &places, &times_s)?);
                begin = at_rest(*place);
                places.clear();
                times_s.clear();
            }
        }
        Some(pieces)
    }

    /// Per leg, how many times too fast it is.
    fn hastes(&self, pieces: &[TrajectoryPiece]) -> Vec<f64> {
        let none = Peaks::default();
        let of = |(i, piece): (usize, &TrajectoryPiece)| {
            let allowed = if i == 0 { &self.allowed } else { &none };
            of_piece(piece).haste(&self.limits, allowed)
        };
        // The piece on which it brakes was found to be within the limits and does not change.
        let skipped = usize::from(self.braking.is_some());
        pieces.iter().enumerate().skip(skipped).map(of).collect()
    }

    /// The legs that swing out farther from the straight way than a round corner needs. Looking closely is not needed: this only chooses
    /// among ways that are all within the limits.
    fn swinging(&self, pieces: &[TrajectoryPiece]) -> Vec<usize> {
        let mut from = match &self.braking {
            Some(braking) => piece_at(braking, braking.duration_s)[0],
            None => self.begin.position,
        };
        let mut swinging = Vec::new();
        let legs = pieces.iter().skip(usize::from(self.braking.is_some()));
        for (i, (piece, to)) in legs.zip(&self.places).enumerate() {
            let leg = to - from;
            let moving = if i == 0 && self.braking.is_none() {
                self.begin.velocity.norm_squared() / self.limits.max_acceleration_m_s2
            } else {
                0.0
            };
            let allowed_m = SWING_SHARE * leg.norm() + SWING_M + moving;
            let off_m = |share_of_time: f64| {
                let off = piece_at(piece, piece.duration_s * share_of_time)[0] - from;
                let share = (off.dot(&leg) / leg.norm_squared().max(1e-12)).clamp(0.0, 1.0);
                (off - leg * share).norm()
            };
            // Written so that what is not a number swings.
            if !(1..8).all(|k| off_m(f64::from(k) / 8.0) <= allowed_m) {
                swinging.push(i);
            }
            from = *to;
        }
        swinging
    }

    /// Stops at that end of a leg behind which the shorter leg lies: it is there that the velocity of a long one does not fit. Whether
    /// that is new.
    fn stop_beside(&mut self, leg: usize, durations_s: &[f64]) -> bool {
        let time_s = |leg: usize| durations_s.get(leg).copied().unwrap_or(f64::INFINITY);
        let before = leg.checked_sub(1);
        let before_s = before.map_or(f64::INFINITY, time_s);
        let after_s = if leg + 1 < self.places.len() {
            time_s(leg + 1)
        } else {
            f64::INFINITY
        };
        let first = if before_s < after_s { before } else { Some(leg) };
        let second = if before_s < after_s { Some(leg) } else { before };
        [first, second].into_iter().flatten().any(|at| self.stop_at(at))
    }

    /// Stops at an inner place; whether that is new.
    fn stop_at(&mut self, place: usize) -> bool {
        match self.stops.get_mut(place) {
            Some(stop @ false) if place + 1 < self.places.len() => {
                *stop = true;
                true
            }
            _ => false,
        }
    }

    /// Brakes before it sets out.
    fn brake(&mut self, smoothness: Smoothness, index: usize) -> Result<(), TrajectoryError> {
        let limits = &self.limits;
        let first_s = (1.9 * self.begin.velocity.norm() / limits.max_acceleration_m_s2).max(0.3);
        let within = |piece: &TrajectoryPiece| of_piece(piece).haste(limits, &self.allowed) <= 1.0;
        let found = BRAKING_FACTORS
            .into_iter()
            .map(|factor| braking(&self.begin, factor * first_s, smoothness))
            .find(within);
        self.braking = Some(found.ok_or(TrajectoryError::StartBeyondLimits { index })?);
        Ok(())
    }
}

/// Braking to rest over `duration_s`: the velocity is the smoothest polynomial from the start's to none.
fn braking(begin: &Begin, duration_s: f64, smoothness: Smoothness) -> TrajectoryPiece {
    // In powers of the share of time: what is left of the velocity, and of the acceleration times the duration.
    let (of_velocity, of_acceleration): ([f64; 6], [f64; 6]) = match smoothness {
        Smoothness::Jerk => ([1.0, 0.0, -3.0, 2.0, 0.0, 0.0], [0.0, 1.0, -2.0, 1.0, 0.0, 0.0]),
        Smoothness::Snap => ([1.0, 0.0, 0.0, -10.0, 15.0, -6.0], [0.0, 1.0, 0.0, -6.0, 8.0, -3.0]),
    };
    let axis = |axis: usize| -> Vec<f64> {
        let mut coefficients = vec![begin.position[axis]];
        let mut by_time = 1.0;
        for (power, (v, a)) in of_velocity.into_iter().zip(of_acceleration).enumerate() {
            let velocity = begin.velocity[axis] * v + begin.acceleration[axis] * duration_s * a;
            coefficients.push(velocity * by_time / (power as f64 + 1.0));
            by_time /= duration_s;
        }
        coefficients
    };
    TrajectoryPiece {
        duration_s,
        north: axis(0),
        east: axis(1),
        down: axis(2),
    }
}

/// What became of the legs' durations.
struct Settled {
    pieces: Vec<Vec<TrajectoryPiece>>,
    durations_s: Vec<f64>,
    /// Vehicles that are not within their limits.
    too_fast: Vec<usize>,
}

impl Settled {
    fn total_s(&self) -> f64 {
        self.durations_s.iter().sum()
    }
}

/// One look at all vehicles.
struct Look {
    pieces: Vec<Vec<TrajectoryPiece>>,
    /// Per leg, of the vehicle that needs most.
    legs: Vec<f64>,
    /// Per vehicle.
    vehicles: Vec<f64>,
}

impl Look {
    fn haste(&self) -> f64 {
        self.legs.iter().copied().fold(0.0, f64::max)
    }

    fn is_within(&self, vehicle: usize) -> bool {
        self.vehicles.get(vehicle).is_some_and(|haste| *haste <= 1.0)
    }
}

fn look(vehicles: &[TimedVehicle], basis: &Basis, durations_s: &[f64]) -> Result<Look, TrajectoryError> {
    let mut look = Look {
        pieces: Vec::with_capacity(vehicles.len()),
        legs: vec![0.0; durations_s.len()],
        vehicles: Vec::with_capacity(vehicles.len()),
    };
    for vehicle in vehicles {
        let own_s = durations_s.get(..vehicle.places.len()).unwrap_or(durations_s);
        let pieces = vehicle
            .pieces(basis, own_s)
            .ok_or(TrajectoryError::TooLong { limit_s: LONGEST_S })?;
        let hastes = vehicle.hastes(&pieces);
        look.legs
            .iter_mut()
            .zip(&hastes)
            .for_each(|(most, haste)| *most = most.max(*haste));
        look.vehicles.push(hastes.into_iter().fold(0.0, f64::max));
        look.pieces.push(pieces);
    }
    Ok(look)
}

/// The shortest a leg may be: nobody sets out before everybody has braked who has to.
fn least_s(vehicles: &[TimedVehicle], leg: usize) -> f64 {
    let braking_s = vehicles.iter().map(TimedVehicle::braking_s).fold(0.0, f64::max);
    SHORTEST_LEG_S + if leg == 0 { braking_s } else { 0.0 }
}

/// Durations from the limits alone.
fn guess(vehicles: &[TimedVehicle]) -> Vec<f64> {
    let legs = vehicles.iter().map(|v| v.places.len()).max().unwrap_or(0);
    let mut durations_s: Vec<f64> = (0..legs).map(|leg| least_s(vehicles, leg)).collect();
    for vehicle in vehicles {
        for (leg, (most_s, own_s)) in durations_s.iter_mut().zip(vehicle.first_guess()).enumerate() {
            let braking_s = if leg == 0 { vehicle.braking_s() } else { 0.0 };
            *most_s = most_s.max(own_s + braking_s);
        }
    }
    durations_s
}

/// Durations adapted leg by leg to what the trajectories turn out to need: the ones with the least total, were they scaled.
fn adapt(vehicles: &[TimedVehicle], basis: &Basis, mut durations_s: Vec<f64>) -> Result<Vec<f64>, TrajectoryError> {
    let mut best = (f64::INFINITY, durations_s.clone());
    let mut since_better = 0;
    for _ in 0..ROUNDS {
        let seen = look(vehicles, basis, &durations_s)?;
        let total_s = seen.haste().max(0.2) * durations_s.iter().sum::<f64>();
        since_better += 1;
        if total_s < 0.995 * best.0 {
            since_better = 0;
        }
        if total_s < best.0 {
            best = (total_s, durations_s.clone());
        }
        if since_better > PATIENCE {
            break;
        }
        for (leg, (duration_s, haste)) in durations_s.iter_mut().zip(&seen.legs).enumerate() {
            let adapted_s = *duration_s * haste.powf(0.8).clamp(0.6, 4.0);
            *duration_s = adapted_s.max(least_s(vehicles, leg)).min(LONGEST_S);
        }
    }
    Ok(best.1)
}

/// Durations that suit all.
fn settle(vehicles: &[TimedVehicle], basis: &Basis) -> Result<Settled, TrajectoryError> {
    let mut durations_s = adapt(vehicles, basis, guess(vehicles))?;
    for _ in 0..SLOWER_ROUNDS {
        let seen = look(vehicles, basis, &durations_s)?;
        let possible = durations_s.iter().sum::<f64>() < LONGEST_S;
        if !possible {
            break;
        }
        if seen.haste() <= 1.0 {
            return Ok(Settled {
                pieces: seen.pieces,
                durations_s,
                too_fast: Vec::new(),
            });
        }
        let by = seen.haste().min(2.0) * (1.0 + 1e-6);
        for (leg, duration_s) in durations_s.iter_mut().enumerate() {
            // What is spent on braking is not what has to become slower.
            let fixed_s = least_s(vehicles, leg) - SHORTEST_LEG_S;
            *duration_s = fixed_s + (*duration_s - fixed_s) * by;
        }
    }
    // Where a motion goes on for too long at the start or beside a short leg, more time makes it worse.
    let seen = look(vehicles, basis, &durations_s)?;
    Ok(Settled {
        too_fast: (0..vehicles.len()).filter(|i| !seen.is_within(*i)).collect(),
        pieces: seen.pieces,
        durations_s,
    })
}
