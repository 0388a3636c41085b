//! The leader's route as a formation can fly it.
//!
//! Must never do: decide where to go. A route that cannot be flown is refused.

use crate::formation::Formation;
use crate::plan::{PlanLimits, capabilities, heading, slowest};
use crate::state::{ActiveRoute, Coordination};
use crate::ways;
use skein_domain::{FormationHeading, OffsetFrd, Refusal, Route, VehicleId};
use skein_safety::Gate;
use skein_view::PeerSnapshot;

/// A formation that follows its leader's course flies no faster than this share of what it can fly straight on: its outermost members need
/// the rest in turns.
const TURNING_SHARE: f64 = 0.8;

impl Coordination {
    /// Has the leader fly a route, as fast and as wide as the formation can; gives it as it is flown. The formation turns as fast as it can
    /// at that speed.
    ///
    /// # Errors
    /// When nobody leads, or the route leads where the gate lets nobody go.
    pub fn set_route(
        &mut self,
        route: Route,
        peers: &PeerSnapshot,
        limits: &PlanLimits,
        gate: &Gate,
    ) -> Result<Route, Refusal> {
        let fitted = fitted(route, self.formation.as_ref(), peers, limits, gate)?;
        if let Some(formation) = &mut self.formation {
            let together = slowest(&capabilities(&formation.members, peers, limits));
            let places: Vec<OffsetFrd> = formation.slots.values().map(|slot| slot.to).collect();
            let rate_rad_s = heading::course_rate_rad_s(&places, fitted.speed_m_s, &together);
            if let FormationHeading::Course { max_rate_rad_s } = &mut formation.heading {
                *max_rate_rad_s = rate_rad_s;
            }
            if let FormationHeading::Course { max_rate_rad_s } = &mut formation.heading_while_forming {
                *max_rate_rad_s = max_rate_rad_s.min(rate_rad_s);
            }
        }
        self.route = Some(ActiveRoute {
            route: fitted.clone(),
            next: 0,
            finished: false,
        });
        Ok(fitted)
    }
}

/// A route as a formation can fly it from where its leader is: around what is closed with room for everyone, no faster than the slowest
/// member, no corner tighter than the widest turn that one needs.
///
/// # Errors
/// When nobody leads, or the route leads where the gate lets nobody go.
fn fitted(
    route: Route,
    formation: Option<&Formation>,
    peers: &PeerSnapshot,
    limits: &PlanLimits,
    gate: &Gate,
) -> Result<Route, Refusal> {
    let (formation, leader) = formation
        .and_then(|f| f.leader.map(|leader| (f, leader)))
        .ok_or(Refusal::NotEnoughVehicles { have: 0, need: 1 })?;
    let start = peers
        .entry(leader)
        .and_then(|e| e.kinematics)
        .ok_or(Refusal::NoPosition)?
        .position;
    let route = ways::route(gate.fences(), &start, route, formation.reach_m())?;
    gate.route_from(&start, &route)?;
    let places: Vec<(VehicleId, OffsetFrd)> = formation.slots.iter().map(|(id, slot)| (*id, slot.to)).collect();
    ways::keeps_places_inside(gate.fences(), &start, &route, &formation.heading, &places)?;
    let together = slowest(&capabilities(&formation.members, peers, limits));
    let share = match formation.heading {
        FormationHeading::Course { .. } => TURNING_SHARE,
        FormationHeading::Fixed { .. } => 1.0,
    };
    Ok(Route {
        speed_m_s: route.speed_m_s.min(share * formation.max_speed_m_s),
        corner_radius_m: route.corner_radius_m.max(together.min_turn_radius_m),
        ..route
    })
}
