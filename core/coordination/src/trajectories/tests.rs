//! Plans of trajectories without actors: what is refused and why, in step, from a motion, apart from others.

use super::*;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{FlightState, Geodetic, LinkHealth, Telemetry, TrajectoryStart};
use skein_safety::{Fence, Limits};

fn entry(id: u16, position: PositionNed) -> PeerEntry {
    PeerEntry {
        id: VehicleId(id),
        kinematics: Some(VehicleKinematics {
            position,
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
        home: Some(PositionNed::new(position.north_m, position.east_m, 0.0)),
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    }
}

/// Vehicles 10 m apart, from west to east, 10 m up.
fn peers(count: u16) -> PeerSnapshot {
    let place = |i: u16| PositionNed::new(0.0, f64::from(i) * 10.0, -10.0);
    PeerSnapshot {
        entries: (0..count).map(|i| entry(i + 1, place(i))).collect(),
        ..PeerSnapshot::default()
    }
}

fn now() -> NodeTime {
    NodeTime::from_seconds(100.0)
}

fn gate(fence: Option<Fence>) -> Arc<Gate> {
    let limits = Limits {
        max_speed_m_s: 12.0,
        max_climb_m_s: 4.0,
        max_descent_m_s: 3.0,
        min_separation_m: 2.0,
        separation_horizon_s: 6.0,
    };
    Arc::new(Gate::new(limits, fence))
}

/// Each of them along its waypoints, in two seconds.
fn input(ways: &[(u16, &[PositionNed])]) -> TrajectoryInput {
    let settings = skein_config::CoordinatorSettings::default();
    let journey = |(id, waypoints): &(u16, &[PositionNed])| JourneyRequest {
        vehicle: VehicleId(*id),
        waypoints: waypoints.to_vec(),
    };
    TrajectoryInput {
        request: TrajectoryRequest {
            vehicles: ways.iter().map(journey).collect(),
            kind: TrajectoryKind::Jerk,
            start: TrajectoryStart::Soon,
            max_speed_m_s: None,
            upload: false,
        },
        flights: BTreeMap::new(),
        members: Vec::new(),
        held: BTreeMap::new(),
        clock_faults: BTreeSet::new(),
        limits: PlanLimits::new(&settings, 12.0),
        gate: gate(None),
        frame: SwarmFrame::new(Geodetic {
            latitude_deg: 47.4,
            longitude_deg: 8.5,
            altitude_amsl_m: 488.0,
        }),
        now: now(),
        start: now().plus_seconds(2.0),
    }
}

fn at(north_m: f64, east_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -10.0)
}

/// What is against it, as words.
fn against(input: &TrajectoryInput, peers: &PeerSnapshot) -> Vec<(Option<u16>, &'static str)> {
    let objections = plan_trajectories(input, peers).expect_err("something is against it");
    let told = |o: &TrajectoryObjection| (o.vehicle.map(|v| v.0), o.refusal.code());
    objections.iter().map(told).collect()
}

#[test]
fn all_begin_at_one_time_and_pass_their_waypoints_at_one_time() {
    let input = input(&[
        (1, &[at(50.0, 0.0), at(90.0, -5.0)]),
        (2, &[at(10.0, 10.0), at(20.0, 14.0)]),
    ]);
    let planned = plan_trajectories(&input, &peers(3)).expect("can be flown");
    let (one, two) = (&planned.flights[&VehicleId(1)], &planned.flights[&VehicleId(2)]);
    assert_eq!((one.trajectory.start, two.trajectory.start), (input.start, input.start));
    assert_eq!(one.plan.passes_s, two.plan.passes_s);
    for (flight, waypoints) in [(one, &input.request.vehicles[0]), (two, &input.request.vehicles[1])] {
        for (passed_s, waypoint) in flight.plan.passes_s.iter().zip(&waypoints.waypoints) {
            let sample = trajectory::sample(&flight.trajectory, input.start.plus_seconds(*passed_s));
            assert!(sample.position.distance_m(waypoint) < 1e-3);
        }
    }
    assert!((one.plan.length_m - 90.3).abs() < 2.0, "{}", one.plan.length_m);
    assert!((planned.plan.starts_in_s - 2.0).abs() < 1e-9);
    // At the start they are nearest, and vehicle 3 that stands beside them is no nearer.
    let nearest_m = planned.plan.min_distance_m.expect("there are others");
    assert!((9.0..=10.0).contains(&nearest_m), "{nearest_m}");
    assert!(planned.routes.is_empty());
}

#[test]
fn everything_about_a_vehicle_that_is_against_it_is_told_at_once() {
    let mut peers = peers(6);
    peers.entries[1].link.connected = false;
    peers.entries[2].flight_state = FlightState::Landing;
    peers.entries[3].kinematics = None;
    peers.entries[4].under_order = true;
    let way: &[PositionNed] = &[at(30.0, 0.0)];
    let mut input = input(&[(1, way), (2, way), (3, way), (4, way), (5, way), (6, way), (9, way)]);
    input.members = vec![VehicleId(1)];
    input.clock_faults.insert(VehicleId(6));
    input.request.max_speed_m_s = Some(30.0);
    assert_eq!(
        against(&input, &peers),
        [
            (None, "too_fast"),
            (Some(1), "wrong_state"),
            (Some(2), "link_lost"),
            (Some(3), "wrong_state"),
            (Some(4), "no_position"),
            (Some(5), "wrong_state"),
            (Some(6), "clock"),
            (Some(9), "unknown_vehicle"),
        ]
    );
}

#[test]
fn whoever_turns_with_a_radius_flies_no_trajectory() {
    let mut peers = peers(1);
    peers.entries[0].limits = Some(FlightLimits {
        max_speed_m_s: 20.0,
        max_climb_m_s: 3.0,
        max_descent_m_s: 3.0,
        max_acceleration_m_s2: 4.0,
        min_turn_radius_m: 40.0,
        endurance_s: None,
        keeps_view: false,
    });
    assert_eq!(
        against(&input(&[(1, &[at(30.0, 0.0)])]), &peers),
        [(Some(1), "not_supported")]
    );
}

#[test]
fn ways_that_meet_are_refused_pair_by_pair() {
    let crossing = input(&[(1, &[at(20.0, 20.0)]), (2, &[at(20.0, 19.0)]), (3, &[at(-30.0, 20.0)])]);
    assert_eq!(against(&crossing, &peers(3)), [(Some(1), "too_close")]);
    // One above the other is not enough if it is no more than the height that downwash takes.
    let above = |up_m: f64| input(&[(1, &[PositionNed::new(0.0, 10.0, -10.0 - up_m)])]);
    assert_eq!(against(&above(3.0), &peers(2)), [(Some(1), "too_close")]);
    assert!(plan_trajectories(&above(5.0), &peers(2)).is_ok());
}

#[test]
fn who_flies_elsewhere_is_met_where_it_will_be() {
    let mut first = input(&[(1, &[at(15.0, 5.0), at(60.0, -20.0)])]);
    let planned = plan_trajectories(&first, &peers(2)).expect("can be flown");
    // Half of the second's way is the first's waypoint: refused where both would be there at one time.
    let mut second = input(&[(2, &[at(30.0, 0.0)])]);
    let alone = plan_trajectories(&second, &peers(2)).expect("can be flown");
    let passed_s = planned.flights[&VehicleId(1)].plan.passes_s[0];
    second.start = first.start.plus_seconds(passed_s - 0.5 * alone.plan.duration_s);
    second.flights = planned.flights.clone();
    let mut peers = peers(2);
    peers.entries[0].flight_state = FlightState::GoingTo;
    assert_eq!(against(&second, &peers), [(Some(2), "too_close")]);
    let met_at = second.start;
    second.start = first.start.plus_seconds(0.8 * planned.plan.duration_s);
    second.now = second.start.plus_seconds(-1.0);
    assert!(plan_trajectories(&second, &peers).is_ok());
    // Who has left its trajectory is where it stands.
    let flight = second.flights.get_mut(&VehicleId(1)).expect("is there");
    flight.ended = Some("commanded otherwise".into());
    second.start = met_at;
    second.now = now();
    assert!(plan_trajectories(&second, &peers).is_ok());
    first.members = vec![VehicleId(1)];
    assert_eq!(against(&first, &peers)[0].1, "wrong_state");
}

#[test]
fn one_that_is_under_way_goes_on_from_its_motion() {
    let first = input(&[(1, &[at(80.0, 0.0)])]);
    let planned = plan_trajectories(&first, &peers(1)).expect("can be flown");
    let before = planned.flights[&VehicleId(1)].trajectory.clone();
    let mut second = input(&[(1, &[at(60.0, 30.0)])]);
    second.flights = planned.flights;
    second.now = first.start.plus_seconds(5.0);
    second.start = second.now.plus_seconds(0.6);
    let mut peers = peers(1);
    peers.entries[0].flight_state = FlightState::GoingTo;
    let measured = trajectory::sample(&before, second.now);
    peers.entries[0].kinematics = Some(VehicleKinematics {
        position: measured.position,
        velocity: measured.velocity,
        measured: second.now,
        ..VehicleKinematics::default()
    });
    let anew = plan_trajectories(&second, &peers).expect("can be flown");
    let after = &anew.flights[&VehicleId(1)].trajectory;
    let (old, new) = (
        trajectory::sample(&before, second.start),
        trajectory::sample(after, second.start),
    );
    assert!(old.velocity.norm() > 3.0);
    assert!(old.position.distance_m(&new.position) < 1e-6);
    assert!((old.velocity.vector() - new.velocity.vector()).norm() < 1e-6);
    assert!((old.acceleration.vector() - new.acceleration.vector()).norm() < 1e-6);
    // Not from a way that it is not on.
    if let Some(kinematics) = &mut peers.entries[0].kinematics {
        kinematics.position = kinematics.position.moved([0.0, 6.0, 0.0].into());
    }
    assert_eq!(against(&second, &peers), [(Some(1), "not_permitted")]);
}

#[test]
fn fences_and_ground_bound_the_whole_way() {
    let corners = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]].to_vec();
    let fence = Fence::new(corners, -1.0, 40.0).expect("is one");
    let mut outside = input(&[(1, &[at(20.0, 0.0), at(80.0, 0.0)])]);
    outside.gate = gate(Some(fence.clone()));
    let objections = plan_trajectories(&outside, &peers(1)).expect_err("leads out");
    assert!(objections[0].to_string().contains("waypoint 2"), "{}", objections[0]);
    // Waypoints inside, and a way so near to the fence that a vehicle may swing over it.
    let mut near = input(&[(1, &[at(49.5, 0.0), at(0.0, 30.0)])]);
    near.gate = gate(Some(fence));
    assert_eq!(against(&near, &peers(1)), [(Some(1), "outside_fence")]);
    let low = input(&[(1, &[PositionNed::new(30.0, 0.0, -1.0)])]);
    assert_eq!(against(&low, &peers(1)), [(Some(1), "invalid_value")]);
}

#[test]
fn a_mission_has_every_waypoint_and_its_speeds() {
    let waypoints = [at(40.0, 0.0), at(40.0, 40.0), at(0.0, 40.0)];
    let mut input = input(&[(1, &waypoints)]);
    input.request.upload = true;
    let planned = plan_trajectories(&input, &peers(1)).expect("can be flown");
    let route = &planned.routes[&VehicleId(1)];
    assert!(route.len() <= MISSION_POINTS);
    for waypoint in waypoints {
        let near = |point: &RoutePoint| input.frame.position(&point.place).distance_m(&waypoint) < 0.05;
        assert!(route.iter().any(near), "{waypoint:?}");
    }
    let speeds = route.iter().filter_map(|point| point.speed_m_s);
    assert!(speeds.clone().count() == route.len() && speeds.fold(0.0, f64::max) <= 12.0);
}

#[test]
fn a_trajectory_is_a_task_until_it_has_ended() {
    use crate::{Coordination, intent};
    use skein_domain::{Intent, Task};
    let planned = plan_trajectories(&input(&[(1, &[at(30.0, 0.0)]), (2, &[at(30.0, 10.0)])]), &peers(2));
    let mut coordination = Coordination {
        flights: planned.expect("can be flown").flights,
        ..Coordination::default()
    };
    let nobody = BTreeSet::new();
    let first = intent(&Intent::default(), &coordination, &nobody, now());
    assert!(first.tasks.values().all(|t| matches!(t.task, Task::Fly(_))) && first.tasks.len() == 2);
    let same = intent(&first, &coordination, &nobody, now());
    assert_eq!(same.tasks, first.tasks, "nobody begins anew");
    // One is commanded by an operator, whose command no task may outrank; the other is told to hold when all is ended.
    let withdrawn = BTreeSet::from([VehicleId(1)]);
    for flight in coordination.flights.values_mut() {
        flight.ended = Some("ended by an operator".into());
    }
    let ended = intent(&same, &coordination, &withdrawn, now());
    assert_eq!(ended.tasks.keys().collect::<Vec<_>>(), [&VehicleId(2)]);
    assert_eq!(ended.tasks[&VehicleId(2)].task, Task::Hold);
}
