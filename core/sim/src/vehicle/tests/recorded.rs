//! The simulated airframe beside recordings of PX4's own simulation in hardware (SIH).

use super::rig::{Rig, position, quiet};
use crate::settings::SimSettings;
use mavlink::dialects::common::*;
use nalgebra::Vector3;

/// A PX4 with SIH on its way to a place 100 m north, from standing, 20 m up, in OFFBOARD: seconds since it was told, metres north, metres per second, and pitch
/// in radians. Its setpoints speed up by 2 m/s² to 9 m/s.
const RUN_UP: [(f64, f64, f64, f64); 13] = [
    (0.94, 0.43, 1.28, -0.319),
    (1.41, 1.24, 2.20, -0.396),
    (1.89, 2.54, 3.28, -0.521),
    (2.40, 4.48, 4.54, -0.621),
    (2.90, 7.09, 5.79, -0.692),
    (3.40, 10.23, 6.77, -0.709),
    (3.91, 13.83, 7.50, -0.732),
    (4.39, 17.51, 8.15, -0.775),
    (4.84, 21.27, 8.59, -0.766),
    (5.30, 25.24, 8.78, -0.744),
    (6.30, 34.01, 9.07, -0.761),
    (8.31, 52.39, 9.30, -0.756),
    (10.31, 70.74, 9.25, -0.756),
];

#[test]
fn it_leans_on_its_way_as_px4_was_recorded() {
    let settings = SimSettings {
        airframe: crate::Airframe::Sih,
        ..quiet()
    };
    let mut rig = Rig::offboard(&settings, 20.0);
    let origin = rig.truth().local_origin.vector();
    let start = rig.own_position();
    rig.stream_period_s = 0.02;
    let began_s = rig.time_s;
    let (mut north_m, mut speed_m_s) = (0.0, 0.0_f64);
    let mut rows = RUN_UP.into_iter().peekable();
    while let Some((at_s, recorded_m, recorded_m_s, recorded_rad)) = rows.peek().copied() {
        let faster_m_s = (2.0 * 0.02_f64).min(9.0 - speed_m_s);
        north_m += (speed_m_s + faster_m_s / 2.0) * 0.02;
        speed_m_s += faster_m_s;
        let mut setpoint = position(start + Vector3::new(north_m, 0.0, 0.0));
        (setpoint.vx, setpoint.vy, setpoint.vz) = (speed_m_s as f32, 0.0, 0.0);
        (setpoint.afx, setpoint.afy, setpoint.afz) = ((faster_m_s / 0.02) as f32, 0.0, 0.0);
        setpoint.type_mask = PositionTargetTypemask::from_bits_retain(0b1000_0000_0000);
        rig.stream = Some(setpoint);
        rig.run(0.02);
        if rig.time_s - began_s >= at_s {
            rows.next();
            let truth = rig.truth();
            let flown_m = (truth.position.vector() - origin - start).x;
            let (flown_m_s, lean_rad) = (truth.velocity.north_m_s, truth.tilt_rad);
            let said = format!("{at_s} s: {flown_m:.2} m, {flown_m_s:.2} m/s, {lean_rad:.2} rad");
            assert!((flown_m - recorded_m).abs() < 1.5, "{said}: recorded {recorded_m} m");
            assert!(
                (flown_m_s - recorded_m_s).abs() < 0.8,
                "{said}: recorded {recorded_m_s} m/s"
            );
            assert!(
                (lean_rad + recorded_rad).abs() < 0.09,
                "{said}: recorded {recorded_rad} rad"
            );
        }
    }
}
