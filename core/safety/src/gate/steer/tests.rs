//! Tests of steering: untouched where nothing is near, away from others, slower towards a fence, along it, refused behind it.

use super::*;
use crate::avoidance::{Cooperation, Neighbour, NeighbourId};
use crate::{Fence, Limits};
use skein_domain::{PositionNed, VelocityNed};

const OWN: VehicleId = VehicleId(1);

fn gate() -> Gate {
    let limits = Limits {
        max_speed_m_s: 10.0,
        max_climb_m_s: 3.0,
        max_descent_m_s: 2.0,
        min_separation_m: 2.0,
        separation_horizon_s: 6.0,
    };
    let corners = vec![[-100.0, -100.0], [-100.0, 100.0], [100.0, 100.0], [100.0, -100.0]];
    Gate::new(limits, Fence::new(corners, 2.0, 50.0).expect("is a fence"))
}

fn at(north_m: f64, speed_m_s: f64) -> VehicleKinematics {
    VehicleKinematics {
        position: PositionNed::new(north_m, 0.0, -10.0),
        velocity: VelocityNed::new(speed_m_s, 0.0, 0.0),
        ..VehicleKinematics::default()
    }
}

fn northwards(from: &VehicleKinematics) -> Setpoint {
    Setpoint {
        position: Some(from.position),
        velocity: Some(VelocityNed::new(5.0, 0.0, 0.0)),
        ..Setpoint::default()
    }
}

fn in_the_air(own: &VehicleKinematics) -> Steering<'_> {
    Steering {
        id: OWN,
        kinematics: own,
        airborne: true,
        ground_down_m: Some(0.0),
    }
}

fn steer(own: &VehicleKinematics, wanted: &Setpoint, neighbours: &[Neighbour]) -> Result<Steered, Refusal> {
    let gate = gate();
    let surroundings = Surroundings::new(neighbours, &gate.avoidance(), NodeTime(0));
    gate.steer(&in_the_air(own), wanted, &surroundings, NodeTime(0))
}

#[test]
fn alone_and_away_from_the_fence_a_setpoint_comes_out_as_it_went_in() {
    let own = at(0.0, 5.0);
    let wanted = northwards(&own);
    assert_eq!(
        steer(&own, &wanted, &[]),
        Ok(Steered {
            setpoint: wanted,
            change: None
        })
    );
}

#[test]
fn towards_another_it_is_changed_and_says_because_of_whom() {
    let own = at(0.0, 5.0);
    let other = Neighbour {
        id: NeighbourId::Vehicle(VehicleId(2)),
        position: PositionNed::new(6.0, 0.0, -10.0),
        velocity: VelocityNed::default(),
        measured: NodeTime(0),
        uncertainty_m: 0.3,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    };
    let steered = steer(&own, &northwards(&own), &[other]).expect("is changed, not refused");
    let change = steered.change.expect("is changed");
    assert_eq!(change.because, Some(NeighbourId::Vehicle(VehicleId(2))));
    assert!(change.by_m_s > 0.5, "{change:?}");
}

#[test]
fn towards_a_fence_it_is_slowed_and_behind_it_refused() {
    let own = at(98.0, 5.0);
    let steered = steer(&own, &northwards(&own), &[]).expect("is slowed");
    let change = steered.change.expect("is changed");
    assert_eq!(change.because, None);
    let behind = Setpoint::hold(PositionNed::new(104.0, 0.0, -10.0), None);
    assert!(matches!(steer(&own, &behind, &[]), Err(Refusal::OutsideFence { .. })));
}

#[test]
fn a_slot_that_moves_along_behind_the_fence_is_kept_up_with_on_the_inside() {
    const PERIOD_S: f64 = 0.02;
    let mut own = at(90.0, 0.0);
    own.velocity = VelocityNed::new(0.0, 4.0, 0.0);
    let mut slot = PositionNed::new(104.0, 0.0, -10.0);
    for _ in 0..750 {
        slot.east_m += 4.0 * PERIOD_S;
        let wanted = Setpoint {
            position: Some(slot),
            velocity: Some(VelocityNed::new(0.0, 4.0, 0.0)),
            ..Setpoint::default()
        };
        let flown = steer(&own, &wanted, &[]).expect("is led along").setpoint;
        assert_eq!(flown.position, None, "no place behind a fence reaches the vehicle");
        // A vehicle follows a velocity with a lag.
        let change = (flown.velocity.expect("has one").vector() - own.velocity.vector()) * (PERIOD_S / 0.3);
        own.velocity = (own.velocity.vector() + change).into();
        own.position = own.position.after(&own.velocity, PERIOD_S);
        assert!(
            own.position.north_m <= 99.3,
            "{:?} is too near to the boundary",
            own.position
        );
    }
    assert!(
        (own.position.east_m - slot.east_m).abs() < 1.0,
        "{:?} for {slot:?}",
        own.position
    );
    assert!(
        own.position.north_m > 98.0,
        "as near to its slot as it may be: {:?}",
        own.position
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let own = at(0.0, 0.0);
    assert!(matches!(
        steer(&own, &Setpoint::default(), &[]),
        Err(Refusal::InvalidValue { .. })
    ));
    let fast = Setpoint {
        velocity: Some(VelocityNed::new(11.0, 0.0, 0.0)),
        ..Setpoint::default()
    };
    assert!(matches!(steer(&own, &fast, &[]), Err(Refusal::TooFast { .. })));
    let nowhere = at(f64::NAN, 0.0);
    assert_eq!(steer(&nowhere, &northwards(&own), &[]), Err(Refusal::NoPosition));
}

fn open_sky() -> Gate {
    Gate::new(*gate().limits(), None)
}

fn at_height(height_m: f64, down_m_s: f64) -> VehicleKinematics {
    VehicleKinematics {
        position: PositionNed::new(0.0, 0.0, -height_m),
        velocity: VelocityNed::new(0.0, 0.0, down_m_s),
        ..VehicleKinematics::default()
    }
}

/// Flown as an ideal autopilot would, for so long; the lowest height.
fn lowest_m(gate: &Gate, mut own: VehicleKinematics, wanted: &Setpoint, others: &[Neighbour], seconds: f64) -> f64 {
    let settings = gate.avoidance();
    let mut lowest_m = f64::INFINITY;
    for step in 0..(seconds / 0.02) as u64 {
        let now = NodeTime(step * 20_000);
        own.measured = now;
        let others: Vec<Neighbour> = others.iter().map(|n| Neighbour { measured: now, ..*n }).collect();
        let around = Surroundings::new(&others, &settings, now);
        let steered = gate.steer(&in_the_air(&own), wanted, &around, now).expect("is flown");
        let forward = steered.setpoint.velocity.unwrap_or_default().vector();
        let back = steered.setpoint.position.map_or_else(Vector3::zeros, |p| {
            (p.vector() - own.position.vector()) * settings.position_gain_per_s
        });
        let asked = (forward + back).cap_magnitude(settings.max_descent_m_s);
        let velocity = own.velocity.vector() + (asked - own.velocity.vector()) * (0.02 / 0.4);
        own.velocity = velocity.into();
        own.position = own.position.moved(velocity * 0.02);
        lowest_m = lowest_m.min(-own.position.down_m);
    }
    lowest_m
}

#[test]
fn nobody_is_flown_into_the_ground_by_what_is_wanted() {
    let gate = open_sky();
    for wanted in [
        Setpoint::hold(PositionNed::new(0.0, 0.0, 5.0), None),
        Setpoint {
            velocity: Some(VelocityNed::new(0.0, 0.0, 2.0)),
            ..Setpoint::default()
        },
    ] {
        let lowest_m = lowest_m(&gate, at_height(12.0, 2.0), &wanted, &[], 30.0);
        assert!((0.9..1.3).contains(&lowest_m), "{lowest_m} m");
    }
    let downhill = open_sky().with_min_height(-40.0);
    let wanted = Setpoint::hold(PositionNed::new(0.0, 0.0, 5.0), None);
    assert!(lowest_m(&downhill, at_height(12.0, 2.0), &wanted, &[], 30.0) < -4.0);
}

#[test]
fn nobody_is_pressed_into_the_ground_from_above() {
    let own = at_height(2.5, 0.0);
    // Right above it and coming down, with others on all sides.
    let above = |north_m: f64, east_m: f64, height_m: f64, down_m_s: f64| Neighbour {
        id: NeighbourId::Foreign((height_m * 100.0 + north_m * 10.0 + east_m) as u64),
        position: PositionNed::new(north_m, east_m, -height_m),
        velocity: VelocityNed::new(0.0, 0.0, down_m_s),
        measured: NodeTime(0),
        uncertainty_m: 0.3,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    };
    let others = [
        above(0.0, 0.0, 4.5, 1.0),
        above(2.0, 0.0, 2.5, 0.0),
        above(-2.0, 0.0, 2.5, 0.0),
        above(0.0, 2.0, 2.5, 0.0),
        above(0.0, -2.0, 2.5, 0.0),
    ];
    let wanted = Setpoint::hold(own.position, None);
    let steered = {
        let gate = open_sky();
        let around = Surroundings::new(&others, &gate.avoidance(), NodeTime(0));
        gate.steer(&in_the_air(&own), &wanted, &around, NodeTime(0))
            .expect("is flown")
    };
    assert!(steered.change.is_some_and(|change| !change.feasible), "{steered:?}");
    assert!(lowest_m(&open_sky(), own, &wanted, &others, 20.0) > 0.8);
}

#[test]
fn who_holds_outside_of_a_fence_comes_back() {
    let gate = gate();
    let own = at(101.0, 0.0);
    let hold = Setpoint::hold(own.position, None);
    let around = Surroundings::new(&[], &gate.avoidance(), NodeTime(0));
    let steered = gate.hold(&in_the_air(&own), &hold, &around, NodeTime(0));
    assert!(
        steered
            .setpoint
            .velocity
            .is_some_and(|v| (-1.0..-0.3).contains(&v.north_m_s)),
        "{steered:?}"
    );
    let inside = at(90.0, 0.0);
    let hold = Setpoint::hold(inside.position, None);
    assert_eq!(
        gate.hold(&in_the_air(&inside), &hold, &around, NodeTime(0)).setpoint,
        hold
    );
}

#[test]
fn who_holds_because_of_a_refusal_gives_way_all_the_same() {
    let gate = open_sky();
    let own = at(0.0, 0.0);
    let coming = Neighbour {
        id: NeighbourId::Foreign(1),
        position: PositionNed::new(8.0, 0.0, -10.0),
        velocity: VelocityNed::new(-4.0, 0.0, 0.0),
        measured: NodeTime(0),
        uncertainty_m: 0.3,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    };
    let around = Surroundings::new(&[coming], &gate.avoidance(), NodeTime(0));
    let hold = Setpoint::hold(own.position, None);
    let steered = gate.hold(&in_the_air(&own), &hold, &around, NodeTime(0));
    assert!(steered.change.is_some_and(|c| c.by_m_s > 0.5), "{steered:?}");
}
