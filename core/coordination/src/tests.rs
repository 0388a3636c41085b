//! What the coordinator decides, without actors: who leads, who takes part, which tasks keep their version.

use crate::*;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorPlan, FlightState, FormationAnchor, FormationControl, FormationHeading, FormationRequest, HeadingRequest,
    Intent, LinkHealth, NodeTime, OffsetFrd, PositionNed, Refusal, Route, Shape, Task, Telemetry, VehicleId,
};
use skein_safety::{Fences, Gate, Limits};
use skein_view::PeerEntry;
use skein_view::PeerSnapshot;
use std::collections::BTreeSet;
use std::sync::Arc;

fn peers(count: u16) -> PeerSnapshot {
    let entry = |i: u16| PeerEntry {
        id: VehicleId(i + 1),
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(f64::from(i / 4) * 5.0, f64::from(i % 4) * 5.0, -6.0),
            ..VehicleKinematics::default()
        }),
        airborne: true,
        telemetry: Telemetry::default(),
        link: LinkHealth {
            connected: true,
            ..LinkHealth::default()
        },
        flight_state: FlightState::Holding,
        anchor: None,
        home: None,
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    };
    PeerSnapshot {
        entries: (0..count).map(entry).collect(),
        ..PeerSnapshot::default()
    }
}

fn request() -> FormationRequest {
    FormationRequest::new(Shape::Wedge, 5.0)
}

fn gate() -> Gate {
    let limits = Limits {
        max_speed_m_s: 12.0,
        max_climb_m_s: 4.0,
        max_descent_m_s: 3.0,
        min_separation_m: 2.0,
        separation_horizon_s: 0.8,
    };
    Gate::new(limits, None)
}

fn now() -> NodeTime {
    NodeTime::from_seconds(1.0)
}

fn input(request: FormationRequest, before: Option<Formation>) -> PlanInput {
    let settings = skein_config::CoordinatorSettings::default();
    PlanInput {
        request,
        before,
        route_speed_m_s: None,
        under_way: false,
        ahead: None,
        reference: None,
        limits: PlanLimits::new(&settings, 12.0),
        gate: Arc::new(gate()),
        start: NodeTime::from_seconds(1.0),
    }
}

#[test]
fn the_lowest_id_leads_unless_asked_otherwise() {
    let peers = peers(5);
    assert_eq!(
        plan(&input(request(), None), &peers).expect("plans").leader,
        Some(VehicleId(1))
    );
    let asked = FormationRequest {
        leader: Some(VehicleId(4)),
        ..request()
    };
    let formation = plan(&input(asked, None), &peers).expect("plans");
    assert_eq!(formation.members[0], VehicleId(4));
    assert_eq!(formation.slots.len(), 4);
    assert!(!formation.slots.contains_key(&VehicleId(4)));
    assert!(formation.min_distance_m >= 2.8);
}

#[test]
fn a_named_member_that_is_not_available_is_named_in_the_refusal() {
    let mut peers = peers(3);
    peers.entries[2].flight_state = FlightState::Landing;
    let with = |id: u16| FormationRequest {
        members: Some(vec![VehicleId(1), VehicleId(id)]),
        ..request()
    };
    assert!(matches!(
        plan(&input(with(3), None), &peers),
        Err(Refusal::WrongState {
            state: FlightState::Landing,
            ..
        })
    ));
    assert_eq!(
        plan(&input(with(9), None), &peers).err(),
        Some(Refusal::UnknownVehicle { vehicle: VehicleId(9) })
    );
}

#[test]
fn without_vehicles_there_is_no_formation() {
    assert!(matches!(
        plan(&input(request(), None), &peers(0)),
        Err(Refusal::NotEnoughVehicles { .. })
    ));
}

#[test]
fn a_change_starts_from_the_slots_not_from_what_was_measured() {
    let mut peers = peers(4);
    let first = plan(&input(request(), None), &peers).expect("plans");
    peers.entries[1].kinematics.as_mut().expect("placed").position.north_m += 0.7;
    let second_input = PlanInput {
        start: first.settled_at.plus_seconds(1.0),
        ..input(
            FormationRequest {
                shape: Shape::Line,
                ..request()
            },
            Some(first.clone()),
        )
    };
    let second = plan(&second_input, &peers).expect("plans");
    for (id, slot) in &second.slots {
        assert!((slot.from.vector() - first.slots[id].to.vector()).norm() < 1e-9, "{id}");
    }
}

#[test]
fn a_spacing_nobody_may_join_at_is_refused_to_who_is_alone_too() {
    let asked = |spacing_m| FormationRequest::new(Shape::Line, spacing_m);
    let refused = plan(&input(asked(0.5), None), &peers(1)).expect_err("too close");
    assert!(matches!(refused, Refusal::InvalidValue { .. }), "{refused}");
    plan(&input(asked(5.0), None), &peers(1)).expect("is flown by one");
    let free = FormationRequest {
        offsets: Some(vec![OffsetFrd::default()]),
        ..FormationRequest::new(Shape::Free, 0.5)
    };
    plan(&input(free, None), &peers(1)).expect("one place is far from no other");
}

#[test]
fn tasks_that_do_not_change_keep_their_version() {
    let nobody = BTreeSet::new();
    let peers = peers(4);
    let first = plan(&input(request(), None), &peers).expect("plans");
    let mut coordination = Coordination {
        formation: Some(first.clone()),
        ..Coordination::default()
    };
    let before = intent(&Intent::default(), &coordination, &nobody, now());
    assert_eq!(before.version, 2, "versions of coordinators are even");
    let later = PlanInput {
        start: first.settled_at,
        ..input(
            FormationRequest {
                spacing_m: 7.0,
                ..request()
            },
            Some(first),
        )
    };
    coordination.formation = Some(plan(&later, &peers).expect("plans"));
    let after = intent(&before, &coordination, &nobody, now());
    assert_eq!(after.version, 4);
    // A wider wedge may turn slower, so that the leader's task may change too; the followers' must.
    assert!(
        after
            .tasks
            .iter()
            .filter(|(id, _)| **id != VehicleId(1))
            .all(|(_, task)| task.version == 4)
    );
    coordination.formation = None;
    let ended = intent(&after, &coordination, &nobody, now());
    assert!(
        ended
            .tasks
            .values()
            .all(|task| task.task == Task::Hold && task.version == 6)
    );
    assert!(
        intent(&ended, &coordination, &nobody, now()).tasks.is_empty(),
        "told to hold once"
    );
}

#[test]
fn no_task_outranks_the_command_of_an_operator() {
    let peers = peers(4);
    let formation = plan(&input(request(), None), &peers).expect("plans");
    let mut coordination = Coordination {
        formation: Some(formation),
        ..Coordination::default()
    };
    let before = intent(&Intent::default(), &coordination, &BTreeSet::new(), now());
    let withdrawn = BTreeSet::from([VehicleId(2), VehicleId(3)]);
    let regrouped = intent(&before, &coordination, &withdrawn, now());
    assert!(withdrawn.iter().all(|id| !regrouped.tasks.contains_key(id)));
    assert!(regrouped.tasks.contains_key(&VehicleId(4)));
    coordination.formation = None;
    let ended = intent(&before, &coordination, &withdrawn, now());
    assert_eq!(
        ended.tasks.keys().copied().collect::<Vec<_>>(),
        [VehicleId(1), VehicleId(4)]
    );
}

#[test]
fn a_successor_flies_what_is_left_of_the_route() {
    let at = |north: f64, east: f64| PositionNed::new(north, east, -6.0);
    let route = Route {
        waypoints: vec![at(50.0, 0.0), at(50.0, 50.0), at(0.0, 50.0)],
        speed_m_s: 5.0,
        corner_radius_m: 8.0,
    };
    let mut active = ActiveRoute {
        route,
        next: 0,
        finished: false,
    };
    active.advance(&at(20.0, 0.0));
    assert_eq!(active.next, 0);
    active.advance(&at(44.0, 3.0));
    assert_eq!(active.next, 1);
    assert_eq!(active.remaining().expect("is left").waypoints.len(), 2);
    active.finished = true;
    assert!(active.remaining().is_none());
}

#[test]
fn the_configured_order_leads_then_health_then_the_lowest_id() {
    let mut peers = peers(4);
    let ids = [VehicleId(1), VehicleId(2), VehicleId(3), VehicleId(4)];
    peers.entries[0].telemetry.battery.remaining = Some(0.3);
    peers.entries[1].telemetry.battery.remaining = Some(0.9);
    peers.entries[2].telemetry.battery.remaining = Some(0.92);
    peers.entries[3].telemetry.battery.remaining = Some(0.4);
    let order = |configured: &[VehicleId]| by_fitness(&ids, configured, &peers);
    // A difference of two percent is none.
    assert_eq!(order(&[]), [VehicleId(2), VehicleId(3), VehicleId(4), VehicleId(1)]);
    assert_eq!(
        order(&[VehicleId(1), VehicleId(4)]),
        [VehicleId(1), VehicleId(4), VehicleId(2), VehicleId(3)]
    );
}

#[test]
fn when_the_leader_is_lost_another_leads_and_nobody_moves() {
    let mut peers = peers(5);
    let formation = plan(&input(request(), None), &peers).expect("plans");
    let later = formation.settled_at.plus_seconds(0.5);
    let place = |formation: &Formation, id: VehicleId| {
        formation
            .slots
            .get(&id)
            .map_or_else(nalgebra::Vector3::zeros, |slot| slot.to.vector())
    };
    peers.entries[0].link.connected = false;
    let next = succeed(&formation, VehicleId(1), later, &[VehicleId(4)], &peers).expect("has heirs");
    assert_eq!(next.leader, Some(VehicleId(4)));
    assert_eq!(next.members[0], VehicleId(4));
    assert!(!next.members.contains(&VehicleId(1)));
    for id in [2, 3, 5].map(VehicleId) {
        let before = place(&formation, id) - place(&formation, VehicleId(4));
        let slot = next.slots[&id];
        assert!((slot.to.vector() - before).norm() < 1e-9, "{id}");
        assert_eq!(slot.from, slot.to);
    }
    // Who does not lead is not succeeded.
    assert!(succeed(&formation, VehicleId(2), later, &[], &peers).is_none());
}

#[test]
fn a_formation_about_a_place_has_no_leader_and_everyone_a_slot() {
    let peers = peers(6);
    let asked = FormationRequest {
        anchor: skein_domain::FormationAnchor::Place {
            position: PositionNed::new(40.0, 10.0, -8.0),
            heading_deg: Some(90.0),
        },
        ..FormationRequest::new(Shape::Circle, 5.0)
    };
    let formation = plan(&input(asked, None), &peers).expect("plans");
    assert_eq!((formation.leader, formation.slots.len()), (None, 6));
    assert!(matches!(formation.anchor, Some(AnchorPlan::Place { .. })));
    let sum = formation
        .slots
        .values()
        .fold(nalgebra::Vector3::zeros(), |s, m| s + m.to.vector());
    assert!(sum.norm() < 1e-6, "centred: {sum:?}");
    let coordination = Coordination {
        formation: Some(formation),
        ..Coordination::default()
    };
    let intent = intent(&Intent::default(), &coordination, &BTreeSet::new(), now());
    assert!(intent.anchor.is_some() && intent.leader.is_none());
    assert!(
        intent
            .tasks
            .values()
            .all(|t| matches!(t.task, Task::Follow { leader: None, .. }))
    );
}

/// What the plan takes the formation's axes for is what every node finds them to be.
#[test]
fn the_first_formation_begins_where_everyone_is_whatever_its_heading() {
    let peers = peers(6);
    let place = |heading_deg| FormationAnchor::Place {
        position: PositionNed::new(40.0, 10.0, -6.0),
        heading_deg,
    };
    let path = FormationAnchor::Path {
        route: Route {
            waypoints: vec![PositionNed::new(30.0, 0.0, -6.0), PositionNed::new(60.0, 0.0, -6.0)],
            speed_m_s: 4.0,
            corner_radius_m: 5.0,
        },
    };
    let fixed = HeadingRequest::Fixed { heading_deg: 120.0 };
    let cases = [
        (place(Some(175.0)), HeadingRequest::Auto),
        (place(Some(175.0)), fixed),
        (place(None), HeadingRequest::Auto),
        (place(None), fixed),
        (path.clone(), HeadingRequest::Auto),
        (path, fixed),
    ];
    for (anchor, heading) in cases {
        let asked = FormationRequest {
            anchor,
            heading,
            ..request()
        };
        let formation = plan(&input(asked.clone(), None), &peers).expect("plans");
        let mut keeper = AnchorKeeper::default();
        let anchor = keeper.at(
            formation.anchor.as_ref(),
            None,
            &References::new(12.0),
            &Fences::default(),
            now(),
        );
        let anchor = anchor.expect("it is known where it is");
        for (id, slot) in &formation.slots {
            let begins = anchor.position.moved(slot.from.rotated(anchor.heading_rad));
            let is = peers.entry(*id).unwrap().kinematics.unwrap().position;
            assert!(
                begins.distance_m(&is) < 0.01,
                "{asked:?}: {id} at {is:?} begins at {begins:?}"
            );
        }
    }
}

/// Whoever is far outside of its place is carried round with the formation's turns.
#[test]
fn a_formation_turns_slowly_until_those_from_far_are_in_their_places() {
    let mut peers = peers(6);
    let asked = FormationRequest {
        heading: HeadingRequest::Course,
        ..request()
    };
    let near = plan(&input(asked.clone(), None), &peers).expect("plans");
    assert_eq!(near.heading_while_forming, near.heading);
    let last = peers.entries[5].kinematics.as_mut().unwrap();
    last.position.east_m += 400.0;
    let far = plan(&input(asked, None), &peers).expect("plans");
    assert_eq!(far.heading, near.heading);
    let FormationHeading::Course { max_rate_rad_s } = far.heading_while_forming else {
        panic!("{:?}", far.heading_while_forming)
    };
    assert!(max_rate_rad_s * 400.0 <= 4.0, "{max_rate_rad_s}");
    let coordination = Coordination {
        formation: Some(far.clone()),
        ..Coordination::default()
    };
    let heading_at = |time| {
        let intent = intent(&Intent::default(), &coordination, &BTreeSet::new(), time);
        match &intent.tasks[&VehicleId(1)].task {
            Task::Lead { heading, .. } => *heading,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(heading_at(now()), far.heading_while_forming);
    assert_eq!(heading_at(far.settled_at), far.heading);
}

#[test]
fn places_closer_than_the_smallest_separation_are_refused() {
    let offsets = vec![
        OffsetFrd::default(),
        OffsetFrd::new(-5.0, 0.0, 0.0),
        OffsetFrd::new(-5.0, 1.0, 0.0),
    ];
    let asked = FormationRequest {
        offsets: Some(offsets),
        ..FormationRequest::new(Shape::Free, 5.0)
    };
    let refused = plan(&input(asked, None), &peers(3)).expect_err("too close");
    assert!(matches!(refused, Refusal::InvalidValue { .. }), "{refused}");
    let shrunk = FormationRequest {
        scale: 0.3,
        ..request()
    };
    assert!(plan(&input(shrunk, None), &peers(3)).is_err());
}

#[test]
fn the_slowest_member_decides_how_fast_the_formation_goes() {
    let mut peers = peers(4);
    let slow = skein_domain::FlightLimits {
        max_speed_m_s: 5.0,
        max_climb_m_s: 1.0,
        max_descent_m_s: 1.0,
        max_acceleration_m_s2: 1.0,
        min_turn_radius_m: 12.0,
        endurance_s: None,
        keeps_view: false,
    };
    peers.entries[2].limits = Some(slow);
    let formation = plan(&input(request(), None), &peers).expect("plans");
    assert!(formation.max_speed_m_s <= 5.0);
    let settings = skein_config::CoordinatorSettings::default();
    let route = Route {
        waypoints: vec![PositionNed::new(100.0, 0.0, -6.0)],
        speed_m_s: 8.0,
        corner_radius_m: 5.0,
    };
    let limits = PlanLimits::new(&settings, 12.0);
    let mut coordination = Coordination {
        formation: Some(formation),
        ..Coordination::default()
    };
    let fitted = coordination
        .set_route(route, &peers, &limits, &gate())
        .expect("is inside");
    assert!(fitted.speed_m_s <= 5.0 && fitted.corner_radius_m >= 12.0, "{fitted:?}");
}

/// On a fast route there is less left to the outermost for turns.
#[test]
fn a_formation_that_follows_its_course_turns_as_fast_as_its_route_allows() {
    let peers = peers(6);
    let asked = FormationRequest {
        heading: HeadingRequest::Course,
        ..request()
    };
    let formation = plan(&input(asked, None), &peers).expect("plans");
    let limits = PlanLimits::new(&skein_config::CoordinatorSettings::default(), 12.0);
    let turns_rad_s = |speed_m_s: f64| {
        let route = Route {
            waypoints: vec![PositionNed::new(100.0, 0.0, -6.0)],
            speed_m_s,
            corner_radius_m: 5.0,
        };
        let mut coordination = Coordination {
            formation: Some(formation.clone()),
            ..Coordination::default()
        };
        let fitted = coordination.set_route(route, &peers, &limits, &gate()).unwrap();
        let formation = coordination.formation.unwrap();
        let FormationHeading::Course { max_rate_rad_s } = formation.heading else {
            panic!("{:?}", formation.heading)
        };
        let outermost_m_s = fitted.speed_m_s + max_rate_rad_s * formation.reach_m();
        // Of 12 m/s nine tenths; the outermost is not beside the leader but behind it.
        assert!(outermost_m_s < 13.0, "{outermost_m_s}");
        max_rate_rad_s
    };
    let (slow, fast) = (turns_rad_s(3.0), turns_rad_s(12.0));
    assert!(fast > 0.02 && fast < 0.8 * slow, "{fast} {slow}");
}

#[test]
fn members_keep_their_places_by_neighbours_only_once_they_are_formed() {
    let peers = peers(6);
    let asked = FormationRequest {
        control: FormationControl::Distances,
        ..request()
    };
    let formation = plan(&input(asked, None), &peers).expect("plans");
    assert_eq!(formation.keeping.len(), 5, "everyone but the leader");
    let settled = formation.settled_at;
    let coordination = Coordination {
        formation: Some(formation),
        ..Coordination::default()
    };
    let kept = |at: NodeTime| {
        let intent = intent(&Intent::default(), &coordination, &BTreeSet::new(), at);
        intent
            .tasks
            .values()
            .filter(|t| matches!(t.task, Task::Keep(_)))
            .count()
    };
    assert_eq!(kept(settled.plus_seconds(-0.1)), 0);
    assert_eq!(kept(settled.plus_seconds(0.1)), 5);
}

#[test]
fn who_is_not_heard_any_more_is_neither_a_newcomer_nor_a_stray() {
    let mut peers = peers(4);
    let formation = plan(&input(request(), None), &peers).expect("plans");
    for entry in &mut peers.entries {
        entry.flight_state = FlightState::Following;
    }
    peers.entries[0].flight_state = FlightState::Leading;
    peers.entries[3].link.connected = false;
    let withdrawn = BTreeSet::new();
    let judging = Judging {
        peers: &peers,
        withdrawn: &withdrawn,
        leader_lost_after_s: 1.0,
        leader_silence_s: 0.9,
        now: now(),
    };
    assert_eq!(judging.lost_leader(&formation), None);
    let silent = Judging {
        leader_silence_s: 1.1,
        ..judging
    };
    assert_eq!(silent.lost_leader(&formation), Some(VehicleId(1)));
    let changed = judging.changed(&formation, &[], false).expect("one is gone");
    assert_eq!(changed.gone, [VehicleId(4)]);
    assert_eq!(changed.members.len(), 3);
    // Regrouped without it: its model still says that it follows, and a newcomer may have fallen silent as well.
    let mut left = formation.clone();
    left.members.retain(|id| *id != VehicleId(4));
    assert_eq!(judging.changed(&left, &[VehicleId(4)], false), None);
}

#[test]
fn whose_camera_sees_nothing_but_the_others_is_told() {
    let mut peers = peers(9);
    let grid = || FormationRequest::new(Shape::Grid, 5.0);
    let nobody = plan(&input(grid(), None), &peers).expect("plans");
    assert_eq!(nobody.view_blocked, [], "nobody carries a camera");
    for entry in &mut peers.entries {
        entry.limits = Some(skein_domain::FlightLimits {
            max_speed_m_s: 10.0,
            max_climb_m_s: 3.0,
            max_descent_m_s: 3.0,
            max_acceleration_m_s2: 3.0,
            min_turn_radius_m: 0.0,
            endurance_s: None,
            keeps_view: true,
        });
    }
    // In three rows of three the one in the middle has others all around it.
    let formation = plan(&input(grid(), None), &peers).expect("plans");
    assert_eq!(formation.view_blocked.len(), 1, "{:?}", formation.view_blocked);
    assert_ne!(Some(formation.view_blocked[0]), formation.leader);
}
