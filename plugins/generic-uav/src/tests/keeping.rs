//! Places among neighbours, trajectories, limits, and routes that begin in flight.

use super::autopilot::{Autopilot, PERIOD_S};
use super::rig::{Rig, create_with};
use super::tasks::{follow, lead, leader_anchor};
use crate::{GenericUav, Settings};
use skein_domain::exchange::{Effect, Event, PeerState};
use skein_domain::manifest::EffectKind;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorReference, FlightLimits, FlightState, Keeping, KeepingLaw, NeighbourPlace, NodeTime, PositionNed, Route,
    Task, Trajectory, VehicleCommand, VehicleId, VelocityNed,
};
use skein_flight::trajectory::{self, MotionState, Smoothness};
use skein_plugin_sdk::UavModel;

const LIMITS: FlightLimits = FlightLimits {
    max_speed_m_s: 8.0,
    max_climb_m_s: 1.5,
    max_descent_m_s: 1.0,
    max_acceleration_m_s2: 2.0,
    min_turn_radius_m: 0.0,
    endurance_s: None,
    keeps_view: false,
};

/// A leader belongs 8 m to the east.
pub fn keep_beside(start: NodeTime) -> Task {
    Task::Keep(Keeping {
        law: KeepingLaw::Bearings,
        neighbours: vec![NeighbourPlace {
            vehicle: VehicleId(1),
            north_m: 0.0,
            east_m: 8.0,
            down_m: 0.0,
            hops: Some(0),
        }],
        leader: Some(VehicleId(1)),
        start,
    })
}

pub fn peer(position: PositionNed, velocity: VelocityNed, measured: NodeTime) -> Event {
    Event::Peers(vec![PeerState {
        id: VehicleId(1),
        kinematics: VehicleKinematics {
            position,
            velocity,
            yaw_rad: 0.0,
            measured,
        },
        airborne: true,
    }])
}

/// From where the vehicle holds, in a while.
pub fn trajectory_from(rig: &Rig, legs: [[f64; 3]; 2], in_s: f64) -> Task {
    let here = rig.setpoints().last().and_then(|(_, s)| s.position).expect("streams");
    let waypoints = legs.map(|leg| here.moved(leg.into()));
    let start = rig.now.plus_seconds(in_s);
    let way = trajectory::plan(MotionState::at_rest(here), &waypoints, &LIMITS, start, Smoothness::Jerk);
    Task::Fly(way.expect("can be flown"))
}

/// A leader that flies north beside the vehicle and is heard in every period.
fn fly_beside(rig: &mut Rig, at: &mut PositionNed, speed_m_s: f64, seconds: f64) {
    let velocity = VelocityNed::new(speed_m_s, 0.0, 0.0);
    for _ in 0..(seconds / PERIOD_S).round() as u32 {
        *at = at.after(&velocity, PERIOD_S);
        rig.inbox.push(peer(*at, velocity, rig.now.plus_seconds(PERIOD_S)));
        rig.tick();
    }
}

fn finished(rig: &Rig) -> usize {
    rig.log.iter().filter(|(_, e)| *e == Effect::RouteFinished).count()
}

#[test]
fn a_place_among_neighbours_is_kept() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let mut leader = rig.here().moved([3.0, 10.0, 0.0].into());
    rig.task(keep_beside(rig.now));
    fly_beside(&mut rig, &mut leader, 4.0, 25.0);
    assert_eq!(rig.state, FlightState::Following);
    let off_m = rig.here().distance_m(&leader.moved([0.0, -8.0, 0.0].into()));
    assert!(off_m < 0.3, "{off_m} m off");
    // Told again, perhaps with other neighbours, it goes on.
    rig.task(keep_beside(rig.now));
    fly_beside(&mut rig, &mut leader, 4.0, 2.0);
    rig.assert_no_jump_since(start);
    // Nobody is heard any more: it holds and says so once.
    rig.run(10.0);
    assert!(
        rig.autopilot.velocity.norm() < 0.1 && rig.detail.contains("neighbour"),
        "{}",
        rig.detail
    );
    assert_eq!(
        rig.notices().iter().filter(|text| text.contains("neighbour")).count(),
        1
    );
    rig.assert_no_jump_since(start);
}

#[test]
fn a_place_is_kept_from_its_time_on() {
    let mut rig = Rig::holding(10.0);
    let mut leader = rig.here().moved([0.0, 8.0, 0.0].into());
    rig.task(keep_beside(rig.now.plus_seconds(3.0)));
    fly_beside(&mut rig, &mut leader, 1.0, 2.8);
    assert!(rig.state == FlightState::Holding && rig.autopilot.velocity.norm() < 0.1);
    fly_beside(&mut rig, &mut leader, 1.0, 2.0);
    assert!(rig.state == FlightState::Following && rig.autopilot.velocity.norm() > 0.5);
}

#[test]
fn a_trajectory_is_flown_on_the_clock() {
    let mut rig = Rig::holding(10.0);
    let began = rig.now;
    let task = trajectory_from(&rig, [[30.0, 0.0, -2.0], [30.0, 25.0, 0.0]], 2.0);
    let Task::Fly(way) = task.clone() else {
        panic!("it is one")
    };
    rig.task(task);
    rig.run(1.9);
    assert_eq!(rig.state, FlightState::Holding, "not before its time");
    let end_s = 2.1 + trajectory::duration_s(&way);
    let mut worst_m = 0.0_f64;
    while rig.now.seconds_since(began) < end_s {
        rig.tick();
        let wanted = trajectory::sample(&way, rig.now).position;
        let (_, setpoint) = rig.setpoints().pop().expect("streams");
        worst_m = worst_m.max(setpoint.position.expect("has one").distance_m(&wanted));
        let on_its_way = (2.5..end_s - 0.5).contains(&rig.now.seconds_since(began));
        assert!(!on_its_way || rig.state == FlightState::GoingTo);
    }
    assert!(worst_m < 0.05, "{worst_m} m beside the trajectory");
    rig.run(4.0);
    assert_eq!(finished(&rig), 1, "its end is told once");
    assert_eq!(rig.state, FlightState::Holding, "it is going nowhere any more");
    assert!(rig.here().distance_m(&trajectory::end(&way)) < 0.1 && rig.autopilot.velocity.norm() < 0.1);
    rig.assert_no_jump_since(began);
}

#[test]
fn a_trajectory_planned_anew_in_flight_is_taken_over_smoothly() {
    let mut rig = Rig::holding(10.0);
    let began = rig.now;
    let first = trajectory_from(&rig, [[60.0, 0.0, 0.0], [120.0, 10.0, 0.0]], 0.2);
    let Task::Fly(way) = first.clone() else {
        panic!("it is one")
    };
    rig.task(first);
    rig.run(9.0);
    let start = rig.now.plus_seconds(0.5);
    let then = trajectory::sample(&way, start);
    let state = MotionState {
        position: then.position,
        velocity: then.velocity,
        acceleration: then.acceleration,
    };
    assert!(then.velocity.norm() > 4.0);
    let waypoints = [then.position.moved([40.0, 30.0, 0.0].into())];
    let other = trajectory::plan(state, &waypoints, &LIMITS, start, Smoothness::Jerk).expect("can be flown");
    rig.task(Task::Fly(other.clone()));
    let mut slowest = f64::INFINITY;
    for _ in 0..100 {
        rig.tick();
        slowest = slowest.min(rig.autopilot.velocity.norm());
    }
    assert!(slowest > 3.0, "{slowest} m/s");
    rig.run(40.0);
    assert!(rig.here().distance_m(&waypoints[0]) < 0.2 && finished(&rig) == 1);
    rig.assert_no_jump_since(began);
}

#[test]
fn a_trajectory_that_cannot_be_flown_is_told_and_held() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    rig.task(Task::Fly(Trajectory {
        start: rig.now.plus_seconds(5.0),
        pieces: vec![],
        yaw_rad: None,
    }));
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::Holding);
    assert!(rig.notices().iter().any(|text| text.contains("cannot be flown")));
    rig.assert_no_jump_since(start);
}

#[test]
fn a_command_before_its_time_outranks_a_trajectory() {
    let mut rig = Rig::holding(10.0);
    let task = trajectory_from(&rig, [[30.0, 0.0, 0.0], [30.0, 25.0, 0.0]], 2.0);
    rig.task(task);
    rig.run(1.0);
    let hold = rig.command(VehicleCommand::Hold);
    rig.run(5.0);
    assert!(rig.is_done(hold) && rig.state == FlightState::Holding && rig.autopilot.velocity.norm() < 0.1);
}

#[test]
fn limits_are_said_once_by_every_instance() {
    let mut rig = Rig::holding(5.0);
    let said = |rig: &Rig| -> Vec<FlightLimits> {
        let of = |effect: &Effect| match effect {
            Effect::Limits(limits) => Some(*limits),
            _ => None,
        };
        rig.log.iter().filter_map(|(_, effect)| of(effect)).collect()
    };
    assert_eq!(said(&rig).len(), 1);
    assert!(said(&rig)[0].is_usable() && said(&rig)[0].max_speed_m_s == 12.0 && !said(&rig)[0].keeps_view);
    let settings = Settings {
        max_speed_m_s: 7.0,
        endurance_s: Some(1_200.0),
        keeps_view: Some(true),
        ..Settings::default()
    };
    rig.model = create_with(settings, Some(rig.model.snapshot()), 2, rig.now);
    rig.run(1.0);
    let last = said(&rig)[1];
    assert!(last.max_speed_m_s == 7.0 && last.endurance_s == Some(1_200.0) && last.keeps_view);
    assert!(GenericUav::MANIFEST.effects.contains(&EffectKind::Limits));
}

#[test]
fn nothing_is_flown_faster_than_the_vehicle_can() {
    let mut rig = Rig::new(Autopilot::default());
    let settings = Settings {
        max_speed_m_s: 3.0,
        ..Settings::default()
    };
    rig.model = create_with(settings, None, 1, rig.now);
    rig.tick();
    let id = rig.command(VehicleCommand::TakeOff { height_m: 10.0 });
    rig.run_until("taken off", 60.0, |rig| rig.is_done(id));
    let place = rig.here();
    rig.command(VehicleCommand::GoTo {
        position: place.moved([40.0, 0.0, 0.0].into()),
        yaw_rad: None,
        speed_m_s: Some(9.0),
    });
    rig.run(8.0);
    rig.task(lead(Some(Route {
        waypoints: vec![place.moved([80.0, 30.0, 0.0].into())],
        speed_m_s: 9.0,
        corner_radius_m: 5.0,
    })));
    rig.run(10.0);
    let speeds = rig
        .setpoints()
        .into_iter()
        .filter_map(|(_, s)| s.velocity)
        .map(|v| v.norm());
    let fastest = speeds.fold(0.0, f64::max);
    assert!(fastest > 2.8 && fastest < 3.05, "{fastest} m/s");
}

/// The slowest it is over some seconds.
fn slowest_m_s(rig: &mut Rig, seconds: f64) -> f64 {
    let mut slowest = f64::INFINITY;
    for _ in 0..(seconds / PERIOD_S).round() as u32 {
        rig.tick();
        slowest = slowest.min(rig.autopilot.velocity.norm());
    }
    slowest
}

#[test]
fn a_leader_given_another_route_in_flight_goes_on_at_its_speed() {
    for (turn, at_least) in [
        ([150.0, 0.0, 0.0], 7.0),
        ([100.0, 60.0, 0.0], 4.5),
        ([30.0, 100.0, 0.0], 3.5),
    ] {
        let mut rig = Rig::holding(10.0);
        let start = rig.now;
        let route = |rig: &Rig, leg: [f64; 3]| Route {
            waypoints: vec![rig.here().moved(leg.into())],
            speed_m_s: 8.0,
            corner_radius_m: 12.0,
        };
        rig.task(lead(Some(route(&rig, [300.0, 0.0, 0.0]))));
        rig.run(10.0);
        assert!(rig.autopilot.velocity.norm() > 7.5);
        let other = route(&rig, turn);
        let end = other.waypoints[0];
        rig.task(lead(Some(other)));
        let slowest = slowest_m_s(&mut rig, 6.0);
        assert!(slowest > at_least, "{turn:?}: {slowest} m/s");
        rig.run_until("at the end", 60.0, |rig| finished(rig) == 1);
        assert!(rig.here().distance_m(&end) < 1.0);
        rig.assert_no_jump_since(start);
    }
}

#[test]
fn a_new_leader_takes_the_rest_of_the_route_at_its_speed() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let velocity = VelocityNed::new(6.0, 0.0, 0.0);
    let mut anchor = AnchorReference {
        velocity,
        ..leader_anchor(&rig, rig.here())
    };
    rig.task(follow(3.0));
    for _ in 0..600 {
        anchor.time = rig.now;
        rig.anchor(anchor);
        anchor.position = anchor.position.after(&velocity, PERIOD_S);
        rig.tick();
    }
    assert!(rig.autopilot.velocity.norm() > 5.8);
    rig.task(lead(Some(Route {
        waypoints: vec![anchor.position.moved([60.0, 0.0, 0.0].into())],
        speed_m_s: 6.0,
        corner_radius_m: 10.0,
    })));
    let slowest = slowest_m_s(&mut rig, 5.0);
    assert!(slowest > 5.0 && rig.state == FlightState::Leading, "{slowest} m/s");
    rig.assert_no_jump_since(start);
}
