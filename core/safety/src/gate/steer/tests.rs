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

fn steer(own: &VehicleKinematics, wanted: &Setpoint, neighbours: &[Neighbour]) -> Result<Steered, Refusal> {
    let gate = gate();
    let surroundings = Surroundings::new(neighbours, &gate.avoidance(), NodeTime(0));
    gate.steer(OWN, own, true, wanted, &surroundings, NodeTime(0))
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
