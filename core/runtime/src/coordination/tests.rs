//! What the coordinator decides, without actors: who leads, who takes part, which tasks keep their version.

use super::*;
use crate::board::PeerEntry;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{FlightState, LinkHealth, Shape, Telemetry};

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
    };
    PeerSnapshot {
        entries: (0..count).map(entry).collect(),
        peers: Vec::new(),
    }
}

fn request() -> FormationRequest {
    FormationRequest::new(Shape::Wedge, 5.0)
}

fn input(request: FormationRequest, before: Option<Formation>) -> PlanInput {
    let settings = skein_config::CoordinatorSettings::default();
    PlanInput {
        request,
        before,
        route_speed_m_s: None,
        limits: PlanLimits::new(&settings, 12.0),
        start: NodeTime::from_seconds(1.0),
    }
}

#[test]
fn the_lowest_id_leads_unless_asked_otherwise() {
    let peers = peers(5);
    assert_eq!(
        plan(&input(request(), None), &peers).expect("plans").leader,
        VehicleId(1)
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
fn tasks_that_do_not_change_keep_their_version() {
    let nobody = BTreeSet::new();
    let peers = peers(4);
    let first = plan(&input(request(), None), &peers).expect("plans");
    let mut coordination = Coordination {
        formation: Some(first.clone()),
        ..Coordination::default()
    };
    let before = intent(&Intent::default(), &coordination, &nobody);
    assert_eq!(before.version, 1);
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
    let after = intent(&before, &coordination, &nobody);
    assert_eq!(after.version, 2);
    // A wider wedge may turn slower, so that the leader's task may change too; the followers' must.
    assert!(
        after
            .tasks
            .iter()
            .filter(|(id, _)| **id != VehicleId(1))
            .all(|(_, task)| task.version == 2)
    );
    coordination.formation = None;
    let ended = intent(&after, &coordination, &nobody);
    assert!(
        ended
            .tasks
            .values()
            .all(|task| task.task == Task::Hold && task.version == 3)
    );
    assert!(
        intent(&ended, &coordination, &nobody).tasks.is_empty(),
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
    let before = intent(&Intent::default(), &coordination, &BTreeSet::new());
    let withdrawn = BTreeSet::from([VehicleId(2), VehicleId(3)]);
    let regrouped = intent(&before, &coordination, &withdrawn);
    assert!(withdrawn.iter().all(|id| !regrouped.tasks.contains_key(id)));
    assert!(regrouped.tasks.contains_key(&VehicleId(4)));
    coordination.formation = None;
    let ended = intent(&before, &coordination, &withdrawn);
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
