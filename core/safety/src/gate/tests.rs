//! The gate as a whole: what passes stays inside, and every refusal carries what it should.

use super::*;
use crate::fence::Fence;
use crate::fence::tests::polygon_about;
use nalgebra::Vector3;
use proptest::prelude::*;
use skein_domain::AccelerationNed;

const NOW: NodeTime = NodeTime(10_000_000);
const OWN: VehicleId = VehicleId(1);
const LIMITS: Limits = Limits {
    max_speed_m_s: 10.0,
    max_climb_m_s: 3.0,
    max_descent_m_s: 2.0,
    min_separation_m: 2.0,
    separation_horizon_s: 0.8,
};

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

fn standing(position: PositionNed) -> VehicleKinematics {
    VehicleKinematics {
        position,
        measured: NOW,
        ..VehicleKinematics::default()
    }
}

fn square() -> Fence {
    Fence::new(vec![[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]], 2.0, 50.0).unwrap()
}

fn gate() -> Gate {
    Gate::new(LIMITS, Some(square()))
}

fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn what_passes_never_leaves_the_fence_within_the_horizon(
        (vertices, centre) in polygon_about(), own in vector(25.0), to in prop::option::of(vector(20.0)),
        velocity in prop::option::of(vector(6.0)), acceleration in prop::option::of(vector(6.0)),
    ) {
        let fence = Fence::new(vertices, 2.0, 60.0).unwrap();
        let own = at(centre[0] + own.x, centre[1] + own.y, 30.0 + own.z);
        prop_assume!(fence.contains(&own).is_ok());
        let gate = Gate::new(LIMITS, Some(fence.clone()));
        let setpoint = Setpoint {
            position: to.map(|d| own.moved(d)),
            velocity: velocity.map(|v| Vector3::new(v.x, v.y, v.z.clamp(-3.0, 2.0)).into()),
            acceleration: acceleration.map(AccelerationNed::from),
            ..Setpoint::default()
        };
        if gate.setpoint(OWN, &standing(own), true, &setpoint, &[], NOW).is_err() {
            return Ok(());
        }
        // The way to the asked position, and on from there as the velocity says, braking along it as far as the acceleration is
        // believed.
        let base = setpoint.position.unwrap_or(own);
        let v = setpoint.velocity.unwrap_or_default().vector();
        let braking = setpoint.acceleration.map_or(0.0, |a| braking_m_s2(&v.into(), &a.vector()));
        for k in 0..=100 {
            let share = f64::from(k) / 100.0;
            let there = own.vector().lerp(&base.vector(), share);
            prop_assert!(fence.excess(&there.into()).outside_m < 1e-5);
            let (mut t, speed) = (share * LIMITS.separation_horizon_s, v.norm());
            if braking > 0.0 {
                t = t.min(speed / braking);
            }
            let driven_m = speed * t - 0.5 * braking * t * t;
            let on = if speed > 0.0 { base.moved(v * (driven_m / speed)) } else { base };
            let excess = fence.excess(&on);
            prop_assert!(excess.outside_m < 1e-5 && excess.above_m < 1e-9 && excess.below_m < 1e-9, "{excess:?}");
        }
    }

    #[test]
    fn speeds_over_the_limits_are_refused_and_others_pass(velocity in vector(14.0)) {
        let setpoint = Setpoint { velocity: Some(velocity.into()), ..Setpoint::default() };
        let verdict = Gate::new(LIMITS, None).setpoint(OWN, &standing(at(0.0, 0.0, 10.0)), true, &setpoint, &[], NOW);
        let level = velocity.xy().norm();
        match verdict {
            Ok(passed) => {
                prop_assert_eq!(passed, setpoint);
                prop_assert!(level <= 10.0 + 1e-6 && -velocity.z <= 3.0 + 1e-6 && velocity.z <= 2.0 + 1e-6);
            }
            Err(Refusal::TooFast { speed_m_s, limit_m_s }) => {
                prop_assert!(speed_m_s > limit_m_s);
                let known = [(level, 10.0), (-velocity.z, 3.0), (velocity.z, 2.0)];
                let named = |(speed, limit): &(f64, f64)| (speed - speed_m_s).abs() < 1e-9 && *limit == limit_m_s;
                prop_assert!(known.iter().any(named));
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn nothing_that_is_not_finite_passes(
        field in 0_usize..12, odd in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]), fenced in any::<bool>(),
    ) {
        let mut n = [50.0, 50.0, -10.0, 1.0, 1.0, 0.0, 0.1, 0.1, 0.0, 0.5, 0.1, 0.3];
        n[field] = odd;
        let setpoint = Setpoint {
            position: Some(PositionNed::new(n[0], n[1], n[2])),
            velocity: Some(VelocityNed::new(n[3], n[4], n[5])),
            acceleration: Some(AccelerationNed::new(n[6], n[7], n[8])),
            yaw_rad: Some(n[9]),
            yaw_rate_rad_s: Some(n[10]),
            drag_per_s: Some(n[11]),
        };
        let gate = Gate::new(LIMITS, fenced.then(square));
        let verdict = gate.setpoint(OWN, &standing(at(50.0, 50.0, 10.0)), true, &setpoint, &[], NOW);
        prop_assert!(matches!(verdict, Err(Refusal::InvalidValue { .. })), "{verdict:?}");
        if field < 3 {
            let place = PositionNed::new(n[0], n[1], n[2]);
            prop_assert!(gate.goal(&place).is_err());
            let land = VehicleCommand::LandAt { spot: place };
            prop_assert!(gate.command(&land, None).is_err());
            let go = VehicleCommand::GoTo { position: place, yaw_rad: None, speed_m_s: None };
            prop_assert!(gate.command(&go, None).is_err());
            let own = standing(place);
            let hold = Setpoint::hold(at(50.0, 50.0, 10.0), None);
            prop_assert_eq!(gate.setpoint(OWN, &own, true, &hold, &[], NOW), Err(Refusal::NoPosition));
        }
        prop_assert!(gate.formation(odd).is_err());
        let take_off = VehicleCommand::TakeOff { height_m: odd };
        prop_assert!(gate.command(&take_off, Some(&at(50.0, 50.0, 0.0))).is_err());
        let route = Route { waypoints: vec![at(10.0, 10.0, 10.0)], speed_m_s: odd, corner_radius_m: 5.0 };
        prop_assert!(gate.route(&route).is_err());
        let round = Route { speed_m_s: 5.0, corner_radius_m: odd, ..route };
        prop_assert!(gate.route(&round).is_err());
    }
}

#[test]
fn a_setpoint_without_position_and_velocity_is_refused() {
    let only_yaw = Setpoint {
        yaw_rad: Some(1.0),
        ..Setpoint::default()
    };
    let verdict = gate().setpoint(OWN, &standing(at(50.0, 50.0, 10.0)), true, &only_yaw, &[], NOW);
    assert!(matches!(verdict, Err(Refusal::InvalidValue { .. })));
}

#[test]
fn a_velocity_that_leads_out_is_refused_unless_it_brakes() {
    let own = standing(at(97.0, 50.0, 10.0));
    let fast = Setpoint {
        velocity: Some(VelocityNed::new(5.0, 0.0, 0.0)),
        ..Setpoint::default()
    };
    let verdict = gate().setpoint(OWN, &own, true, &fast, &[], NOW);
    assert_eq!(
        verdict,
        Err(Refusal::OutsideFence {
            detail: "\"fence\": 1.0 m beyond the boundary".to_owned()
        })
    );
    // On the way to a goal right at the boundary: 1.5 m at 3 m/s², just enough for 3 m/s.
    let arriving = Setpoint {
        position: Some(at(98.5, 50.0, 10.0)),
        velocity: Some(VelocityNed::new(3.0, 0.0, 0.0)),
        acceleration: Some(AccelerationNed::new(-3.0, 0.0, 0.0)),
        ..Setpoint::default()
    };
    assert!(gate().setpoint(OWN, &own, true, &arriving, &[], NOW).is_ok());
    // More braking than a vehicle has is not believed.
    let hopeful = Setpoint {
        velocity: Some(VelocityNed::new(8.0, 0.0, 0.0)),
        acceleration: Some(AccelerationNed::new(-50.0, 0.0, 0.0)),
        ..arriving
    };
    assert!(gate().setpoint(OWN, &own, true, &hopeful, &[], NOW).is_err());
}

#[test]
fn who_is_outside_may_come_back_but_not_go_further() {
    let own = standing(at(110.0, 50.0, 10.0));
    let fly = |v: [f64; 3]| Setpoint {
        velocity: Some(Vector3::from(v).into()),
        ..Setpoint::default()
    };
    let judge = |setpoint: &Setpoint| gate().setpoint(OWN, &own, true, setpoint, &[], NOW);
    assert!(judge(&fly([-5.0, 0.0, 0.0])).is_ok());
    assert!(judge(&Setpoint::hold(at(90.0, 50.0, 10.0), None)).is_ok());
    assert!(judge(&Setpoint::hold(own.position, None)).is_ok());
    assert!(judge(&fly([1.0, 0.0, 0.0])).is_err());
    assert!(judge(&Setpoint::hold(at(112.0, 50.0, 10.0), None)).is_err());
    // Nearer to the boundary, but now through the ceiling.
    assert!(judge(&Setpoint::hold(at(105.0, 50.0, 60.0), None)).is_err());
}

#[test]
fn on_the_ground_neither_floor_nor_neighbours_count() {
    let own = standing(at(50.0, 50.0, 0.0));
    let neighbour = Peer {
        id: VehicleId(2),
        kinematics: standing(at(50.0, 51.0, 0.5)),
        airborne: true,
    };
    let hold = Setpoint {
        velocity: Some(VelocityNed::new(0.0, 1.0, 0.0)),
        ..Setpoint::hold(at(50.0, 50.1, 0.1), None)
    };
    assert!(gate().setpoint(OWN, &own, false, &hold, &[neighbour], NOW).is_ok());
    assert!(
        gate()
            .setpoint(OWN, &own, false, &Setpoint::hold(at(150.0, 50.0, 10.0), None), &[], NOW)
            .is_err()
    );
    // In the air they do.
    let own = standing(at(50.0, 50.0, 10.0));
    let neighbour = Peer {
        kinematics: standing(at(50.0, 52.5, 10.0)),
        ..neighbour
    };
    let towards = Setpoint {
        velocity: Some(VelocityNed::new(0.0, 1.0, 0.0)),
        ..Setpoint::default()
    };
    let verdict = gate().setpoint(OWN, &own, true, &towards, &[neighbour], NOW);
    let Err(Refusal::TooClose {
        other,
        distance_m,
        limit_m,
    }) = verdict
    else {
        panic!("{verdict:?}")
    };
    assert_eq!((other, limit_m), (VehicleId(2), 2.0));
    assert!((distance_m - 1.7).abs() < 1e-9);
}

#[test]
fn commands_are_checked_where_they_lead() {
    let ground = at(50.0, 50.0, 0.0);
    let judge = |command: VehicleCommand| gate().command(&command, Some(&ground));
    assert_eq!(judge(VehicleCommand::TakeOff { height_m: 10.0 }), Ok(()));
    assert!(matches!(
        judge(VehicleCommand::TakeOff { height_m: 60.0 }),
        Err(Refusal::OutsideFence { .. })
    ));
    assert!(matches!(
        judge(VehicleCommand::TakeOff { height_m: -5.0 }),
        Err(Refusal::InvalidValue { .. })
    ));
    let unknown = gate().command(&VehicleCommand::TakeOff { height_m: 10.0 }, None);
    assert_eq!(unknown, Err(Refusal::NoPosition));
    assert_eq!(
        Gate::new(LIMITS, None).command(&VehicleCommand::TakeOff { height_m: 10.0 }, None),
        Ok(())
    );
    let outside = gate().command(&VehicleCommand::TakeOff { height_m: 10.0 }, Some(&at(-5.0, 50.0, 0.0)));
    assert!(matches!(outside, Err(Refusal::OutsideFence { .. })));
}

#[test]
fn landing_spots_and_goals_are_checked() {
    let judge = |command: VehicleCommand| gate().command(&command, None);
    assert_eq!(
        judge(VehicleCommand::LandAt {
            spot: at(10.0, 10.0, -3.0)
        }),
        Ok(()),
        "the ground may be low"
    );
    assert!(matches!(
        judge(VehicleCommand::LandAt {
            spot: at(-1.0, 10.0, 0.0)
        }),
        Err(Refusal::OutsideFence { .. })
    ));

    let go = |position, yaw_rad, speed_m_s| {
        judge(VehicleCommand::GoTo {
            position,
            yaw_rad,
            speed_m_s,
        })
    };
    let inside = at(10.0, 10.0, 10.0);
    assert_eq!(go(inside, Some(1.0), Some(10.0)), Ok(()));
    assert_eq!(
        go(inside, None, Some(12.0)),
        Err(Refusal::TooFast {
            speed_m_s: 12.0,
            limit_m_s: 10.0
        })
    );
    assert!(matches!(go(inside, None, Some(0.0)), Err(Refusal::InvalidValue { .. })));
    assert!(matches!(
        go(inside, Some(f64::NAN), None),
        Err(Refusal::InvalidValue { .. })
    ));
    assert!(matches!(
        go(at(10.0, 10.0, 1.0), None, None),
        Err(Refusal::OutsideFence { .. })
    ));
    for command in [
        VehicleCommand::Arm,
        VehicleCommand::Disarm,
        VehicleCommand::Land,
        VehicleCommand::Hold,
        VehicleCommand::Return,
    ] {
        assert_eq!(judge(command), Ok(()));
    }
}

#[test]
fn the_autopilot_is_not_asked_for_what_ends_a_flight() {
    let judge = |command: AutopilotCommand, airborne| gate().autopilot(&command, airborne);
    let not_permitted = |verdict| matches!(verdict, Err(Refusal::NotPermitted { .. }));
    assert!(not_permitted(judge(AutopilotCommand::Disarm, true)));
    assert!(not_permitted(judge(AutopilotCommand::EmergencyStop, true)));
    assert!(not_permitted(judge(AutopilotCommand::EmergencyStop, false)));
    assert_eq!(judge(AutopilotCommand::Disarm, false), Ok(()));
    assert!(not_permitted(judge(AutopilotCommand::TakeOff { height_m: 5.0 }, true)));
    assert_eq!(judge(AutopilotCommand::TakeOff { height_m: 5.0 }, false), Ok(()));
    assert!(matches!(
        judge(AutopilotCommand::TakeOff { height_m: f64::NAN }, false),
        Err(Refusal::InvalidValue { .. })
    ));
    assert!(not_permitted(judge(
        AutopilotCommand::SetMode {
            mode: FlightMode::Offboard
        },
        true
    )));
    assert!(not_permitted(judge(
        AutopilotCommand::SetMode {
            mode: FlightMode::Termination
        },
        false
    )));
    assert!(
        judge(
            AutopilotCommand::SetMode {
                mode: FlightMode::Unknown
            },
            false
        )
        .is_err()
    );
    assert_eq!(
        judge(AutopilotCommand::SetMode { mode: FlightMode::Hold }, true),
        Ok(())
    );
    for command in [
        AutopilotCommand::Land,
        AutopilotCommand::ReturnToLaunch,
        AutopilotCommand::EnterOffboard,
        AutopilotCommand::Arm,
    ] {
        assert_eq!(judge(command, true), Ok(()));
    }
}

#[test]
fn formations_and_routes_keep_to_the_limits() {
    // The smallest separation, and room for errors of position.
    assert_eq!(gate().formation(2.6), Ok(()));
    assert!(gate().formation(2.5).is_err());
    let Err(Refusal::InvalidValue { detail }) = gate().formation(1.5) else {
        panic!("too tight")
    };
    assert!(detail.contains("1.5") && detail.contains("2.6"), "{detail}");

    let route = Route {
        waypoints: vec![at(10.0, 10.0, 10.0), at(90.0, 10.0, 10.0)],
        speed_m_s: 5.0,
        corner_radius_m: 10.0,
    };
    assert_eq!(gate().route(&route), Ok(()));
    assert_eq!(gate().route_from(&at(50.0, 50.0, 10.0), &route), Ok(()));
    assert!(matches!(
        gate().route_from(&at(150.0, 50.0, 10.0), &route),
        Err(Refusal::OutsideFence { .. })
    ));
    let fast = Route {
        speed_m_s: 11.0,
        ..route.clone()
    };
    assert_eq!(
        gate().route(&fast),
        Err(Refusal::TooFast {
            speed_m_s: 11.0,
            limit_m_s: 10.0
        })
    );
    assert!(matches!(
        gate().route(&Route {
            waypoints: vec![],
            ..route.clone()
        }),
        Err(Refusal::InvalidValue { .. })
    ));
    let out = Route {
        waypoints: vec![at(10.0, 10.0, 10.0), at(90.0, 110.0, 10.0)],
        ..route.clone()
    };
    assert!(matches!(gate().route(&out), Err(Refusal::OutsideFence { .. })));
}

#[test]
fn a_leg_outside_of_a_fence_that_is_not_convex_is_refused() {
    // Both ends inside of a U, the leg between them not.
    let u = Fence::new(
        vec![
            [0.0, 0.0],
            [100.0, 0.0],
            [100.0, 30.0],
            [40.0, 30.0],
            [40.0, 60.0],
            [100.0, 60.0],
            [100.0, 90.0],
            [0.0, 90.0],
        ],
        2.0,
        50.0,
    )
    .unwrap();
    let across = Route {
        waypoints: vec![at(80.0, 10.0, 10.0), at(80.0, 80.0, 10.0)],
        speed_m_s: 5.0,
        corner_radius_m: 5.0,
    };
    assert!(matches!(
        Gate::new(LIMITS, Some(u)).route(&across),
        Err(Refusal::OutsideFence { .. })
    ));
}

#[test]
fn limits_that_are_no_limits_are_found_and_let_nothing_pass() {
    assert_eq!(LIMITS.check(), Ok(()));
    let odd = Limits {
        max_speed_m_s: f64::NAN,
        ..LIMITS
    };
    assert_eq!(odd.check().unwrap_err().limit, "max_speed_m_s");
    let setpoint = Setpoint {
        velocity: Some(VelocityNed::new(0.1, 0.0, 0.0)),
        ..Setpoint::default()
    };
    let verdict = Gate::new(odd, None).setpoint(OWN, &standing(at(0.0, 0.0, 10.0)), true, &setpoint, &[], NOW);
    assert!(matches!(verdict, Err(Refusal::TooFast { .. })));
    let with = |min_separation_m| {
        Limits {
            min_separation_m,
            ..LIMITS
        }
        .check()
    };
    assert!(with(-1.0).is_err() && with(f64::NAN).is_err());
    assert_eq!(with(0.0), Ok(()));
}
