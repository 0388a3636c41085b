//! What the coordinator decides, as plain functions of what is on the board: who takes part, who leads, which slot, which task.
//! The coordinator actor calls them and publishes the result; its successor finds [`Coordination`] on the board and goes on.
//!
//! Must never do: read a clock or the board by itself, or send anything.

use crate::board::PeerSnapshot;
use skein_config::CoordinatorSettings;
use skein_domain::{
    AnchorReference, FormationHeading, FormationRequest, HeadingRequest, Intent, NodeTime, OffsetFrd, PositionNed,
    Refusal, Route, SlotMove, Task, VehicleId, VehicleTask,
};
use skein_flight::transition::{self, MotionLimits};
use skein_flight::{formation, limits};
use std::collections::{BTreeMap, BTreeSet};

/// Below this turning rate a formation does not follow its leader's course: a quarter turn would take longer than ten seconds.
const SLOWEST_USEFUL_TURN_RAD_S: f64 = 0.15;

/// Leader's speed assumed when a formation's turning rate is chosen, in metres per second, until a route says otherwise.
const NOMINAL_SPEED_M_S: f64 = 5.0;

/// A change of shape is flown at this speed at least, in metres per second; the gate slows whoever becomes too fast by it.
const SLOWEST_CHANGE_M_S: f64 = 1.5;

/// Acceleration of the outermost vehicle in a turn of the formation, in metres per second squared: beyond it tracking suffers.
const TURN_ACCELERATION_M_S2: f64 = 3.0;

/// Everything the coordinator must find again after a restart.
#[derive(Debug, Clone, Default)]
pub struct Coordination {
    /// The formation being flown.
    pub formation: Option<Formation>,
    /// The leader's route, kept apart so that a formation may change while it is flown.
    pub route: Option<ActiveRoute>,
    /// Vehicles that were seen taking off, so that a newcomer in the air is told from one that left.
    pub taking_off: Vec<VehicleId>,
}

/// A formation being flown.
#[derive(Debug, Clone)]
pub struct Formation {
    /// As it was asked for, with the leader filled in.
    pub request: FormationRequest,
    /// Who leads.
    pub leader: VehicleId,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// Each follower's way into its slot.
    pub slots: BTreeMap<VehicleId, SlotMove>,
    /// How its heading is chosen.
    pub heading: FormationHeading,
    /// When the change was decided.
    pub decided: NodeTime,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance foreseen on the way, in metres.
    pub min_distance_m: f64,
}

/// A route being flown.
#[derive(Debug, Clone)]
pub struct ActiveRoute {
    /// The whole route.
    pub route: Route,
    /// Index of the first waypoint not passed yet.
    pub next: usize,
    /// The leader reported the end.
    pub finished: bool,
}

impl ActiveRoute {
    /// What is left of it, for a new leader.
    #[must_use]
    pub fn remaining(&self) -> Option<Route> {
        let waypoints: Vec<PositionNed> = self.route.waypoints.iter().skip(self.next).copied().collect();
        (!self.finished && !waypoints.is_empty()).then(|| Route {
            waypoints,
            ..self.route.clone()
        })
    }

    /// Notes the waypoints that a leader at `position` has passed. A corner is rounded, so that near it counts as passed.
    pub fn advance(&mut self, position: &PositionNed) {
        let near_m = self.route.corner_radius_m + 2.0;
        while self.next + 1 < self.route.waypoints.len()
            && self
                .route
                .waypoints
                .get(self.next)
                .is_some_and(|w| w.horizontal_distance_m(position) < near_m)
        {
            self.next += 1;
        }
    }
}

/// Limits a plan is made under.
#[derive(Debug, Clone, Copy)]
pub struct PlanLimits {
    /// Motion within the formation.
    pub transition: MotionLimits,
    /// The gate's horizontal speed limit in metres per second.
    pub max_speed_m_s: f64,
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
    /// Limits.
    pub limits: PlanLimits,
    /// When the change is to begin.
    pub start: NodeTime,
}

/// Makes the plan of a formation change for those members that are available.
///
/// # Errors
/// When a named member or leader is not available, too few are, or no safe way into the slots is found.
pub fn plan(input: &PlanInput, peers: &PeerSnapshot) -> Result<Formation, Refusal> {
    let available = available(peers);
    let mut members = match &input.request.members {
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
    let leader = choose_leader(&input.request, input.before.as_ref(), &members)?;
    members.retain(|id| *id != leader);
    members.insert(0, leader);
    let slots = formation::slots(
        input.request.shape,
        members.len(),
        input.request.spacing_m,
        input.request.altitude_step_m,
    )
    .map_err(|e| Refusal::InvalidValue { detail: e.to_string() })?;
    let heading_now = heading_now(&input.request, leader, peers);
    let heading = choose_heading(input, &slots, heading_now);
    let from = present_offsets(input, &members, heading_now, peers)?;
    let limits = motion_limits(
        input,
        &from,
        &slots,
        &heading,
        peers.entry(leader).and_then(|e| e.anchor).as_ref(),
    );
    let planned = transition::plan(&from, &slots, &limits, input.start)
        .map_err(|e| Refusal::InvalidValue { detail: e.to_string() })?;
    Ok(Formation {
        request: FormationRequest {
            leader: Some(leader),
            ..input.request.clone()
        },
        leader,
        slots: members.iter().copied().zip(planned.moves).skip(1).collect(),
        members,
        heading,
        decided: input.start,
        settled_at: input.start.plus_seconds(planned.duration_s),
        min_distance_m: planned.min_distance_m,
    })
}

/// Vehicles in the air, heard, with a position and in the swarm's hands.
#[must_use]
pub fn available(peers: &PeerSnapshot) -> Vec<VehicleId> {
    peers
        .entries
        .iter()
        .filter(|e| e.link.connected && e.kinematics.is_some() && e.airborne && e.flight_state.is_available_in_air())
        .map(|e| e.id)
        .collect()
}

fn choose_leader(
    request: &FormationRequest,
    before: Option<&Formation>,
    members: &[VehicleId],
) -> Result<VehicleId, Refusal> {
    let asked = request.leader.filter(|id| members.contains(id));
    let present = before.map(|f| f.leader).filter(|id| members.contains(id));
    asked
        .or(present)
        .or_else(|| members.first().copied())
        .ok_or(Refusal::NotEnoughVehicles { have: 0, need: 1 })
}

/// The heading the formation has at this moment: its leader's anchor if it leads already, else the leader's yaw, which is what the
/// leader's model starts from.
fn heading_now(request: &FormationRequest, leader: VehicleId, peers: &PeerSnapshot) -> f64 {
    let entry = peers.entry(leader);
    if let Some(anchor) = entry.and_then(|e| e.anchor) {
        return anchor.heading_rad;
    }
    match request.heading {
        HeadingRequest::Fixed { heading_deg } => heading_deg.to_radians(),
        HeadingRequest::Auto | HeadingRequest::Course => entry
            .and_then(|e| e.kinematics)
            .map_or(0.0, |kinematics| kinematics.yaw_rad),
    }
}

fn choose_heading(input: &PlanInput, slots: &[OffsetFrd], heading_now: f64) -> FormationHeading {
    let speed_m_s = input.route_speed_m_s.unwrap_or(NOMINAL_SPEED_M_S);
    let max_rate_rad_s =
        limits::max_turn_rate_within_rad_s(slots, speed_m_s, input.limits.max_speed_m_s, TURN_ACCELERATION_M_S2);
    match input.request.heading {
        HeadingRequest::Fixed { heading_deg } => FormationHeading::Fixed {
            heading_rad: heading_deg.to_radians(),
        },
        HeadingRequest::Auto if max_rate_rad_s < SLOWEST_USEFUL_TURN_RAD_S => FormationHeading::Fixed {
            heading_rad: heading_now,
        },
        HeadingRequest::Auto | HeadingRequest::Course => FormationHeading::Course { max_rate_rad_s },
    }
}

/// The limits within the formation, beside what the formation as a whole does: its leader's speed and its turning take their share of
/// what a vehicle can fly.
fn motion_limits(
    input: &PlanInput,
    from: &[OffsetFrd],
    slots: &[OffsetFrd],
    heading: &FormationHeading,
    anchor: Option<&AnchorReference>,
) -> MotionLimits {
    let limits = input.limits.transition;
    let turns = anchor.is_some_and(|a| a.heading_rate_rad_s.abs() > 1e-3);
    let under_way = input.route_speed_m_s.is_some();
    let rate_rad_s = match heading {
        FormationHeading::Course { max_rate_rad_s } if under_way || turns => *max_rate_rad_s,
        _ => anchor.map_or(0.0, |a| a.heading_rate_rad_s.abs()),
    };
    let farthest_m = from
        .iter()
        .chain(slots)
        .map(|o| o.forward_m.hypot(o.right_m))
        .fold(0.0, f64::max);
    let taken_m_s = input.route_speed_m_s.unwrap_or(0.0) + rate_rad_s * farthest_m;
    let spare_m_s = input.limits.max_speed_m_s * limits::TURN_SPEED_SHARE - taken_m_s;
    MotionLimits {
        speed_m_s: limits.speed_m_s.min(spare_m_s.max(SLOWEST_CHANGE_M_S)),
        ..limits
    }
}

/// Where each member is relative to the leader when the change begins. A member of the formation flown until now is taken at its slot,
/// not where it was measured, so that its setpoint does not jump.
fn present_offsets(
    input: &PlanInput,
    members: &[VehicleId],
    heading_rad: f64,
    peers: &PeerSnapshot,
) -> Result<Vec<OffsetFrd>, Refusal> {
    let place = |id: &VehicleId| {
        peers
            .entry(*id)
            .and_then(|e| e.kinematics)
            .map(|k| k.position)
            .ok_or(Refusal::NoPosition)
    };
    let slot_offset = |id: &VehicleId| {
        let before = input.before.as_ref()?;
        if *id == before.leader {
            return Some(OffsetFrd::default());
        }
        before
            .slots
            .get(id)
            .map(|slot| transition::sample(slot, input.start).offset)
    };
    let Some(leader) = members.first() else {
        return Ok(Vec::new());
    };
    let leader_place = place(leader)?;
    // Offsets of the former slots are relative to the former leader: re-based on the new one where both have a slot.
    let base = slot_offset(leader);
    members
        .iter()
        .map(|id| match (slot_offset(id), base) {
            (Some(offset), Some(base)) => Ok(OffsetFrd::from(offset.vector() - base.vector())),
            _ => Ok(OffsetFrd::from_ned(
                place(id)?.vector() - leader_place.vector(),
                heading_rad,
            )),
        })
        .collect()
}

/// The intent that follows from formation and route. Tasks that do not change keep their version, so that nobody starts anew. Who was
/// withdrawn by an operator gets no task at all: a task of a newer version would outrank the operator's command.
#[must_use]
pub fn intent(before: &Intent, coordination: &Coordination, withdrawn: &BTreeSet<VehicleId>) -> Intent {
    let version = before.version + 1;
    let mut wanted: BTreeMap<VehicleId, Task> = BTreeMap::new();
    if let Some(formation) = &coordination.formation {
        let route = coordination.route.as_ref().map(|r| r.route.clone());
        wanted.insert(
            formation.leader,
            Task::Lead {
                route,
                heading: formation.heading,
            },
        );
        for (id, slot) in &formation.slots {
            wanted.insert(
                *id,
                Task::Follow {
                    leader: Some(formation.leader),
                    slot: *slot,
                },
            );
        }
    }
    // Who had a place in the formation and has none now is told to hold, once.
    for (id, task) in &before.tasks {
        if task.task != Task::Hold && !withdrawn.contains(id) {
            wanted.entry(*id).or_insert(Task::Hold);
        }
    }
    let tasks = wanted
        .into_iter()
        .filter(|(id, _)| !withdrawn.contains(id))
        .map(|(id, task)| match before.tasks.get(&id) {
            Some(same) if same.task == task => (id, same.clone()),
            _ => (id, VehicleTask { version, task }),
        })
        .collect();
    Intent {
        version,
        leader: coordination.formation.as_ref().map(|f| f.leader),
        tasks,
    }
}

#[cfg(test)]
mod tests;
