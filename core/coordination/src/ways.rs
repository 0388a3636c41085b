//! Ways around no-fly volumes: a command or a route whose straight way is closed is flown in legs.
//!
//! Must never do: change where somebody wants to go. A goal that is not permitted is refused as such.

use skein_domain::frames::wrap_angle_rad;
use skein_domain::{FormationHeading, OffsetFrd, PositionNed, Refusal, Route, VehicleCommand, VehicleId};
use skein_flight::way_around::way_around;
use skein_safety::{Clearance, Fences};
use skein_view::PeerSnapshot;
use std::collections::VecDeque;

/// Distance kept from no-fly volumes on the way around them, in metres: tracking error and noise, and to spare.
const CLEARANCE: Clearance = Clearance {
    horizontal_m: 2.0,
    vertical_m: 1.5,
};

/// A leg shorter than this has no course, in metres.
const SHORTEST_COURSE_M: f64 = 0.5;

/// The legs of a command for a vehicle in the air; empty if the straight way is free, so that its model flies it by itself.
///
/// # Errors
/// When the goal is closed, or no way leads there.
pub fn legs(
    fences: &Fences,
    peers: &PeerSnapshot,
    vehicle: VehicleId,
    command: &VehicleCommand,
) -> Result<VecDeque<VehicleCommand>, Refusal> {
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
    let waypoints = waypoints(fences, &from, &goal)?;
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

/// Whether everyone's place about an anchor stays inside while the anchor flies a route: on each leg with the heading it has there, and
/// in the middle of each turn between two. One that is outside at the start comes in on the first leg.
///
/// # Errors
/// The first place that does not, and where.
pub fn keeps_places_inside(
    fences: &Fences,
    start: &PositionNed,
    route: &Route,
    heading: &FormationHeading,
    places: &[(VehicleId, OffsetFrd)],
) -> Result<(), Refusal> {
    if fences.is_empty() {
        return Ok(());
    }
    let (mut from, mut formerly_rad) = (*start, None);
    for (leg, to) in (1..).zip(&route.waypoints) {
        let heading_rad = match heading {
            FormationHeading::Fixed { heading_rad, .. } => *heading_rad,
            FormationHeading::Course { .. } => course_rad(&from, to).or(formerly_rad).unwrap_or_default(),
        };
        let turn_rad = wrap_angle_rad(heading_rad - formerly_rad.unwrap_or(heading_rad));
        for (id, place) in places {
            let at = |anchor: &PositionNed, heading_rad: f64| anchor.moved(place.rotated(heading_rad));
            let (begins, ends) = (at(&from, heading_rad), at(to, heading_rad));
            // A way back in from where it is now is a good way: who is held at the fence comes along it.
            let back_in = leg == 1 && fences.contains(&begins).is_err();
            let inside = if back_in {
                fences.contains(&ends)
            } else {
                let in_turn = fences.contains(&at(&from, heading_rad - 0.5 * turn_rad));
                in_turn.and_then(|()| fences.contains_way(&begins, &ends))
            };
            inside.map_err(|refusal| of_place(*id, leg, &refusal))?;
        }
        (from, formerly_rad) = (*to, Some(heading_rad));
    }
    Ok(())
}

/// The course of a leg; none of one that leads straight up or nowhere.
fn course_rad(from: &PositionNed, to: &PositionNed) -> Option<f64> {
    let way = to.vector() - from.vector();
    (way.xy().norm() > SHORTEST_COURSE_M).then(|| way.y.atan2(way.x))
}

fn of_place(vehicle: VehicleId, leg: usize, refusal: &Refusal) -> Refusal {
    let detail = match refusal {
        Refusal::OutsideFence { detail } => detail.clone(),
        other => other.to_string(),
    };
    Refusal::OutsideFence {
        detail: format!("the place of vehicle {vehicle} on the way to waypoint {leg}: {detail}"),
    }
}

#[cfg(test)]
mod tests;
