//! The filter on single encounters: what is left alone, what is changed, and by how little.

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
    filter(
        VehicleId(1),
        own,
        wanted,
        neighbours,
        &[],
        &AvoidanceSettings::default(),
        now(),
    )
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
