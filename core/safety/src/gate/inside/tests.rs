//! Fences at the gate: what is refused names its zone, and who flies at a fence at full speed stands before it.

use super::super::{Limits, Steered, Steering};
use super::*;
use crate::avoidance::Surroundings;
use crate::fence::tests::polygon_about;
use crate::fence::{Fence, Fences, Zone};
use proptest::prelude::*;
use skein_domain::{BreachAction, NodeTime, Route, VehicleCommand, VehicleId, ZoneKind};

const LIMITS: Limits = Limits {
    max_speed_m_s: 10.0,
    max_climb_m_s: 3.0,
    max_descent_m_s: 2.0,
    min_separation_m: 2.0,
    separation_horizon_s: 0.8,
};
const PERIOD_S: f64 = 0.02;
/// What a vehicle brakes with at least: a little more than the gate reckons with.
const BRAKING_M_S2: f64 = 3.2;
/// Two control periods and the time it takes to tilt.
const REACTION_S: f64 = 0.1;

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

fn zone(name: &str, kind: ZoneKind, half_m: f64, heights: [f64; 2]) -> Zone {
    let corners = vec![
        [-half_m, -half_m],
        [half_m, -half_m],
        [half_m, half_m],
        [-half_m, half_m],
    ];
    Zone {
        name: name.to_owned(),
        kind,
        action: BreachAction::Hold,
        volume: Fence::new(corners, heights[0], heights[1]).unwrap(),
    }
}

/// A field with a hall in its middle, over which there is room, and an airspace over that.
fn gate() -> Gate {
    let fences = Fences::new(vec![
        zone("field", ZoneKind::Inclusion, 100.0, [2.0, 80.0]),
        zone("hall", ZoneKind::Exclusion, 20.0, [-10.0, 30.0]),
        zone("airspace", ZoneKind::Exclusion, 60.0, [60.0, 200.0]),
    ]);
    Gate::new(LIMITS, fences)
}

fn named(verdict: Result<(), Refusal>, zone: &str) {
    match verdict {
        Err(Refusal::OutsideFence { detail }) => assert!(detail.contains(&format!("\"{zone}\"")), "{detail}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn goals_routes_landings_and_take_offs_name_the_zone() {
    let gate = gate();
    named(gate.goal(&at(0.0, 0.0, 20.0)), "hall");
    named(gate.goal(&at(150.0, 0.0, 20.0)), "field");
    assert_eq!(gate.goal(&at(0.0, 0.0, 40.0)), Ok(()));
    let route = |waypoints: Vec<PositionNed>| Route {
        waypoints,
        speed_m_s: 5.0,
        corner_radius_m: 0.0,
    };
    let (west, east) = (at(0.0, -50.0, 20.0), at(0.0, 50.0, 20.0));
    named(gate.route(&route(vec![west, east])), "hall");
    assert_eq!(gate.route(&route(vec![west, at(-40.0, 0.0, 20.0), east])), Ok(()));
    named(gate.route_from(&west, &route(vec![east])), "hall");
    let land = |spot: PositionNed| gate.command(&VehicleCommand::LandAt { spot }, None);
    named(land(at(5.0, 5.0, 0.0)), "hall");
    assert_eq!(
        land(at(50.0, 50.0, -3.0)),
        Ok(()),
        "under the airspace, under the floor"
    );
    let take_off = |ground: PositionNed, height_m| gate.command(&VehicleCommand::TakeOff { height_m }, Some(&ground));
    assert_eq!(take_off(at(50.0, 50.0, 0.0), 20.0), Ok(()));
    named(take_off(at(50.0, 50.0, 0.0), 70.0), "airspace");
    named(take_off(at(10.0, 10.0, 0.0), 40.0), "hall");
    assert_eq!(take_off(at(90.0, 50.0, 0.0), 70.0), Ok(()), "beside the airspace");
    let nowhere = gate.command(&VehicleCommand::TakeOff { height_m: 5.0 }, None);
    assert_eq!(nowhere, Err(Refusal::NoPosition));
}

fn asked(velocity: Vector3<f64>) -> Setpoint {
    Setpoint {
        velocity: Some(VelocityNed::from(velocity)),
        ..Setpoint::default()
    }
}

/// In the air, with nobody else about.
fn steer(gate: &Gate, own: &VehicleKinematics, velocity: Vector3<f64>, now: NodeTime) -> Steered {
    let own = Steering {
        id: VehicleId(1),
        kinematics: own,
        airborne: true,
        ground_down_m: None,
    };
    let surroundings = Surroundings::new(&[], &gate.avoidance(), now);
    gate.steer(&own, &asked(velocity), &surroundings, now)
        .expect("is within the limits")
}

#[test]
fn who_cannot_stop_any_more_is_only_given_what_turns_away_or_brakes() {
    let fences = Fences::new(vec![zone("field", ZoneKind::Inclusion, 100.0, [2.0, 80.0])]);
    let gate = Gate::new(LIMITS, fences);
    let own = VehicleKinematics {
        position: at(88.0, 0.0, 20.0),
        velocity: VelocityNed::new(9.0, 0.0, 0.0),
        ..VehicleKinematics::default()
    };
    let given = |v: [f64; 3]| steer(&gate, &own, v.into(), NodeTime(0));
    for too_fast_m_s in [9.0, 8.6] {
        let brakes = given([too_fast_m_s, 0.0, 0.0]).setpoint.velocity.unwrap_or_default();
        assert!(brakes.north_m_s < 7.0, "12 m are not enough from 9 m/s: {brakes:?}");
    }
    for (v, why) in [
        ([0.0, 9.0, 0.0], "along the boundary"),
        ([5.0, 0.0, 0.0], "slower"),
        ([-3.0, 0.0, 0.0], "away"),
    ] {
        assert_eq!(given(v).change, None, "{why}");
    }
}

/// The velocity that it is given in place of the wanted one.
fn given(gate: &Gate, own: &VehicleKinematics, wanted: Vector3<f64>, now: NodeTime) -> Vector3<f64> {
    let setpoint = steer(gate, own, wanted, now).setpoint;
    setpoint.velocity.expect("a velocity stays one").vector()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn flown_at_full_speed_into_a_fence_it_stands_before_it(
        (vertices, centre) in polygon_about(), north in -10.0..10.0, east in -10.0..10.0, down in -3.0..2.0,
    ) {
        let fences = Fences::from(Fence::new(vertices, 0.0, 60.0).unwrap());
        let level = f64::hypot(north, east).max(10.0) / 9.99;
        let wanted = Vector3::new(north / level, east / level, down);
        let gate = Gate::new(LIMITS, fences.clone());
        let mut own = VehicleKinematics { position: at(centre[0], centre[1], 30.0), ..VehicleKinematics::default() };
        for step in 0..1500_u64 {
            let target = given(&gate, &own, wanted, NodeTime(step * 20_000));
            let most = if target == wanted { 4.0 } else { BRAKING_M_S2 };
            let velocity = own.velocity.vector();
            own.velocity = (velocity + (target - velocity).cap_magnitude(most * PERIOD_S)).into();
            own.position = own.position.after(&own.velocity, PERIOD_S);
            let out_m = fences.excess(&own.position).distance_m();
            prop_assert!(out_m < 0.01, "{out_m} m out at {:?}", own.velocity);
        }
    }

    #[test]
    fn whatever_a_pilot_asks_for_no_fence_is_crossed_by_more_than_the_stopping_distance(
        (vertices, centre) in polygon_about(), asks in prop::collection::vec((-7.0..7.0, -7.0..7.0, -3.0..2.0), 10),
    ) {
        let fences = Fences::from(Fence::new(vertices, 0.0, 60.0).unwrap());
        let gate = Gate::new(LIMITS, fences.clone());
        let mut own = VehicleKinematics { position: at(centre[0], centre[1], 30.0), ..VehicleKinematics::default() };
        let mut fastest_m_s = 0.0_f64;
        for (index, ask) in asks.into_iter().enumerate() {
            let wanted = Vector3::new(ask.0, ask.1, ask.2);
            for step in 0..100_u64 {
                let now = NodeTime((index as u64 * 100 + step) * 20_000);
                let target = given(&gate, &own, wanted, now);
                let most = if target == wanted { 4.0 } else { BRAKING_M_S2 };
                let velocity = own.velocity.vector();
                own.velocity = (velocity + (target - velocity).cap_magnitude(most * PERIOD_S)).into();
                own.position = own.position.after(&own.velocity, PERIOD_S);
                let out_m = fences.excess(&own.position).distance_m();
                fastest_m_s = fastest_m_s.max(own.velocity.norm());
                let allowed_m = fastest_m_s * REACTION_S + 0.5 * fastest_m_s * fastest_m_s / MAX_BRAKING_M_S2;
                prop_assert!(out_m <= allowed_m, "{out_m} m out, {allowed_m} m to stop");
            }
        }
    }
}
