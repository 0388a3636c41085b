//! What this crate plans must pass the safety gate: a gate that changes ordinary formation flight would be switched off, and one
//! that lets planned motion collide would be none. Vehicles fly close, fast, with noise and delay.

use nalgebra::Vector3;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AccelerationNed, AnchorReference, FormationRequest, NodeTime, OffsetFrd, PositionNed, Route, Shape, SlotMove,
    VehicleId, VelocityNed,
};
use skein_flight::formation;
use skein_flight::transition::{Change, MotionLimits};
use skein_flight::{HeadingFollower, RouteTrajectory, follow, limits};
use skein_safety::avoidance::{Cooperation, Neighbour, NeighbourId, Surroundings};
use skein_safety::{Gate, Limits, Steered, Steering};

const LIMITS: Limits = Limits {
    max_speed_m_s: 20.0,
    max_climb_m_s: 4.0,
    max_descent_m_s: 4.0,
    min_separation_m: 2.0,
    separation_horizon_s: 6.0,
};
const DT_S: f64 = 0.02;

/// Noise that is the same in every run: three numbers within -1..=1, none of them far out.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }

    /// A vector no longer than `limit`.
    fn vector(&mut self, limit: f64) -> Vector3<f64> {
        let v = Vector3::new(self.next(), self.next(), self.next());
        v * (limit / v.norm().max(1.0))
    }
}

/// One vehicle that tracks its setpoints late, and is measured with noise that changes slowly, as that of an estimator does.
struct Vehicle {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    error: Vector3<f64>,
    error_to: Vector3<f64>,
}

/// How far positions and velocities are measured wrongly.
const POSITION_NOISE_M: f64 = 0.3;
const VELOCITY_NOISE_M_S: f64 = 0.15;

impl Vehicle {
    fn at(position: Vector3<f64>) -> Self {
        Self {
            position,
            velocity: Vector3::zeros(),
            error: Vector3::zeros(),
            error_to: Vector3::zeros(),
        }
    }

    /// A velocity loop with a delay of 0.15 s around a position loop of 1 per second, with feed-forward: about what PX4 does.
    fn track(&mut self, setpoint: &skein_domain::Setpoint) {
        let velocity = setpoint.velocity.unwrap_or_default().vector();
        let ahead = setpoint.acceleration.unwrap_or_default().vector() * 0.15;
        let left = setpoint
            .position
            .map_or_else(Vector3::zeros, |p| p.vector() - self.position);
        let wanted = velocity + ahead + left;
        self.velocity += (wanted - self.velocity) * (DT_S / 0.15);
        self.position += self.velocity * DT_S;
    }

    fn measured(&mut self, now: NodeTime, step: u32, noise: &mut Noise) -> VehicleKinematics {
        if step.is_multiple_of(25) {
            self.error_to = noise.vector(POSITION_NOISE_M);
        }
        self.error += (self.error_to - self.error) * 0.1;
        VehicleKinematics {
            position: (self.position + self.error).into(),
            velocity: (self.velocity + noise.vector(VELOCITY_NOISE_M_S)).into(),
            yaw_rad: 0.0,
            measured: now.plus_seconds(-0.04),
        }
    }
}

/// A vehicle in the air, as the others know it.
fn neighbour(id: VehicleId, seen: &VehicleKinematics) -> Neighbour {
    Neighbour {
        id: NeighbourId::Vehicle(id),
        position: seen.position,
        velocity: seen.velocity,
        measured: seen.measured,
        uncertainty_m: POSITION_NOISE_M,
        cooperation: Cooperation::Shares,
        airborne: true,
    }
}

fn steer(
    gate: &Gate,
    id: VehicleId,
    kinematics: &VehicleKinematics,
    wanted: &skein_domain::Setpoint,
    around: &Surroundings,
    now: NodeTime,
) -> Steered {
    let own = Steering {
        id,
        kinematics,
        airborne: true,
        ground_down_m: None,
    };
    gate.steer(&own, wanted, around, now).expect("makes sense")
}

/// What a flight through the gate came to.
#[derive(Debug, Default)]
struct Outcome {
    judged: usize,
    changed: usize,
    min_distance_m: f64,
}

/// Flies leader and followers for `seconds`: the leader as `leader` says, the followers in their moves.
fn fly(
    moves: &[SlotMove],
    seconds: f64,
    mut leader: impl FnMut(f64) -> (PositionNed, VelocityNed, AccelerationNed, f64, f64),
) -> Outcome {
    let gate = Gate::new(LIMITS, None);
    let mut noise = Noise(1);
    let (start, _, _, heading_rad, _) = leader(0.0);
    let mut vehicles: Vec<Vehicle> = moves
        .iter()
        .map(|slot| Vehicle::at(start.vector() + slot.from.rotated(heading_rad)))
        .collect();
    let mut outcome = Outcome {
        min_distance_m: f64::INFINITY,
        ..Outcome::default()
    };
    for step in 0..(seconds / DT_S) as u32 {
        let t_s = f64::from(step) * DT_S;
        let now = NodeTime::from_seconds(100.0 + t_s);
        let seen: Vec<(VehicleId, VehicleKinematics)> = (1..)
            .zip(&mut vehicles)
            .map(|(id, vehicle)| (VehicleId(id), vehicle.measured(now, step, &mut noise)))
            .collect();
        let neighbours: Vec<Neighbour> = seen.iter().map(|(id, seen)| neighbour(*id, seen)).collect();
        let around = Surroundings::new(&neighbours, &gate.avoidance(), now);
        let (position, velocity, acceleration, heading_rad, heading_rate_rad_s) = leader(t_s);
        // Followers see the leader's measured state, and its own acceleration.
        let measured = seen[0].1;
        let anchor = AnchorReference {
            position: measured.position,
            velocity: measured.velocity,
            acceleration,
            heading_rad,
            heading_rate_rad_s,
            time: measured.measured,
            ..AnchorReference::default()
        };
        for ((slot, vehicle), (id, kinematics)) in moves.iter().zip(&mut vehicles).zip(&seen) {
            let setpoint = if *id == VehicleId(1) {
                skein_domain::Setpoint {
                    position: Some(position),
                    velocity: Some(velocity),
                    acceleration: Some(acceleration),
                    ..skein_domain::Setpoint::default()
                }
            } else {
                follow::setpoint(&anchor, slot, now)
            };
            let steered = steer(&gate, *id, kinematics, &setpoint, &around, now);
            outcome.judged += 1;
            outcome.changed += usize::from(steered.change.is_some());
            vehicle.track(&steered.setpoint);
        }
        for (i, a) in vehicles.iter().enumerate() {
            for b in &vehicles[i + 1..] {
                outcome.min_distance_m = outcome.min_distance_m.min((a.position - b.position).norm());
            }
        }
    }
    outcome
}

fn slots(shape: Shape, count: usize) -> Result<Vec<OffsetFrd>, formation::FormationError> {
    formation::slots(&FormationRequest::new(shape, 5.0), count)
}

fn start() -> NodeTime {
    NodeTime::from_seconds(101.0)
}

fn straight(speed_m_s: f64) -> impl FnMut(f64) -> (PositionNed, VelocityNed, AccelerationNed, f64, f64) {
    move |t_s| {
        // Up to speed at 3 m/s², then on.
        let ramp_s = speed_m_s / 3.0;
        let (north_m, speed, acceleration) = if t_s < ramp_s {
            (1.5 * t_s * t_s, 3.0 * t_s, 3.0)
        } else {
            (speed_m_s * (t_s - 0.5 * ramp_s), speed_m_s, 0.0)
        };
        (
            PositionNed::new(north_m, 0.0, -30.0),
            VelocityNed::new(speed, 0.0, 0.0),
            AccelerationNed::new(acceleration, 0.0, 0.0),
            0.0,
            0.0,
        )
    }
}

fn standing(offsets: &[OffsetFrd]) -> Vec<SlotMove> {
    let stay = |offset: &OffsetFrd| SlotMove {
        from: *offset,
        to: *offset,
        detour_up_m: 0.0,
        start: start(),
        duration_s: 0.0,
    };
    offsets.iter().map(stay).collect()
}

#[test]
fn tight_formations_at_ten_metres_a_second_pass() {
    for shape in Shape::ALL.iter().filter(|shape| **shape != Shape::Free) {
        let moves = standing(&slots(*shape, 20).unwrap());
        let outcome = fly(&moves, 12.0, straight(10.0));
        assert_eq!(outcome.changed, 0, "{shape:?}: {outcome:?}");
        assert!(outcome.min_distance_m > 3.5, "{shape:?}: {outcome:?}");
    }
}

#[test]
fn planned_transitions_pass_standing_and_flying() {
    let limits = MotionLimits {
        speed_m_s: 8.0,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.5,
        min_distance_m: 2.8,
    };
    let from_grid: Vec<OffsetFrd> = (0..30)
        .map(|i| OffsetFrd::new(f64::from(i / 6) * 5.0, f64::from(i % 6) * 5.0, 0.0))
        .collect();
    let filter = Gate::new(LIMITS, None).avoidance();
    for (speed_m_s, shape) in [
        (0.0, Shape::Wedge),
        (0.0, Shape::Line),
        (8.0, Shape::Circle),
        (8.0, Shape::Column),
    ] {
        let targets = slots(shape, from_grid.len()).unwrap();
        let change = Change {
            filter: Some(&filter),
            ..Change::new(&from_grid, &targets, &limits)
        };
        let plan = change.plan(start()).unwrap();
        let outcome = fly(&plan.moves, plan.duration_s + 3.0, straight(f64::max(speed_m_s, 0.01)));
        // Where two pass each other, what is measured wrongly makes them give way a little.
        assert!(
            outcome.changed * 20 <= outcome.judged,
            "{shape:?} at {speed_m_s} m/s: {outcome:?}"
        );
        assert!(
            outcome.min_distance_m > 2.0,
            "{shape:?} at {speed_m_s} m/s: {outcome:?}"
        );
    }
}

#[test]
fn turns_of_a_route_pass() {
    let formation = slots(Shape::Wedge, 15).unwrap();
    let place = |north_m, east_m| PositionNed::new(north_m, east_m, -30.0);
    let route = Route {
        waypoints: vec![place(80.0, 0.0), place(80.0, 80.0), place(0.0, 80.0)],
        speed_m_s: 5.0,
        corner_radius_m: 20.0,
    };
    let trajectory = RouteTrajectory::new(place(0.0, 0.0), &route, 2.0).unwrap();
    let max_rate_rad_s = limits::max_turn_rate_rad_s(&formation, 5.0, 12.0);
    let mut heading = HeadingFollower::new(skein_domain::FormationHeading::Course { max_rate_rad_s }, 0.0);
    let outcome = fly(&standing(&formation), trajectory.duration_s(), |t_s| {
        let sample = trajectory.sample(t_s);
        let (heading_rad, rate) = heading.step(sample.course_rad, DT_S);
        (sample.position, sample.velocity, sample.acceleration, heading_rad, rate)
    });
    assert_eq!(outcome.changed, 0, "{outcome:?}");
    assert!(outcome.min_distance_m > 3.5, "{outcome:?}");
}

#[test]
fn a_vehicle_sent_through_another_is_kept_apart_from_it() {
    let gate = Gate::new(LIMITS, None);
    let mut noise = Noise(3);
    let mut vehicle = Vehicle::at(Vector3::zeros());
    let mut obstacle = Vehicle::at(Vector3::new(40.0, 0.5, 0.0));
    let route = skein_flight::GoTo::new(PositionNed::default(), PositionNed::new(80.0, 0.0, 0.0), 5.0, 2.0).unwrap();
    let mut nearest_m = f64::INFINITY;
    for step in 0..1500 {
        let t_s = f64::from(step) * DT_S;
        let now = NodeTime::from_seconds(100.0 + t_s);
        let own = vehicle.measured(now, step, &mut noise);
        let other = neighbour(VehicleId(2), &obstacle.measured(now, step, &mut noise));
        let around = Surroundings::new(&[other], &gate.avoidance(), now);
        let (position, velocity, acceleration, _) = route.sample(t_s);
        let asked = skein_domain::Setpoint {
            position: Some(position),
            velocity: Some(velocity),
            acceleration: Some(acceleration),
            ..skein_domain::Setpoint::default()
        };
        let steered = steer(&gate, VehicleId(1), &own, &asked, &around, now);
        vehicle.track(&steered.setpoint);
        nearest_m = nearest_m.min((vehicle.position - obstacle.position).norm());
    }
    assert!(nearest_m > 1.5, "{nearest_m}");
}
