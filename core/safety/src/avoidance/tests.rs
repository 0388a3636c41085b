//! The filter on single encounters: what is left alone, what is changed, and by how little.

use super::surroundings::Carried;
use super::*;

const NOW_S: f64 = 100.0;

fn now() -> NodeTime {
    NodeTime::from_seconds(NOW_S)
}

fn kinematics(position: [f64; 3], velocity: [f64; 3]) -> VehicleKinematics {
    VehicleKinematics {
        position: PositionNed::new(position[0], position[1], position[2]),
        velocity: VelocityNed::new(velocity[0], velocity[1], velocity[2]),
        yaw_rad: 0.0,
        measured: now(),
    }
}

fn neighbour(id: u16, position: [f64; 3], velocity: [f64; 3]) -> Neighbour {
    Neighbour {
        id: NeighbourId::Vehicle(VehicleId(id)),
        position: PositionNed::new(position[0], position[1], position[2]),
        velocity: VelocityNed::new(velocity[0], velocity[1], velocity[2]),
        measured: now(),
        uncertainty_m: 0.3,
        cooperation: Cooperation::Shares,
        airborne: true,
    }
}

fn fly(velocity: [f64; 3]) -> Setpoint {
    Setpoint {
        velocity: Some(VelocityNed::new(velocity[0], velocity[1], velocity[2])),
        yaw_rad: Some(0.5),
        ..Setpoint::default()
    }
}

fn run(own: &VehicleKinematics, wanted: &Setpoint, neighbours: &[Neighbour]) -> Filtered {
    prepared(VehicleId(1), own, wanted, neighbours, now())
}

/// As it is flown: with surroundings that are prepared once.
fn prepared(
    id: VehicleId,
    own: &VehicleKinematics,
    wanted: &Setpoint,
    neighbours: &[Neighbour],
    now: NodeTime,
) -> Filtered {
    let settings = AvoidanceSettings::default();
    let conditions = Conditions {
        surroundings: &Surroundings::new(neighbours, &settings, now),
        bounds: &[],
        settings: &settings,
    };
    filter(id, own, wanted, &conditions, now)
}

/// The same, looking at every neighbour in turn.
fn one_by_one(
    id: VehicleId,
    own: &VehicleKinematics,
    wanted: &Setpoint,
    neighbours: &[Neighbour],
    now: NodeTime,
) -> Filtered {
    let settings = AvoidanceSettings::default();
    let own = own_now(id, own, wanted, &settings, now).expect("is in numbers");
    let carried = neighbours.iter().filter_map(|n| Carried::new(n, &settings, now));
    let demands: Vec<Demand> = carried.filter_map(|peer| demand(&own, &peer, &settings)).collect();
    decide(&own, wanted, &demands, &[], &settings)
}

#[test]
fn a_formation_at_ten_metres_a_second_is_left_alone() {
    let own = kinematics([0.0; 3], [10.0, 0.0, 0.0]);
    let wanted = Setpoint {
        position: Some(PositionNed::new(0.3, 0.1, 0.0)),
        velocity: Some(VelocityNed::new(10.0, 0.0, 0.0)),
        acceleration: Some(Vector3::new(0.1, 0.0, 0.0).into()),
        ..Setpoint::default()
    };
    let neighbours = [
        neighbour(2, [5.0, 0.0, 0.0], [10.0, 0.0, 0.0]),
        neighbour(3, [-3.0, 4.0, 0.0], [9.9, 0.1, 0.0]),
    ];
    let filtered = run(&own, &wanted, &neighbours);
    assert_eq!(filtered.setpoint, wanted);
    assert_eq!(filtered.change, None);
}

#[test]
fn head_on_both_give_way_to_the_right() {
    let (a, b) = ([0.0; 3], [14.0, 0.0, 0.0]);
    let filtered = run(
        &kinematics(a, [5.0, 0.0, 0.0]),
        &fly([5.0, 0.0, 0.0]),
        &[neighbour(2, b, [-5.0, 0.0, 0.0])],
    );
    let velocity = filtered.setpoint.velocity.unwrap();
    assert!(velocity.east_m_s > 0.2, "{filtered:?}");
    assert_eq!(filtered.setpoint.yaw_rad, Some(0.5));
    assert_eq!(filtered.setpoint.position, None);
    let change = filtered.change.unwrap();
    assert!(change.feasible && change.predicted_m < 0.1 && (change.distance_m - 14.0).abs() < 1e-9);
}

/// Two that fly by the filter, as ideal autopilots with a lag would; the nearest they come, with heights squeezed for the downwash.
fn nearest_m(mut a: VehicleKinematics, mut b: VehicleKinematics, wants: [Setpoint; 2], shares: bool) -> f64 {
    let settings = AvoidanceSettings::default();
    let mut nearest_m = f64::INFINITY;
    for step in 0..600_u64 {
        let now = NodeTime(100_000_000 + step * 20_000);
        (a.measured, b.measured) = (now, now);
        let other = |id: u16, k: &VehicleKinematics| Neighbour {
            id: NeighbourId::Vehicle(VehicleId(id)),
            position: k.position,
            velocity: k.velocity,
            measured: now,
            uncertainty_m: 0.3,
            cooperation: if shares {
                Cooperation::Shares
            } else {
                Cooperation::DoesNot
            },
            airborne: true,
        };
        let own = |id: u16, own: &VehicleKinematics, wanted: &Setpoint, other: Neighbour| {
            let all = [other];
            let filtered = prepared(VehicleId(id), own, wanted, &all, now);
            assert_eq!(filtered, one_by_one(VehicleId(id), own, wanted, &all, now));
            filtered.setpoint.velocity.expect("wants a velocity").vector()
        };
        let (for_a, for_b) = (own(1, &a, &wants[0], other(2, &b)), own(2, &b, &wants[1], other(1, &a)));
        for (k, asked, moves) in [(&mut a, for_a, true), (&mut b, for_b, shares)] {
            if moves {
                let velocity = k.velocity.vector() + (asked - k.velocity.vector()) * (0.02 / 0.35);
                k.velocity = velocity.into();
            }
            k.position = k.position.moved(k.velocity.vector() * 0.02);
        }
        let apart = b.position.vector() - a.position.vector();
        nearest_m = nearest_m.min(apart.xy().norm().hypot(apart.z / settings.vertical_stretch));
    }
    nearest_m
}

fn pair(place: [f64; 3], a_m_s: [f64; 3], b_m_s: [f64; 3], shares: bool) -> f64 {
    let (a, b) = (
        kinematics([0.0, 0.0, -50.0], a_m_s),
        kinematics([place[0], place[1], place[2] - 50.0], b_m_s),
    );
    nearest_m(a, b, [fly(a_m_s), fly(b_m_s)], shares)
}

#[test]
fn two_that_meet_keep_their_distance_however_they_meet() {
    for shares in [true, false] {
        for (how, place, a_m_s, b_m_s) in [
            ("head on", [60.0, 0.0, 0.0], [8.0, 0.0, 0.0], [-8.0, 0.0, 0.0]),
            ("nearly head on", [60.0, 1.0, 0.5], [8.0, 0.0, 0.0], [-8.0, 0.0, 0.0]),
            ("crossing", [40.0, 40.0, 0.0], [8.0, 0.0, 0.0], [0.0, -8.0, 0.0]),
            (
                "crossing slantingly",
                [40.0, 20.0, -4.0],
                [8.0, 0.0, 0.0],
                [2.0, -4.0, 1.0],
            ),
            ("overtaking", [15.0, 0.0, 0.0], [9.0, 0.0, 0.0], [3.0, 0.0, 0.0]),
            (
                "descending onto another",
                [0.0, 0.0, 20.0],
                [0.0, 0.0, 2.0],
                [0.0, 0.0, 0.0],
            ),
            (
                "climbing into another",
                [0.0, 0.0, -20.0],
                [0.0, 0.0, -3.0],
                [0.0, 0.0, 0.0],
            ),
            ("crossing over", [30.0, 0.0, 2.6], [6.0, 0.0, 0.0], [-2.0, 0.0, 0.0]),
        ] {
            let nearest_m = pair(place, a_m_s, b_m_s, shares);
            // The separation of these settings is 2 m; what is kept beyond it is for errors of position, of which there are none here.
            assert!(nearest_m > 2.1, "{how}, shares {shares}: {nearest_m:.2} m");
        }
    }
}

/// Ahead at the same speed, heard less and less lately: it may have stopped dead since.
#[test]
fn who_flies_behind_one_that_falls_silent_brakes_before_it_is_known_to_have_stopped() {
    let own = kinematics([0.0; 3], [6.0, 0.0, 0.0]);
    let slowed = |age_s: f64| {
        let mut ahead = neighbour(2, [4.5 - 6.0 * age_s, 0.0, 0.0], [6.0, 0.0, 0.0]);
        ahead.measured = now().plus_seconds(-age_s);
        let filtered = run(&own, &fly([6.0, 0.0, 0.0]), &[ahead]);
        6.0 - filtered.setpoint.velocity.expect("a velocity").north_m_s
    };
    assert_eq!(slowed(0.1), 0.0, "as in any formation");
    let (early, late) = (slowed(0.45), slowed(0.6));
    assert!(early > 0.05 && late > early, "{early} then {late} m/s");
}

proptest::proptest! {
    /// Looking at few instead of all changes nothing.
    #[test]
    fn the_prepared_surroundings_leave_nobody_out(
        places in proptest::collection::vec(proptest::array::uniform3(-30.0_f64..30.0), 1..40),
        speeds in proptest::collection::vec(proptest::array::uniform3(-6.0_f64..6.0), 40),
        ages in proptest::collection::vec(0.0_f64..2.0, 40),
        wanted in proptest::array::uniform3(-8.0_f64..8.0),
    ) {
        let others: Vec<Neighbour> = (2..).zip(places.iter().zip(&speeds).zip(&ages)).map(|(id, ((place, speed), age_s))| Neighbour {
            measured: now().plus_seconds(-age_s),
            cooperation: if *age_s < 0.5 { Cooperation::Shares } else { Cooperation::DoesNot },
            ..neighbour(id, *place, *speed)
        }).collect();
        let own = kinematics([0.0; 3], [1.0, -2.0, 0.5]);
        let all = one_by_one(VehicleId(1), &own, &fly(wanted), &others, now());
        let few = prepared(VehicleId(1), &own, &fly(wanted), &others, now());
        let velocity = |f: &Filtered| f.setpoint.velocity.expect("a velocity").vector();
        // The order of the demands is another, and with it the rounding.
        proptest::prop_assert!((velocity(&all) - velocity(&few)).norm() < 1e-3, "{all:?}\n{few:?}");
    }
}

/// It stands in the place that is wanted: there is no way round it to there.
#[test]
fn who_finds_a_stranger_in_its_place_waits_beside_it() {
    let place = [20.0, 0.0, 0.0];
    let stranger = Neighbour {
        cooperation: Cooperation::DoesNot,
        ..neighbour(2, place, [0.0; 3])
    };
    let wanted = Setpoint::hold(PositionNed::new(place[0], place[1], place[2]), None);
    let (mut at, mut velocity, mut flown_m) = (Vector3::zeros(), Vector3::<f64>::zeros(), 0.0);
    for _ in 0..3_000 {
        let own = kinematics([at.x, at.y, at.z], [velocity.x, velocity.y, velocity.z]);
        let filtered = run(&own, &wanted, &[stranger]);
        let asked = filtered.setpoint.velocity.map_or_else(
            || filtered.setpoint.position.map_or(Vector3::zeros(), |p| p.vector() - at),
            |v| v.vector(),
        );
        velocity += (asked - velocity) * (0.02 / 0.3);
        at += velocity * 0.02;
        flown_m += velocity.norm() * 0.02;
    }
    assert!(velocity.norm() < 0.05, "{velocity:?} at {at:?}");
    let off_m = (at - Vector3::from(place)).norm();
    assert!(off_m > 2.3 && off_m < 3.5, "{off_m} m off, {at:?}");
    assert!(flown_m < 30.0, "{flown_m} m");
}
