//! The gate as a whole: what passes stays inside, and every refusal carries what it should.

use super::*;
use crate::avoidance::{Cooperation, Neighbour, NeighbourId, Surroundings, as_velocity};
use crate::fence::Fence;
use crate::fence::tests::polygon_about;
use nalgebra::Vector3;
use proptest::prelude::*;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{AccelerationNed, NodeTime, VehicleId};

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

fn steer(
    gate: &Gate,
    own: &VehicleKinematics,
    airborne: bool,
    setpoint: &Setpoint,
    neighbours: &[Neighbour],
) -> Result<Steered, Refusal> {
    let own = Steering {
        id: OWN,
        kinematics: own,
        airborne,
        ground_down_m: None,
    };
    let surroundings = Surroundings::new(neighbours, &gate.avoidance(), NOW);
    gate.steer(&own, setpoint, &surroundings, NOW)
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
        let Ok(steered) = steer(&gate, &standing(own), true, &setpoint, &[]) else {
            return Ok(());
        };
        // The way to the asked position, and on from where it is as it is flown.
        let base = steered.setpoint.position.unwrap_or(own);
        let flown = as_velocity(OWN, &standing(own), &steered.setpoint, &gate.avoidance(), NOW);
        let v = flown.and_then(|flown| flown.velocity).expect("can be flown").vector();
        for k in 0..=100 {
            let share = f64::from(k) / 100.0;
            let there = own.vector().lerp(&base.vector(), share);
            prop_assert!(fence.excess(&there.into()).outside_m < 1e-5);
            let excess = fence.excess(&own.moved(v * (share * LIMITS.separation_horizon_s)));
            prop_assert!(excess.outside_m < 1e-5 && excess.above_m < 1e-9 && excess.below_m < 1e-9, "{excess:?}");
        }
    }

    #[test]
    fn speeds_over_the_limits_are_refused_and_others_pass(velocity in vector(14.0)) {
        let setpoint = Setpoint { velocity: Some(velocity.into()), ..Setpoint::default() };
        let verdict = steer(&Gate::new(LIMITS, None), &standing(at(0.0, 0.0, 10.0)), true, &setpoint, &[]);
        let level = velocity.xy().norm();
        match verdict {
            Ok(passed) => {
                prop_assert_eq!(passed, Steered { setpoint, change: None });
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
        let verdict = steer(&gate, &standing(at(50.0, 50.0, 10.0)), true, &setpoint, &[]);
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
            prop_assert_eq!(steer(&gate, &own, true, &hold, &[]), Err(Refusal::NoPosition));
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
    let verdict = steer(&gate(), &standing(at(50.0, 50.0, 10.0)), true, &only_yaw, &[]);
    assert!(matches!(verdict, Err(Refusal::InvalidValue { .. })));
}

#[test]
fn on_the_ground_a_velocity_that_leads_out_is_refused_unless_it_brakes() {
    let own = standing(at(97.0, 50.0, 10.0));
    let fast = Setpoint {
        velocity: Some(VelocityNed::new(5.0, 0.0, 0.0)),
        ..Setpoint::default()
    };
    let verdict = steer(&gate(), &own, false, &fast, &[]);
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
    assert!(steer(&gate(), &own, false, &arriving, &[]).is_ok());
    // More braking than a vehicle has is not believed.
    let hopeful = Setpoint {
        velocity: Some(VelocityNed::new(8.0, 0.0, 0.0)),
        acceleration: Some(AccelerationNed::new(-50.0, 0.0, 0.0)),
        ..arriving
    };
    assert!(steer(&gate(), &own, false, &hopeful, &[]).is_err());
}

#[test]
fn in_the_air_a_velocity_that_leads_out_is_slowed_however_hard_it_says_to_brake() {
    let own = standing(at(97.0, 50.0, 10.0));
    for acceleration in [None, Some(AccelerationNed::new(-50.0, 0.0, 0.0))] {
        let fast = Setpoint {
            velocity: Some(VelocityNed::new(8.0, 0.0, 0.0)),
            acceleration,
            ..Setpoint::default()
        };
        let steered = steer(&gate(), &own, true, &fast, &[]).expect("is slowed");
        let north_m_s = steered.setpoint.velocity.expect("has one").north_m_s;
        // 3 m, less the margin, within the reaction and the braking that the filter reckons with.
        assert!((0.0..2.2).contains(&north_m_s), "{north_m_s} m/s");
    }
}

#[test]
fn who_is_outside_may_come_back_but_not_go_further() {
    let own = standing(at(110.0, 50.0, 10.0));
    let fly = |v: [f64; 3]| Setpoint {
        velocity: Some(Vector3::from(v).into()),
        ..Setpoint::default()
    };
    let judge = |setpoint: &Setpoint| steer(&gate(), &own, true, setpoint, &[]);
    assert!(judge(&fly([-5.0, 0.0, 0.0])).is_ok());
    assert!(judge(&Setpoint::hold(at(90.0, 50.0, 10.0), None)).is_ok());
    assert!(judge(&Setpoint::hold(own.position, None)).is_ok());
    let further = judge(&fly([1.0, 0.0, 0.0])).expect("is changed").setpoint.velocity;
    assert!(further.expect("has one").north_m_s < 1e-6, "{further:?}");
    assert!(judge(&Setpoint::hold(at(112.0, 50.0, 10.0), None)).is_err());
    // Nearer to the boundary, but now through the ceiling.
    assert!(judge(&Setpoint::hold(at(105.0, 50.0, 60.0), None)).is_err());
}

#[test]
fn on_the_ground_neither_floor_nor_neighbours_count() {
    let own = standing(at(50.0, 50.0, 0.0));
    let neighbour = Neighbour {
        id: NeighbourId::Vehicle(VehicleId(2)),
        position: at(50.0, 51.0, 0.5),
        velocity: VelocityNed::default(),
        measured: NOW,
        uncertainty_m: 0.3,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    };
    let hold = Setpoint {
        velocity: Some(VelocityNed::new(0.0, 1.0, 0.0)),
        ..Setpoint::hold(at(50.0, 50.1, 0.1), None)
    };
    let unchanged = Steered {
        setpoint: hold,
        change: None,
    };
    assert_eq!(steer(&gate(), &own, false, &hold, &[neighbour]), Ok(unchanged));
    let outside = Setpoint::hold(at(150.0, 50.0, 10.0), None);
    assert!(steer(&gate(), &own, false, &outside, &[]).is_err());
    // In the air they do.
    let own = standing(at(50.0, 50.0, 10.0));
    let neighbour = Neighbour {
        position: at(50.0, 52.5, 10.0),
        ..neighbour
    };
    let towards = Setpoint {
        velocity: Some(VelocityNed::new(0.0, 1.0, 0.0)),
        ..Setpoint::default()
    };
    let steered = steer(&gate(), &own, true, &towards, &[neighbour]).expect("is changed");
    let change = steered.change.expect("is changed");
    assert_eq!(change.because, Some(neighbour.id));
    assert!((change.predicted_m - 1.7).abs() < 1e-9, "{change:?}");
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
    let verdict = steer(
        &Gate::new(odd, None),
        &standing(at(0.0, 0.0, 10.0)),
        true,
        &setpoint,
        &[],
    );
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
