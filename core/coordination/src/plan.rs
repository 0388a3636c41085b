//! The plan of a formation: who takes part, who leads, what it is anchored to, who takes which slot on which way.
//!
//! Must never do: read the shared state. With many vehicles planning takes longer than a control period: it is called off the actors.

pub(super) mod heading;

use crate::formation::{Formation, available};
use crate::succession::by_fitness;
use crate::{steering, ways};
use heading::{HEADING_TURN_M_S, STANDING_TURN_RAD_S, farthest_m};
use serde::{Deserialize, Serialize};
use skein_config::CoordinatorSettings;
use skein_domain::{
    AnchorPlan, AnchorReference, FlightLimits, FormationAnchor, FormationControl, FormationHeading, FormationRequest,
    HeadingRequest, Keeping, KeepingLaw, NodeTime, OffsetFrd, PositionNed, Refusal, Route, VehicleId,
};
use skein_flight::formation::View;
use skein_flight::transition::{self, Change, MotionLimits};
use skein_flight::{consensus, formation, limits};
use skein_safety::Gate;
use skein_view::PeerSnapshot;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A virtual leader speeds up and turns no harder than this, so that followers have something to spare, in metres per second squared.
const ANCHOR_ACCELERATION_M_S2: f64 = 2.0;

/// Detours keep so far above the lowest that the gate lets anybody fly, in metres.
const OVER_FLOOR_M: f64 = 1.0;

/// Limits a plan is made under.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PlanLimits {
    /// Motion within the formation.
    pub transition: MotionLimits,
    /// The gate's horizontal speed limit in metres per second.
    pub max_speed_m_s: f64,
    /// Who leads before others, by configuration.
    pub leader_order: Vec<VehicleId>,
}

impl PlanLimits {
    /// From the configuration.
    #[must_use]
    pub fn new(settings: &CoordinatorSettings, max_speed_m_s: f64) -> Self {
        Self {
            transition: MotionLimits {
                speed_m_s: settings.transition_speed_m_s,
                acceleration_m_s2: settings.transition_acceleration_m_s2,
                climb_m_s: settings.transition_climb_m_s,
                min_distance_m: settings.transition_min_distance_m,
            },
            max_speed_m_s,
            leader_order: settings.leader_order.iter().copied().map(VehicleId).collect(),
        }
    }
}

/// Everything a plan is made from.
#[derive(Debug, Clone)]
pub struct PlanInput {
    /// What is asked for.
    pub request: FormationRequest,
    /// The formation flown until now, if any.
    pub before: Option<Formation>,
    /// Speed of the leader's route in metres per second, while one is flown.
    pub route_speed_m_s: Option<f64>,
    /// The anchor flies along it now; a virtual leader that is new waits until they are formed.
    pub under_way: bool,
    /// Where the anchor goes from here, if that is looked at: everyone's place is inside all along.
    pub ahead: Option<Route>,
    /// Where the reference is that the formation is to be anchored to, if it is.
    pub reference: Option<AnchorReference>,
    /// Limits.
    pub limits: PlanLimits,
    /// What the formation's places have to pass.
    pub gate: Arc<Gate>,
    /// When the change is to begin.
    pub start: NodeTime,
}

/// Makes the plan of a formation change for those members that are available.
///
/// # Errors
/// When a named member or leader is not available, too few are, the anchor is not known, or no safe way into the slots is found.
pub fn plan(input: &PlanInput, peers: &PeerSnapshot) -> Result<Formation, Refusal> {
    plan_with_places(input, peers).map(|(formation, _)| formation)
}

/// Where a formation's places would be while its anchor stands where it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Heading of the formation, in radians clockwise from north.
    pub heading_rad: f64,
    /// The members' places, in the order of the members.
    pub places: Vec<PositionNed>,
}

/// The same, and where each member comes to, as far as is known now.
///
/// # Errors
/// As [`plan`].
pub fn plan_with_places(input: &PlanInput, peers: &PeerSnapshot) -> Result<(Formation, Placed), Refusal> {
    let mut members = members(&input.request, peers)?;
    let leader = choose_leader(input, &mut members, peers)?;
    let able = capabilities(&members, peers, &input.limits);
    let invalid = |e: formation::FormationError| Refusal::invalid(e.to_string());
    let slots = formation::anchored_slots(&input.request, members.len()).map_err(invalid)?;
    spaced(input, &slots)?;
    let basis = Basis::now(input, leader, peers)?;
    let together = slowest(&able);
    let from = present_offsets(input, &members, leader, &basis, peers)?;
    let headings = heading::choose(input, &from, &slots, &basis, &together);
    let taken_m_s = heading::taken_m_s(input, &from, &slots, &headings, &basis);
    let held = held_slots(input, &members, &from, &slots);
    let filter = input.gate.avoidance();
    let change = Change {
        able: &able,
        taken_m_s,
        filter: Some(&filter),
        lowest_down_m: lowest_down_m(input, &members, peers).map(|lowest_m| lowest_m - basis.position.down_m),
        led: leader.is_some(),
        held: held.as_deref(),
        ..Change::new(&from, &slots, &input.limits.transition)
    };
    let planned = change.plan(input.start).map_err(invalid)?;
    let ends: Vec<OffsetFrd> = planned.moves.iter().map(|m| m.to).collect();
    let placed = placed(&ends, &basis, &headings.formed);
    stays_inside(input, peers, (&members, &placed.places))?;
    stays_inside_ahead(input, (&members, &ends), &basis, &headings.formed)?;
    let forming = (planned.duration_s, farthest_m(&from, &slots));
    let anchor = anchor_plan(input, &basis, headings.formed, &together, forming);
    let skipped = usize::from(leader.is_some());
    let formation = Formation {
        request: FormationRequest {
            leader: leader.or(input.request.leader),
            ..input.request.clone()
        },
        leader,
        anchor,
        view_blocked: view_blocked(&members, &able, &ends),
        keeping: keeping(input, &members, leader, &ends, basis.heading_rad, planned.duration_s),
        slots: members.iter().copied().zip(planned.moves).skip(skipped).collect(),
        members,
        heading: headings.formed,
        heading_while_forming: headings.forming,
        decided: input.start,
        settled_at: input.start.plus_seconds(planned.duration_s),
        min_distance_m: planned.min_distance_m,
        max_speed_m_s: together.max_speed_m_s * limits::TURN_SPEED_SHARE,
    };
    Ok((formation, placed))
}

/// Whether the places are far enough apart. Who is alone may be joined by others: the spacing is looked at as if there were two.
fn spaced(input: &PlanInput, slots: &[OffsetFrd]) -> Result<(), Refusal> {
    let of_two = (slots.len() < 2).then(|| formation::anchored_slots(&input.request, 2));
    let places = match &of_two {
        Some(Ok(places)) => places,
        // A list of places for one vehicle.
        Some(Err(_)) => return Ok(()),
        None => slots,
    };
    input.gate.formation(formation::smallest_separation_m(places))
}

/// Members whose camera is to look out and cannot from their places.
fn view_blocked(members: &[VehicleId], able: &[FlightLimits], places: &[OffsetFrd]) -> Vec<VehicleId> {
    let views = formation::views(places);
    let blocked = |(_, (able, view)): &(&VehicleId, (&FlightLimits, View))| able.keeps_view && *view == View::Blocked;
    members
        .iter()
        .zip(able.iter().zip(views))
        .filter(blocked)
        .map(|(id, _)| *id)
        .collect()
}

fn placed(slots: &[OffsetFrd], basis: &Basis, heading: &FormationHeading) -> Placed {
    let heading_rad = match heading {
        FormationHeading::Fixed { heading_rad, .. } => *heading_rad,
        FormationHeading::Course { .. } => basis.heading_rad,
    };
    let place = |slot: &OffsetFrd| basis.position.moved(slot.rotated(heading_rad));
    Placed {
        heading_rad,
        places: slots.iter().map(place).collect(),
    }
}

/// Whether everyone's place is one that may be flown to. In the same order, members and their places.
fn stays_inside(
    input: &PlanInput,
    peers: &PeerSnapshot,
    (members, places): (&[VehicleId], &[PositionNed]),
) -> Result<(), Refusal> {
    members.iter().zip(places).try_for_each(|(id, place)| {
        let ground_down_m = peers.entry(*id).map_or(0.0, steering::ground_down_m);
        input.gate.goal(place)?;
        input.gate.height(place, ground_down_m)
    })
}

/// The same along the way that the anchor is on, if that is looked at.
fn stays_inside_ahead(
    input: &PlanInput,
    (members, slots): (&[VehicleId], &[OffsetFrd]),
    basis: &Basis,
    heading: &FormationHeading,
) -> Result<(), Refusal> {
    let Some(route) = &input.ahead else { return Ok(()) };
    let places: Vec<(VehicleId, OffsetFrd)> = members.iter().copied().zip(slots.iter().copied()).collect();
    ways::keeps_places_inside(input.gate.fences(), &basis.position, route, heading, &places)
}

/// Who takes part, by ascending id.
fn members(request: &FormationRequest, peers: &PeerSnapshot) -> Result<Vec<VehicleId>, Refusal> {
    let available = available(peers);
    let mut members = match &request.members {
        Some(named) => {
            for id in named {
                if !available.contains(id) {
                    return Err(peers
                        .entry(*id)
                        .map_or(Refusal::UnknownVehicle { vehicle: *id }, |entry| Refusal::WrongState {
                            state: entry.flight_state,
                            command: format!("take vehicle {id} into the formation"),
                        }));
                }
            }
            named.clone()
        }
        None => available,
    };
    members.sort_unstable();
    members.dedup();
    Ok(members)
}

/// How far below the swarm's origin detours of these members may lead, in metres; none without any.
fn lowest_down_m(input: &PlanInput, members: &[VehicleId], peers: &PeerSnapshot) -> Option<f64> {
    let of = |id: &VehicleId| {
        let ground_down_m = peers.entry(*id).map_or(0.0, steering::ground_down_m);
        input.gate.lowest_down_m(ground_down_m) - OVER_FLOOR_M
    };
    members.iter().map(of).reduce(f64::min)
}

/// Who leads, if a vehicle does: then it is the first of the members.
fn choose_leader(
    input: &PlanInput,
    members: &mut Vec<VehicleId>,
    peers: &PeerSnapshot,
) -> Result<Option<VehicleId>, Refusal> {
    if input.request.anchor != FormationAnchor::Leader {
        let nobody = Refusal::NotEnoughVehicles { have: 0, need: 1 };
        return if members.is_empty() { Err(nobody) } else { Ok(None) };
    }
    let asked = input.request.leader.filter(|id| members.contains(id));
    let present = input
        .before
        .as_ref()
        .and_then(|f| f.leader)
        .filter(|id| members.contains(id));
    let leader = asked
        .or(present)
        .or_else(|| by_fitness(members, &input.limits.leader_order, peers).first().copied())
        .ok_or(Refusal::NotEnoughVehicles { have: 0, need: 1 })?;
    members.retain(|id| *id != leader);
    members.insert(0, leader);
    Ok(Some(leader))
}

/// What each member can do: as its model says, or else as the configuration has it for all.
pub(super) fn capabilities(members: &[VehicleId], peers: &PeerSnapshot, limits: &PlanLimits) -> Vec<FlightLimits> {
    let assumed = FlightLimits {
        max_speed_m_s: limits.max_speed_m_s,
        max_climb_m_s: limits.transition.climb_m_s,
        max_descent_m_s: limits.transition.climb_m_s,
        max_acceleration_m_s2: limits.transition.acceleration_m_s2,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    };
    let of = |id: &VehicleId| {
        let said = peers.entry(*id).and_then(|e| e.limits);
        said.map_or(assumed, |said| FlightLimits {
            max_speed_m_s: said.max_speed_m_s.min(limits.max_speed_m_s),
            ..said
        })
    };
    members.iter().map(of).collect()
}

/// What all of them can do together.
pub(super) fn slowest(able: &[FlightLimits]) -> FlightLimits {
    let all = able.iter().copied().reduce(|a, b| a.with(&b));
    all.unwrap_or(FlightLimits {
        max_speed_m_s: 0.0,
        max_climb_m_s: 0.0,
        max_descent_m_s: 0.0,
        max_acceleration_m_s2: 0.0,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    })
}

/// Where the formation's axes are when the change begins.
struct Basis {
    /// The anchor's place.
    position: PositionNed,
    /// The anchor's heading in radians.
    heading_rad: f64,
    /// How fast it turns, in radians per second.
    turning_rad_s: f64,
}

impl Basis {
    fn now(input: &PlanInput, leader: Option<VehicleId>, peers: &PeerSnapshot) -> Result<Self, Refusal> {
        if let Some(leader) = leader {
            return Self::of_leader(input, leader, peers);
        }
        // What the formation is anchored to now, be it a vehicle or not.
        let before = input.before.as_ref();
        let present = before.and_then(|f| match f.leader {
            Some(leader) => peers.entry(leader).and_then(|e| e.anchor),
            None => peers.anchor,
        });
        let asked = asked_heading_deg(&input.request);
        let heading_rad = present.map_or_else(
            || asked.map_or(0.0, f64::to_radians),
            |anchor: AnchorReference| anchor.heading_rad,
        );
        let at = |position: PositionNed, turning_rad_s: f64| Self {
            position,
            heading_rad,
            turning_rad_s,
        };
        let same_as_before = before.is_some_and(|f| f.anchor.is_some() && f.request.anchor == input.request.anchor);
        match (&input.request.anchor, present) {
            (FormationAnchor::Path { .. }, Some(anchor)) => Ok(at(anchor.position, anchor.heading_rate_rad_s)),
            (_, Some(anchor)) if same_as_before => Ok(at(anchor.position, anchor.heading_rate_rad_s)),
            (FormationAnchor::Path { route }, None) => route
                .waypoints
                .first()
                .map(|first| at(*first, 0.0))
                .ok_or_else(|| Refusal::invalid("a route needs at least one waypoint")),
            (FormationAnchor::Place { position, .. }, _) => Ok(at(*position, 0.0)),
            (FormationAnchor::Reference { name }, _) => {
                let reference = input
                    .reference
                    .ok_or_else(|| Refusal::UnknownReference { name: name.clone() })?;
                Ok(at(reference.position, 0.0))
            }
            (FormationAnchor::Leader, _) => Err(Refusal::NoPosition),
        }
    }

    /// The leader's anchor if it leads already, else its place and yaw, which is what the leader's model starts from.
    fn of_leader(input: &PlanInput, leader: VehicleId, peers: &PeerSnapshot) -> Result<Self, Refusal> {
        let entry = peers.entry(leader).ok_or(Refusal::NoPosition)?;
        let kinematics = entry.kinematics.ok_or(Refusal::NoPosition)?;
        // Who followed until now goes on from the heading it followed in.
        let followed = input
            .before
            .as_ref()
            .filter(|f| f.slots.contains_key(&leader) && !f.keeps_itself(input.start));
        let followed = followed.and_then(|f| match f.leader {
            Some(former) => peers.entry(former).and_then(|e| e.anchor),
            None => peers.anchor,
        });
        let anchor = entry.anchor.or(followed);
        let heading_rad = match (anchor, input.request.heading) {
            (Some(anchor), _) => anchor.heading_rad,
            (None, HeadingRequest::Fixed { heading_deg }) => heading_deg.to_radians(),
            (None, HeadingRequest::Auto | HeadingRequest::Course) => kinematics.yaw_rad,
        };
        Ok(Self {
            position: kinematics.position,
            heading_rad,
            turning_rad_s: anchor.map_or(0.0, |a| a.heading_rate_rad_s),
        })
    }
}

/// The heading that is asked for in numbers: of the formation, or of its place.
fn asked_heading_deg(request: &FormationRequest) -> Option<f64> {
    match (request.heading, &request.anchor) {
        (HeadingRequest::Fixed { heading_deg }, _) => Some(heading_deg),
        (_, FormationAnchor::Place { heading_deg, .. }) => *heading_deg,
        _ => None,
    }
}

/// The anchor, if it is no vehicle. One that goes on as before stays the same, so that nothing starts anew.
fn anchor_plan(
    input: &PlanInput,
    basis: &Basis,
    heading: FormationHeading,
    together: &FlightLimits,
    (forming_s, farthest_m): (f64, f64),
) -> Option<AnchorPlan> {
    let before = input.before.as_ref();
    let same = |f: &&Formation| f.request.anchor == input.request.anchor && f.request.heading == input.request.heading;
    if let Some(kept) = before.filter(same).and_then(|f| f.anchor.clone()) {
        return Some(kept);
    }
    match &input.request.anchor {
        FormationAnchor::Leader => None,
        FormationAnchor::Path { route } => Some(AnchorPlan::Path {
            route: Route {
                speed_m_s: route.speed_m_s.min(together.max_speed_m_s * limits::TURN_SPEED_SHARE),
                corner_radius_m: route.corner_radius_m.max(together.min_turn_radius_m),
                ..route.clone()
            },
            from: basis.position,
            heading_rad: basis.heading_rad,
            heading,
            acceleration_m_s2: together.max_acceleration_m_s2.min(ANCHOR_ACCELERATION_M_S2),
            climb_m_s: together.max_climb_m_s,
            descent_m_s: together.max_descent_m_s,
            // It waits until they are in their slots.
            start: input.start.plus_seconds(forming_s),
        }),
        FormationAnchor::Reference { name } => Some(AnchorPlan::Reference {
            name: name.clone(),
            heading,
            places: Vec::new(),
        }),
        FormationAnchor::Place { position, .. } => Some(AnchorPlan::Place {
            position: *position,
            heading_rad: asked_heading_deg(&input.request).map_or(basis.heading_rad, f64::to_radians),
            max_rate_rad_s: STANDING_TURN_RAD_S.min(HEADING_TURN_M_S / farthest_m.max(1.0)),
        }),
    }
}

/// For control by neighbours: whom each follower keeps its place by, in the axes the formation has when it is formed.
fn keeping(
    input: &PlanInput,
    members: &[VehicleId],
    leader: Option<VehicleId>,
    slots: &[OffsetFrd],
    heading_rad: f64,
    forming_s: f64,
) -> BTreeMap<VehicleId, Keeping> {
    let law = match input.request.control {
        FormationControl::Slots => return BTreeMap::new(),
        FormationControl::Distances => KeepingLaw::Distances,
        FormationControl::Bearings => KeepingLaw::Bearings,
    };
    let placed: Vec<(VehicleId, OffsetFrd)> = members.iter().copied().zip(slots.iter().copied()).collect();
    let start = input.start.plus_seconds(forming_s);
    consensus::keepings(&placed, leader, heading_rad, law, start)
        .into_iter()
        .collect()
}

/// Who has which of the slots, where the same members fly the same shape and only its parameters change: such a change is a morph.
fn held_slots(input: &PlanInput, members: &[VehicleId], from: &[OffsetFrd], slots: &[OffsetFrd]) -> Option<Vec<usize>> {
    let before = input.before.as_ref()?;
    let same = before.request.shape == input.request.shape
        && before.members.len() == members.len()
        && members.iter().all(|id| before.members.contains(id))
        && before.leader.is_some() == (input.request.anchor == FormationAnchor::Leader);
    let former = formation::anchored_slots(&before.request, members.len());
    let former = former.ok().filter(|former| same && former.len() == slots.len())?;
    Some(transition::held_slots(from, &former))
}

/// Where each member is relative to the anchor when the change begins. A member of the formation flown until now is taken at its slot,
/// not where it was measured, so that its setpoint does not jump.
fn present_offsets(
    input: &PlanInput,
    members: &[VehicleId],
    leader: Option<VehicleId>,
    basis: &Basis,
    peers: &PeerSnapshot,
) -> Result<Vec<OffsetFrd>, Refusal> {
    let place = |id: &VehicleId| {
        peers
            .entry(*id)
            .and_then(|e| e.kinematics)
            .map(|k| k.position)
            .ok_or(Refusal::NoPosition)
    };
    // Who keeps its place by its neighbours is where they are, which may be another place and direction than those of the slots.
    let before = input.before.as_ref().filter(|f| !f.keeps_itself(input.start));
    let slot_offset = |id: &VehicleId| {
        let before = before?;
        if Some(*id) == before.leader {
            return Some(OffsetFrd::default());
        }
        before
            .slots
            .get(id)
            .map(|slot| transition::sample(slot, input.start).offset)
    };
    // Offsets of the former slots are relative to the former anchor: re-based on the new leader where both have a slot, kept where
    // the anchor goes on as it was.
    let same_anchor = before.is_some_and(|f| f.anchor.is_some() && f.request.anchor == input.request.anchor);
    let base = match leader {
        Some(leader) => slot_offset(&leader),
        None => same_anchor.then(OffsetFrd::default),
    };
    members
        .iter()
        .map(|id| match (slot_offset(id), base) {
            (Some(offset), Some(base)) => Ok(OffsetFrd::from(offset.vector() - base.vector())),
            _ => Ok(OffsetFrd::from_ned(
                place(id)?.vector() - basis.position.vector(),
                basis.heading_rad,
            )),
        })
        .collect()
}
