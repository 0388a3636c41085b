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
const ROUNDS: u32 = 8;
/// How often the whole is made slower until it is within the limits. From rest once is enough.
const SLOWER_ROUNDS: u32 = 40;
/// A vehicle slower than this starts at rest as far as swinging out goes, in metres per second.
const SLOW_M_S: f64 = 0.3;
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
struct Vehicle {
    limits: FlightLimits,
    begin: Begin,
    places: Vec<Vector3<f64>>,
    /// What it has at the start, a little above.
    allowed: Peaks,
    /// It brakes first, on this piece.
    braking: Option<TrajectoryPiece>,
}

/// Plans for all.
pub(super) fn together(journeys: &[Journey], smoothness: Smoothness) -> Result<Planned, TrajectoryError> {
    let mut vehicles = journeys
        .iter()
        .enumerate()
        .map(|(index, journey)| Vehicle::new(index, journey))
        .collect::<Result<Vec<_>, _>>()?;
    let unsolvable = TrajectoryError::TooLong { limit_s: LONGEST_S };
    let basis = Basis::new(smoothness).ok_or(unsolvable)?;
    let mut planned = settle(&vehicles, &basis)?;
    let mut brakes = false;
    for (index, vehicle) in vehicles.iter_mut().enumerate() {
        let swings = planned
            .pieces
            .get(index)
            .is_none_or(|pieces| vehicle.swings_out(pieces));
        if planned.too_fast.contains(&index) || swings {
            vehicle.brake(smoothness, index)?;
            brakes = true;
        }
    }
    if brakes {
        planned = settle(&vehicles, &basis)?;
    }
    match planned.too_fast.first() {
        Some(index) => Err(TrajectoryError::StartBeyondLimits { index: *index }),
        None => Ok(Planned {
            pieces: planned.pieces,
            passes_s: planned
                .durations_s
                .iter()
                .scan(0.0, |at_s, duration_s| {
                    *at_s += duration_s;
                    Some(*at_s)
                })
                .collect(),
        }),
    }
}

impl Vehicle {
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
            if !((place - at).norm() < 3e7) {
                return Err(TrajectoryError::WaypointNotUsable { index, waypoint });
            }
            at = *place;
        }
        let state = Peaks::of_state(start);
        Ok(Self {
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

    fn braking_s(&self) -> f64 {
        self.braking.as_ref().map_or(0.0, |piece| piece.duration_s)
    }

    /// Its pieces for these durations of the legs.
    fn pieces(&self, basis: &Basis, durations_s: &[f64]) -> Option<Vec<TrajectoryPiece>> {
        let Some(braking) = &self.braking else {
            return through(basis, &self.begin, &self.places, durations_s);
        };
        let stopped = Begin {
            position: piece_at(braking, braking.duration_s)[0],
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
        };
        let mut left_s: Vec<f64> = durations_s.to_vec();
        if let Some(first_s) = left_s.first_mut() {
            *first_s = (*first_s - braking.duration_s).max(SHORTEST_LEG_S);
        }
        let rest = through(basis, &stopped, &self.places, &left_s)?;
        Some(std::iter::once(braking.clone()).chain(rest).collect())
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

    /// Whether the first leg leaves the straight way by more than a sensible braking would.
    fn swings_out(&self, pieces: &[TrajectoryPiece]) -> bool {
        let speed = self.begin.velocity.norm();
        let (Some(first), Some(to)) = (pieces.first(), self.places.first()) else {
            return false;
        };
        if self.braking.is_some() || speed < SLOW_M_S {
            return false;
        }
        let allowed_m = speed * speed / self.limits.max_acceleration_m_s2 + 1.0;
        let leg = to - self.begin.position;
        let length2 = leg.norm_squared().max(1e-12);
        // Looking closely is not needed: this only chooses between two ways that are both within the limits.
        (1..16).any(|i| {
            let off = piece_at(first, first.duration_s * f64::from(i) / 16.0)[0] - self.begin.position;
            let share = (off.dot(&leg) / length2).clamp(0.0, 1.0);
            (off - leg * share).norm() > allowed_m
        })
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
    /// Vehicles that are not within their limits: it is the motion they start with.
    too_fast: Vec<usize>,
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
}

fn look(vehicles: &[Vehicle], basis: &Basis, durations_s: &[f64]) -> Result<Look, TrajectoryError> {
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

/// Durations that suit all.
fn settle(vehicles: &[Vehicle], basis: &Basis) -> Result<Settled, TrajectoryError> {
    let least_s = |leg: usize| {
        let braking_s = vehicles.iter().map(Vehicle::braking_s).fold(0.0, f64::max);
        SHORTEST_LEG_S + if leg == 0 { braking_s } else { 0.0 }
    };
    let legs = vehicles.iter().map(|v| v.places.len()).max().unwrap_or(0);
    let mut durations_s: Vec<f64> = (0..legs).map(least_s).collect();
    for vehicle in vehicles {
        durations_s
            .iter_mut()
            .zip(vehicle.first_guess())
            .enumerate()
            .for_each(|(leg, (most_s, own_s))| {
                *most_s = most_s.max(own_s + if leg == 0 { vehicle.braking_s() } else { 0.0 })
            });
    }
    let mut best = (f64::INFINITY, durations_s.clone());
    for _ in 0..ROUNDS {
        let haste = look(vehicles, basis, &durations_s)?;
        let total_s = haste.haste().max(0.2) * durations_s.iter().sum::<f64>();
        if total_s < best.0 {
            best = (total_s, durations_s.clone());
        }
        for (leg, (duration_s, haste)) in durations_s.iter_mut().zip(&haste.legs).enumerate() {
            *duration_s = (*duration_s * haste.powf(0.8).clamp(0.6, 1.6)).max(least_s(leg));
        }
    }
    let mut durations_s = best.1;
    for _ in 0..SLOWER_ROUNDS {
        if !(durations_s.iter().sum::<f64>() < LONGEST_S) {
            return Err(TrajectoryError::TooLong { limit_s: LONGEST_S });
        }
        let seen = look(vehicles, basis, &durations_s)?;
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
            let fixed_s = least_s(leg) - SHORTEST_LEG_S;
            *duration_s = fixed_s + (*duration_s - fixed_s) * by;
        }
    }
    let seen = look(vehicles, basis, &durations_s)?;
    let too_fast = |(index, haste): (usize, &f64)| (*haste > 1.0).then_some(index);
    Ok(Settled {
        too_fast: seen.vehicles.iter().enumerate().filter_map(too_fast).collect(),
        pieces: seen.pieces,
        durations_s,
    })
}
