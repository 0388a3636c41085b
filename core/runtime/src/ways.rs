//! Ways around no-fly volumes: a command or a route whose straight way is closed is flown in legs.
//!
//! Must never do: change where somebody wants to go. A goal that is not permitted is refused as such.

use crate::board::Board;
use skein_domain::{PositionNed, Refusal, Route, VehicleCommand, VehicleId};
use skein_flight::way_around::way_around;
use skein_safety::{Clearance, Fences};
use std::collections::VecDeque;

/// Distance kept from no-fly volumes on the way around them, in metres: tracking error and noise, and to spare.
const CLEARANCE: Clearance = Clearance {
    horizontal_m: 2.0,
    vertical_m: 1.5,
};

/// The legs of a command for a vehicle in the air; empty if the straight way is free, so that its model flies it by itself.
///
/// # Errors
/// When the goal is closed, or no way leads there.
pub fn legs(board: &Board, vehicle: VehicleId, command: &VehicleCommand) -> Result<VecDeque<VehicleCommand>, Refusal> {
    let gate = board.gate();
    let peers = board.peers.load();
    let entry = peers.entry(vehicle).filter(|e| e.airborne);
    let Some(from) = entry.and_then(|e| e.kinematics).map(|k| k.position) else {
        return Ok(VecDeque::new());
    };
    let level = |place: &PositionNed| PositionNed {
        down_m: from.down_m,
        ..*place
    };
    let (goal, last) = match command {
        VehicleCommand::GoTo { position, .. } => (*position, None),
        VehicleCommand::LandAt { spot } => (level(spot), Some(*command)),
        VehicleCommand::Return => match entry.and_then(|e| e.home) {
            Some(home) => (level(&home), Some(VehicleCommand::LandAt { spot: home })),
            None => return Ok(VecDeque::new()),
        },
        _ => return Ok(VecDeque::new()),
    };
    let waypoints = waypoints(gate.fences(), &from, &goal)?;
    if waypoints.len() < 2 {
        return Ok(VecDeque::new());
    }
    let (yaw_rad, speed_m_s) = match command {
        VehicleCommand::GoTo { yaw_rad, speed_m_s, .. } => (*yaw_rad, *speed_m_s),
        _ => (None, None),
    };
    let fly = |position: PositionNed| VehicleCommand::GoTo {
        position,
        yaw_rad,
        speed_m_s,
    };
    Ok(waypoints.into_iter().map(fly).chain(last).collect())
}

/// Where to go from one place to another: the goal alone if the straight way is free.
///
/// # Errors
/// When no way leads there.
pub fn waypoints(fences: &Fences, from: &PositionNed, to: &PositionNed) -> Result<Vec<PositionNed>, Refusal> {
    // Who is outside already comes straight back in, and the gate looks after that.
    if fences.is_empty() || fences.contains(from).is_err() || fences.contains_way(from, to).is_ok() {
        return Ok(vec![*to]);
    }
    way_around(fences, from, to, &CLEARANCE)
        .map(|way| way.waypoints)
        .map_err(Refusal::from)
}

/// A route whose legs lead around what is closed, with room for a formation that reaches `radius_m` about its leader.
///
/// # Errors
/// When no way leads to one of its waypoints.
pub fn route(fences: &Fences, start: &PositionNed, route: Route, radius_m: f64) -> Result<Route, Refusal> {
    if fences.is_empty() {
        return Ok(route);
    }
    let clearance = Clearance {
        horizontal_m: CLEARANCE.horizontal_m + radius_m,
        ..CLEARANCE
    };
    let mut from = *start;
    let mut waypoints = Vec::with_capacity(route.waypoints.len());
    for to in &route.waypoints {
        let straight = fences.keeps_clearance(&from, to, &clearance).is_ok();
        if straight || fences.contains(&from).is_err() {
            waypoints.push(*to);
        } else {
            waypoints.extend(way_around(fences, &from, to, &clearance)?.waypoints);
        }
        from = *to;
    }
    Ok(Route { waypoints, ..route })
}
