//! The figures of a real flight: take-off, ten metres north, landing, return; and how well a trajectory is tracked.

use super::rig::{Rig, position, quiet};
use crate::settings::SimSettings;
use crate::truth::ModeCause;
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use skein_domain::{FlightMode, LandedState};

#[test]
fn take_off_to_five_metres_takes_nine_seconds_and_ends_in_hold() {
    let mut rig = Rig::ready(&SimSettings::default());
    rig.take_off(5.0);
    let up_s = rig.run_until(30.0, |t| t.height_m > 4.73).expect("takes off") + 0.1;
    assert!((8.0..10.0).contains(&up_s), "{up_s}");
    rig.run(1.0);
    let truth = rig.truth();
    assert_eq!(truth.mode, FlightMode::Hold);
    let causes: Vec<_> = truth.mode_changes.iter().map(|c| (c.to, c.cause)).collect();
    assert_eq!(
        causes,
        [
            (FlightMode::TakeOff, ModeCause::Commanded),
            (FlightMode::Hold, ModeCause::TakeOffEnded)
        ]
    );
    rig.run(5.0);
    assert!((rig.truth().height_m - 5.0).abs() < 0.3, "{}", rig.truth().height_m);
    assert!(rig.heard("Takeoff detected") && rig.heard("Armed by external command"));
}

/// Ten metres north at once: how long it takes, the farthest place and the greatest speed.
fn ten_metres_north(airframe: crate::Airframe) -> (f64, f64, f64) {
    let settings = SimSettings { airframe, ..quiet() };
    let mut rig = Rig::offboard(&settings, 5.0);
    rig.run(2.0);
    let begin = rig.truth().position.vector();
    rig.stream = Some(position(rig.own_position() + Vector3::new(10.0, 0.0, 0.0)));
    let (mut farthest, mut fastest) = (0.0_f64, 0.0_f64);
    let arrived = rig.run_until(20.0, |t| {
        let gone = t.position.vector() - begin;
        farthest = farthest.max(gone.x);
        fastest = fastest.max(t.velocity.norm());
        (gone.x - 10.0).abs() < 0.3 && t.velocity.norm() < 0.2
    });
    (arrived.expect("arrives"), farthest, fastest)
}

#[test]
fn ten_metres_north_are_flown_as_px4s_own_simulation_was_seen_to() {
    // Recorded (plain-flight): 4.4 s, 10.34 m, 5.1 m/s.
    let (arrived, farthest, fastest) = ten_metres_north(crate::Airframe::Sih);
    assert!((4.0..5.0).contains(&arrived), "{arrived}");
    assert!((10.2..10.5).contains(&farthest), "{farthest}");
    assert!((4.8..5.5).contains(&fastest), "{fastest}");
    // The same controller goes faster and farther where the air brakes it less.
    let (arrived, farthest, fastest) = ten_metres_north(crate::Airframe::Quadrotor);
    assert!((4.5..6.5).contains(&arrived), "{arrived}");
    assert!((10.3..10.9).contains(&farthest), "{farthest}");
    assert!((5.0..7.5).contains(&fastest), "{fastest}");
}

#[test]
fn landing_from_five_metres_with_disarming_takes_thirteen_seconds() {
    let mut rig = Rig::flying(&SimSettings::default(), 5.0);
    rig.run(3.0);
    rig.land();
    let down_s = rig.run_until(40.0, |t| !t.armed).expect("lands and disarms") + 0.1;
    assert!((12.0..14.0).contains(&down_s), "{down_s}");
    let truth = rig.truth();
    assert_eq!(truth.landed, LandedState::OnGround);
    assert!(truth.touch_down_max_m_s < 0.6, "{}", truth.touch_down_max_m_s);
    assert!(
        rig.heard("Landing at current position") && rig.heard("Landing detected") && rig.heard("Disarmed by landing")
    );
    // It had been in HOLD before, and shows that again.
    assert_eq!(truth.mode, FlightMode::Hold);
}

#[test]
fn return_climbs_flies_home_and_lands_where_it_was_armed() {
    let settings = SimSettings {
        parameters: vec![("RTL_RETURN_ALT".into(), real(12.0))],
        ..SimSettings::default()
    };
    let mut rig = Rig::offboard(&settings, 5.0);
    let home = rig.truth().position;
    let p = rig.own_position();
    rig.stream = Some(position(p + Vector3::new(15.0, -8.0, 0.0)));
    rig.run(8.0);
    assert_eq!(rig.set_mode(4, 5), Some(MavResult::MAV_RESULT_ACCEPTED));
    let mut highest = 0.0_f64;
    rig.run_until(90.0, |t| {
        highest = highest.max(t.height_m);
        !t.armed
    })
    .expect("comes home");
    assert!((11.0..13.5).contains(&highest), "{highest}");
    assert!(rig.truth().position.horizontal_distance_m(&home) < 0.6);
}

/// Error while following a circle of 20 m radius at 5 m/s with position, velocity and acceleration given, and with what the velocity takes
/// against so much drag.
fn circle_errors(settings: &SimSettings, drag_per_s: f64) -> (f64, f64) {
    let mut rig = Rig::offboard(settings, 5.0);
    let origin = rig.truth().local_origin.vector();
    let centre = rig.own_position() + Vector3::new(20.0, 0.0, 0.0);
    let (radius, speed) = (20.0_f64, 5.0_f64);
    rig.stream_period_s = 0.02;
    let (mut angle, mut rate, mut worst, mut squares, mut count) = (std::f64::consts::PI, 0.0_f64, 0.0_f64, 0.0, 0);
    while rig.time_s < 90.0 {
        let change = if rate < speed / radius { 0.8 / radius } else { 0.0 };
        rate = (rate + change * 0.02).min(speed / radius);
        angle += rate * 0.02;
        let (sin, cos) = angle.sin_cos();
        let place = centre + Vector3::new(cos, sin, 0.0) * radius;
        let velocity = Vector3::new(-sin, cos, 0.0) * radius * rate;
        let pull =
            Vector3::new(-cos, -sin, 0.0) * radius * rate * rate + Vector3::new(-sin, cos, 0.0) * radius * change;
        let mut setpoint = position(place);
        (setpoint.vx, setpoint.vy, setpoint.vz) = (velocity.x as f32, velocity.y as f32, 0.0);
        let pull = pull + velocity * drag_per_s;
        (setpoint.afx, setpoint.afy, setpoint.afz) = (pull.x as f32, pull.y as f32, 0.0);
        setpoint.type_mask = PositionTargetTypemask::from_bits_retain(0b1000_0000_0000);
        rig.stream = Some(setpoint);
        rig.run(0.02);
        let error = (rig.truth().position.vector() - origin - place).norm();
        worst = worst.max(error);
        squares += error * error;
        count += 1;
    }
    (worst, (squares / f64::from(count)).sqrt())
}

#[test]
fn a_smooth_trajectory_with_feed_forward_is_tracked_closely() {
    let drag_per_s = crate::Airframe::Quadrotor.response().drag_per_s;
    let (worst, rms) = circle_errors(&quiet(), drag_per_s);
    assert!(worst < 0.25 && rms < 0.18, "calm: worst {worst}, rms {rms}");
    let (worst, rms) = circle_errors(&SimSettings::default(), drag_per_s);
    assert!(worst < 0.5 && rms < 0.25, "windy: worst {worst}, rms {rms}");
}

#[test]
fn nobody_who_leaves_the_drag_to_the_autopilot_is_tracked_closely() {
    // Its integrator is too slow for a force that turns with the course.
    let (_, rms) = circle_errors(&quiet(), 0.0);
    assert!((0.35..0.7).contains(&rms), "{rms}");
}

#[test]
fn limits_hold_whatever_is_asked_for() {
    let mut rig = Rig::offboard(&quiet(), 10.0);
    let p = rig.own_position();
    rig.stream = Some(position(p + Vector3::new(300.0, 400.0, -50.0)));
    let (mut fastest, mut climb, mut tilt) = (0.0_f64, 0.0_f64, 0.0_f64);
    rig.run_until(20.0, |t| {
        fastest = fastest.max(t.velocity.vector().xy().norm());
        climb = climb.max(-t.velocity.down_m_s);
        tilt = tilt.max(t.tilt_rad.to_degrees());
        false
    });
    assert!((11.0..13.0).contains(&fastest), "{fastest}");
    assert!((2.5..3.5).contains(&climb), "{climb}");
    assert!((40.0..50.0).contains(&tilt), "{tilt}");
    rig.stream = Some(position(Vector3::new(300.0, 400.0, p.z)));
    let mut descent = 0.0_f64;
    rig.run_until(20.0, |t| {
        descent = descent.max(t.velocity.down_m_s);
        false
    });
    assert!((1.2..1.9).contains(&descent), "{descent}");
}

#[test]
fn a_velocity_setpoint_is_flown_and_the_nose_turns() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    let mut setpoint = position(Vector3::zeros());
    (setpoint.vx, setpoint.vy, setpoint.vz, setpoint.yaw) = (0.0, 2.0, 0.0, 1.5);
    setpoint.type_mask = PositionTargetTypemask::from_bits_retain(0b1001_1100_0111 & !(1 << 10));
    rig.stream = Some(setpoint.clone());
    rig.run(6.0);
    let truth = rig.truth();
    assert!(
        (truth.velocity.east_m_s - 2.0).abs() < 0.15 && truth.velocity.north_m_s.abs() < 0.1,
        "{truth:?}"
    );
    assert!((truth.yaw_rad - 1.5).abs() < 0.05);
    // In the body frame forward is where the nose points.
    #[expect(deprecated, reason = "PX4 still understands this frame")]
    {
        setpoint.coordinate_frame = MavFrame::MAV_FRAME_BODY_NED;
    }
    (setpoint.vx, setpoint.vy) = (2.0, 0.0);
    rig.stream = Some(setpoint);
    rig.run(6.0);
    let truth = rig.truth();
    let (north, east) = (2.0 * truth.yaw_rad.cos(), 2.0 * truth.yaw_rad.sin());
    assert!((truth.velocity.north_m_s - north).abs() < 0.15 && (truth.velocity.east_m_s - east).abs() < 0.15);
}

#[test]
fn it_holds_its_place_in_the_wind() {
    let mut settings = SimSettings::default();
    settings.wind.mean_north_m_s = 6.0;
    let mut rig = Rig::flying(&settings, 5.0);
    rig.run(10.0);
    let place = rig.truth().position;
    let mut farthest = 0.0_f64;
    rig.run_until(30.0, |t| {
        farthest = farthest.max(t.position.distance_m(&place));
        false
    });
    assert!(farthest < 0.5, "{farthest}");
}

#[test]
fn the_estimate_wanders_but_little() {
    let mut rig = Rig::flying(&SimSettings::default(), 5.0);
    let (mut worst, mut best) = (0.0_f64, f64::INFINITY);
    rig.run_until(60.0, |t| {
        let level = t.estimate_error.vector().xy().norm();
        worst = worst.max(level);
        best = best.min(level);
        false
    });
    assert!(worst < 0.17 && best < 0.05 && worst > 0.02, "{best} {worst}");
}

pub fn real(value: f32) -> crate::vehicle::ParameterValue {
    crate::vehicle::ParameterValue::Real(value)
}

#[test]
fn a_camera_carrier_is_slow_in_every_way() {
    let fly = |airframe: crate::Airframe| {
        let mut rig = Rig::of(airframe, &quiet());
        rig.run(5.0);
        rig.take_off(10.0);
        let mut climb_m_s: f64 = 0.0;
        let up = rig.run_until(60.0, |t| {
            climb_m_s = climb_m_s.max(-t.velocity.down_m_s);
            t.mode == FlightMode::Hold
        });
        assert!(up.is_some());
        let there = rig.own_position() + Vector3::new(80.0, 0.0, 0.0);
        rig.stream = Some(position(there));
        rig.run(1.0);
        assert_eq!(rig.set_mode(6, 0), Some(MavResult::MAV_RESULT_ACCEPTED));
        let (mut speed_m_s, mut tilt_rad): (f64, f64) = (0.0, 0.0);
        rig.run_until(40.0, |t| {
            speed_m_s = speed_m_s.max(t.velocity.norm());
            tilt_rad = tilt_rad.max(t.tilt_rad);
            false
        });
        assert!((rig.own_position() - there).norm() < 0.5, "it gets there");
        (climb_m_s, speed_m_s, tilt_rad.to_degrees())
    };
    let (climb, speed, tilt) = fly(crate::Airframe::CameraCarrier);
    assert!(
        climb < 1.2 && (4.5..5.3).contains(&speed) && tilt < 21.0,
        "{climb} {speed} {tilt}"
    );
    let (climb, speed, tilt) = fly(crate::Airframe::Quadrotor);
    assert!(climb > 1.3 && speed > 10.0 && tilt > 30.0, "{climb} {speed} {tilt}");
}
