//! Trajectories of vehicles that fly along waypoints of their own, in step with each other: planned, held against fences, ground and
//! everybody else, as plain data.
//!
//! Must never do: read the shared state, or let a way pass of which anything is not known. What is wrong is told item by item.

use crate::plan::{PlanLimits, capabilities};
use crate::state::Flight;
use crate::steering;
use skein_domain::link::RoutePoint;
use skein_domain::{
    FlightLimits, JourneyPlan, JourneyRequest, NodeTime, PositionNed, Refusal, SwarmFrame, Trajectory, TrajectoryKind,
    TrajectoryObjection, TrajectoryPlan, TrajectoryRequest, VehicleId,
};
use skein_flight::limits::TURN_SPEED_SHARE;
use skein_flight::trajectory::{self, Journey, MotionState, Smoothness, SpeedWaypoint};
use skein_safety::{Clearance, Gate};
use skein_view::{PeerEntry, PeerSnapshot};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Legs that are held against the fences leave the way by no more than this, in metres.
const LEGS_WITHIN_M: f64 = 0.5;
/// The way keeps this distance to what is closed, in metres: that of the legs, and what a vehicle flies beside its way.
const CLEARANCE: Clearance = Clearance {
    horizontal_m: LEGS_WITHIN_M + 1.0,
    vertical_m: LEGS_WITHIN_M + 0.5,
};
/// A vehicle slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.5;
/// A vehicle farther from its present way than this goes on from elsewhere than a new one would begin, in metres.
const OFF_ITS_WAY_M: f64 = 3.0;
/// The length of a way is summed up in steps of so many seconds.
const LENGTH_STEP_S: f64 = 0.1;
/// A mission has at most so many points; each comes with its speed.
const MISSION_POINTS: usize = 180;
/// How far the legs of a mission may leave the way, in metres: tried in this order until they are few enough.
const MISSION_WITHIN_M: [f64; 4] = [LEGS_WITHIN_M, 1.0, 2.0, 4.0];

/// Everything trajectories are planned from.
#[derive(Debug, Clone)]
pub struct TrajectoryInput {
    /// What is asked for.
    pub request: TrajectoryRequest,
    /// Trajectories flown until now.
    pub flights: BTreeMap<VehicleId, Flight>,
    /// Members of the formation that is flown.
    pub members: Vec<VehicleId>,
    /// Where vehicles that hold were told to.
    pub held: BTreeMap<VehicleId, PositionNed>,
    /// Vehicles whose clock cannot be relied on.
    pub clock_faults: BTreeSet<VehicleId>,
    /// Limits for those whose model says nothing.
    pub limits: PlanLimits,
    /// What the ways have to pass.
    pub gate: Arc<Gate>,
    /// The swarm's frame.
    pub frame: SwarmFrame,
    /// Now.
    pub now: NodeTime,
    /// When all begin.
    pub start: NodeTime,
}

/// Trajectories that may be flown.
#[derive(Debug, Clone)]
pub struct PlannedFlights {
    /// What is told of them.
    pub plan: TrajectoryPlan,
    /// Each vehicle's.
    pub flights: BTreeMap<VehicleId, Flight>,
    /// What is put on the autopilots; empty if that was not asked for.
    pub routes: BTreeMap<VehicleId, Vec<RoutePoint>>,
}

type Objections = Vec<TrajectoryObjection>;

fn objection(vehicle: VehicleId, refusal: Refusal) -> TrajectoryObjection {
    TrajectoryObjection {
        vehicle: Some(vehicle),
        refusal,
    }
}

/// Plans the asked trajectories.
///
/// # Errors
/// Everything that is against them, item by item.
pub fn plan_trajectories(input: &TrajectoryInput, peers: &PeerSnapshot) -> Result<PlannedFlights, Objections> {
    let request = &input.request;
    let able = able(input, peers);
    let mut against = speed_objections(input);
    against.extend(request.vehicles.iter().zip(&able).flat_map(|(journey, able)| {
        let found = vehicle_objections(input, journey, able, peers);
        found.into_iter().map(|refusal| objection(journey.vehicle, refusal))
    }));
    if !against.is_empty() {
        return Err(against);
    }
    let journeys: Vec<Journey> = request
        .vehicles
        .iter()
        .zip(&able)
        .filter_map(|(asked, limits)| {
            Some(Journey {
                start: start_state(input, peers.entry(asked.vehicle)?)?,
                waypoints: asked.waypoints.clone(),
                limits: *limits,
            })
        })
        .collect();
    let smoothness = match request.kind {
        TrajectoryKind::Jerk => Smoothness::Jerk,
        TrajectoryKind::Snap => Smoothness::Snap,
    };
    let together = trajectory::plan_together(&journeys, input.start, smoothness).map_err(|error| {
        vec![TrajectoryObjection {
            vehicle: None,
            refusal: Refusal::invalid(error.to_string()),
        }]
    })?;
    let ways: Vec<(VehicleId, Trajectory)> = request
        .vehicles
        .iter()
        .map(|asked| asked.vehicle)
        .zip(together.trajectories)
        .collect();
    let mut against: Objections = ways
        .iter()
        .filter_map(|(id, way)| Some(objection(*id, inside(input, peers.entry(*id)?, way).err()?)))
        .collect();
    let (nearest, near) = apart(input, peers, &ways);
    against.extend(near);
    let routes = if request.upload {
        routes(input, &ways, &mut against)
    } else {
        BTreeMap::new()
    };
    if !against.is_empty() {
        return Err(against);
    }
    Ok(finished(input, ways, &together.passes_s, nearest, routes))
}

/// What each of them can do here: as its model says, within the gate, with something to spare for keeping to the way.
fn able(input: &TrajectoryInput, peers: &PeerSnapshot) -> Vec<FlightLimits> {
    let ids: Vec<VehicleId> = input.request.vehicles.iter().map(|v| v.vehicle).collect();
    let gate = input.gate.limits();
    let asked_m_s = input.request.max_speed_m_s.unwrap_or(f64::INFINITY);
    let within = |said: FlightLimits| FlightLimits {
        max_speed_m_s: (said.max_speed_m_s.min(gate.max_speed_m_s) * TURN_SPEED_SHARE).min(asked_m_s),
        max_climb_m_s: said.max_climb_m_s.min(gate.max_climb_m_s) * TURN_SPEED_SHARE,
        max_descent_m_s: said.max_descent_m_s.min(gate.max_descent_m_s) * TURN_SPEED_SHARE,
        ..said
    };
    let said = capabilities(&ids, peers, &input.limits);
    said.into_iter().map(within).collect()
}

fn speed_objections(input: &TrajectoryInput) -> Objections {
    let limit_m_s = input.gate.limits().max_speed_m_s;
    let asked = input.request.max_speed_m_s.filter(|speed| *speed > limit_m_s);
    let too_fast = |speed_m_s| TrajectoryObjection {
        vehicle: None,
        refusal: Refusal::TooFast { speed_m_s, limit_m_s },
    };
    asked.map(too_fast).into_iter().collect()
}

/// What is against one vehicle before anything is planned.
fn vehicle_objections(
    input: &TrajectoryInput,
    asked: &JourneyRequest,
    able: &FlightLimits,
    peers: &PeerSnapshot,
) -> Vec<Refusal> {
    let vehicle = asked.vehicle;
    let Some(entry) = peers.entry(vehicle) else {
        return vec![Refusal::UnknownVehicle { vehicle }];
    };
    if !entry.link.connected {
        return vec![Refusal::LinkLost { vehicle }];
    }
    let mut against = Vec::new();
    let on = input.flights.get(&vehicle).is_some_and(Flight::is_on);
    let ready = match entry.flight_state {
        skein_domain::FlightState::Holding => true,
        skein_domain::FlightState::GoingTo => on,
        _ => false,
    };
    if !ready || entry.under_order || !entry.airborne || input.members.contains(&vehicle) {
        against.push(Refusal::WrongState {
            state: entry.flight_state,
            command: "fly a trajectory".into(),
        });
    }
    if input.clock_faults.contains(&vehicle) {
        against.push(Refusal::Clock {
            detail: "the vehicle's clock is not to be relied on".into(),
        });
    }
    if able.min_turn_radius_m > 0.0 {
        against.push(Refusal::not_supported(
            "trajectories for vehicles that cannot turn on the spot",
        ));
    }
    match start_state(input, entry) {
        None => against.push(Refusal::NoPosition),
        Some(_) => against.extend(off_its_way(input, entry)),
    }
    for (index, waypoint) in asked.waypoints.iter().enumerate() {
        if let Err(refusal) = input.gate.goal(waypoint) {
            against.push(of_waypoint(index, refusal));
        }
    }
    against
}

fn of_waypoint(index: usize, refusal: Refusal) -> Refusal {
    match refusal {
        Refusal::OutsideFence { detail } => Refusal::OutsideFence {
            detail: format!("waypoint {}: {detail}", index + 1),
        },
        other => other,
    }
}

/// A vehicle that is held back on its way would jump onto a new one.
fn off_its_way(input: &TrajectoryInput, entry: &PeerEntry) -> Option<Refusal> {
    let flight = under_way(input, entry.id)?;
    let kinematics = entry.kinematics?;
    let wanted = trajectory::sample(&flight.trajectory, kinematics.measured).position;
    let off_m = wanted.distance_m(&kinematics.position);
    (off_m > OFF_ITS_WAY_M)
        .then(|| Refusal::not_permitted(format!("go on from its present way, which it is {off_m:.1} m off")))
}

/// Its present trajectory, if that has begun.
fn under_way(input: &TrajectoryInput, id: VehicleId) -> Option<&Flight> {
    input.flights.get(&id).filter(|f| f.is_on() && f.begun(input.now))
}

/// How it moves when the new trajectory begins: as the present one has it then, or standing where it holds.
fn start_state(input: &TrajectoryInput, entry: &PeerEntry) -> Option<MotionState> {
    if let Some(flight) = under_way(input, entry.id) {
        let then = trajectory::sample(&flight.trajectory, input.start);
        return Some(MotionState {
            position: then.position,
            velocity: then.velocity,
            acceleration: then.acceleration,
        });
    }
    let measured = entry.kinematics?.position;
    Some(MotionState::at_rest(
        input.held.get(&entry.id).copied().unwrap_or(measured),
    ))
}

/// Whether the whole way is inside of the fences and over the ground.
fn inside(input: &TrajectoryInput, entry: &PeerEntry, way: &Trajectory) -> Result<(), Refusal> {
    let legs = trajectory::to_waypoints(way, LEGS_WITHIN_M).map_err(invalid)?;
    let fences = input.gate.fences();
    let ground_down_m = steering::ground_down_m(entry);
    let mut from = trajectory::sample(way, way.start).position;
    for leg in &legs {
        // The way itself may be lower than the leg by as much as the leg leaves it.
        let lowest = PositionNed {
            down_m: leg.position.down_m + LEGS_WITHIN_M,
            ..leg.position
        };
        input.gate.height(&lowest, ground_down_m)?;
        if !fences.is_empty() {
            fences.keeps_clearance(&from, &leg.position, &CLEARANCE)?;
        }
        from = leg.position;
    }
    Ok(())
}

fn invalid(error: trajectory::TrajectoryError) -> Refusal {
    Refusal::invalid(error.to_string())
}

type Nearest = Option<(f64, VehicleId, VehicleId)>;

/// How near they come to each other and to everybody else in the air whose way is known or who stands. Whoever else moves is left to
/// the separation filter in flight.
fn apart(input: &TrajectoryInput, peers: &PeerSnapshot, ways: &[(VehicleId, Trajectory)]) -> (Nearest, Objections) {
    let avoidance = input.gate.avoidance();
    let limit_m = avoidance.min_separation_m + 2.0 * avoidance.noise_m;
    // Heights count as little as the separation filter's volume is taller than wide.
    let factor = 1.0 / avoidance.vertical_stretch;
    let flat = |way: &Trajectory| trajectory::with_heights_scaled(way, factor);
    let flown: Vec<(VehicleId, Trajectory)> = ways.iter().map(|(id, way)| (*id, flat(way))).collect();
    let others: Vec<(VehicleId, Trajectory)> = peers
        .entries
        .iter()
        .filter(|e| e.airborne && !ways.iter().any(|(id, _)| *id == e.id))
        .filter_map(|e| Some((e.id, flat(&elsewhere(input, e)?))))
        .collect();
    let (mut nearest, mut against): (Nearest, Objections) = (None, Vec::new());
    for (i, (id, way)) in flown.iter().enumerate() {
        for (other, theirs) in flown.iter().skip(i + 1).chain(&others) {
            let distance_m = trajectory::min_distance_m(way, theirs);
            if nearest.is_none_or(|(least_m, ..)| distance_m < least_m) {
                nearest = Some((distance_m, *id, *other));
            }
            let apart = distance_m >= limit_m;
            // What is not a number is too close.
            if !apart {
                let other = *other;
                against.push(objection(
                    *id,
                    Refusal::TooClose {
                        other,
                        distance_m,
                        limit_m,
                    },
                ));
            }
        }
    }
    (nearest, against)
}

/// Where somebody else is from the start on, if that can be known.
fn elsewhere(input: &TrajectoryInput, entry: &PeerEntry) -> Option<Trajectory> {
    if let Some(flight) = input.flights.get(&entry.id).filter(|f| f.is_on()) {
        return Some(trajectory::rest(&flight.trajectory, input.start));
    }
    let kinematics = entry.kinematics?;
    let stands = kinematics.velocity.norm() < STANDS_M_S;
    stands.then(|| trajectory::standing(kinematics.position, input.start))
}

/// Whether the straight legs of a mission, which leave the way they stand for, are inside of the fences.
fn legs_are_inside(input: &TrajectoryInput, way: &Trajectory, legs: &[SpeedWaypoint]) -> bool {
    let start = trajectory::sample(way, way.start).position;
    let from = std::iter::once(&start).chain(legs.iter().map(|leg| &leg.position));
    let fences = input.gate.fences();
    from.zip(legs)
        .all(|(from, leg)| fences.contains_way(from, &leg.position).is_ok())
}

/// The ways as missions. One that takes too many points, or cuts a corner behind a fence, is an objection.
fn routes(
    input: &TrajectoryInput,
    ways: &[(VehicleId, Trajectory)],
    against: &mut Objections,
) -> BTreeMap<VehicleId, Vec<RoutePoint>> {
    let point = |at: &SpeedWaypoint| RoutePoint {
        place: input.frame.geodetic(&at.position),
        speed_m_s: Some(at.speed_m_s.max(0.1)),
    };
    let mut routes = BTreeMap::new();
    for (id, way) in ways {
        let legs = MISSION_WITHIN_M
            .iter()
            .filter_map(|within_m| trajectory::to_waypoints(way, *within_m).ok())
            .find(|legs| legs.len() <= MISSION_POINTS)
            .filter(|legs| legs_are_inside(input, way, legs));
        match legs {
            Some(legs) => drop(routes.insert(*id, legs.iter().map(point).collect())),
            None => against.push(objection(
                *id,
                Refusal::not_supported(format!(
                    "a mission that keeps to its way and inside of the fences with {MISSION_POINTS} points"
                )),
            )),
        }
    }
    routes
}

fn finished(
    input: &TrajectoryInput,
    ways: Vec<(VehicleId, Trajectory)>,
    passes_s: &[f64],
    nearest: Nearest,
    routes: BTreeMap<VehicleId, Vec<RoutePoint>>,
) -> PlannedFlights {
    let mut flights = BTreeMap::new();
    for (asked, (id, way)) in input.request.vehicles.iter().zip(ways) {
        let peaks = trajectory::peaks(&way).unwrap_or_default();
        let plan = JourneyPlan {
            vehicle: id,
            duration_s: trajectory::duration_s(&way),
            length_m: trajectory::length_m(&way, LENGTH_STEP_S),
            passes_s: passes_s.iter().take(asked.waypoints.len()).copied().collect(),
            max_speed_m_s: peaks.speed_m_s,
            max_acceleration_m_s2: peaks.acceleration_m_s2,
        };
        let flight = Flight {
            trajectory: way,
            plan,
            waypoints: asked.waypoints.clone(),
            finished: false,
            ended: None,
        };
        flights.insert(id, flight);
    }
    let plan = TrajectoryPlan {
        start: input.start,
        starts_in_s: input.start.seconds_since(input.now),
        duration_s: flights.values().map(|f| f.plan.duration_s).fold(0.0, f64::max),
        min_distance_m: nearest.map(|(distance_m, ..)| distance_m),
        nearest: nearest.map(|(_, one, other)| (one, other)),
        vehicles: flights.values().map(|f| f.plan.clone()).collect(),
    };
    PlannedFlights { plan, flights, routes }
}

#[cfg(test)]
mod tests;
