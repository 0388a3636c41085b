//! Arming, modes and refusals, one by one as they were seen.

use super::rig::{Rig, quiet};
use crate::vehicle::LinkKind;
use mavlink::dialects::common::*;
use skein_domain::{FlightMode, LandedState};

const ACCEPTED: Option<MavResult> = Some(MavResult::MAV_RESULT_ACCEPTED);
const REJECTED: Option<MavResult> = Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED);
const NAN: f32 = f32::NAN;

fn health_bit(rig: &Rig) -> bool {
    let health = rig.last(|m| match m {
        MavMessage::SYS_STATUS(s) => Some(s.onboard_control_sensors_health.bits()),
        _ => None,
    });
    health.expect("SYS_STATUS came") & 0x1000_0000 != 0
}

#[test]
fn arming_is_refused_until_the_estimator_is_ready() {
    let mut rig = Rig::new(&quiet());
    rig.run(2.0);
    assert_eq!(rig.arm(), REJECTED);
    assert!(!health_bit(&rig));
    assert!(rig.heard("Arming denied: Resolve system health failures first"));
    rig.run(2.5);
    assert!(health_bit(&rig));
    assert_eq!(rig.arm(), ACCEPTED);
    assert_eq!(rig.arm(), ACCEPTED, "armed already");
}

#[test]
fn armed_and_idle_it_disarms_itself_after_ten_seconds() {
    let mut rig = Rig::ready(&quiet());
    rig.arm();
    let waited = rig.run_until(20.0, |t| !t.armed).expect("disarms");
    assert!((9.5..10.5).contains(&waited), "{waited}");
    assert!(rig.heard("Disarmed by auto preflight disarming"));
    assert_eq!(rig.command(400, [0.0; 7]), ACCEPTED, "disarmed already");
}

#[test]
fn disarming_in_the_air_is_refused_unless_forced() {
    let mut rig = Rig::flying(&quiet(), 5.0);
    assert_eq!(rig.command(400, [0.0; 7]), REJECTED);
    assert!(rig.heard("Disarming denied: not landed"));
    assert!(rig.truth().armed);
    assert_eq!(rig.command(400, [0.0, 21196.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ACCEPTED);
    rig.run(3.0);
    let truth = rig.truth();
    assert!(
        !truth.armed && truth.touches_ground && truth.touch_down_max_m_s > 5.0,
        "{truth:?}"
    );
}

#[test]
fn an_odd_arm_parameter_is_not_acknowledged() {
    let mut rig = Rig::ready(&quiet());
    assert_eq!(rig.command(400, [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), None);
    assert!(rig.heard("Unsupported ARM_DISARM param: 3.000"));
}

#[test]
fn addresses_are_observed() {
    let mut rig = Rig::ready(&quiet());
    let arm = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(rig.command_to(1, 2, 400, arm), None, "nobody's component");
    assert_eq!(rig.command_to(9, 1, 400, arm), None, "another system");
    assert_eq!(rig.command_to(0, 0, 400, arm), ACCEPTED, "anyone");
}

#[test]
fn an_unknown_command_is_unsupported() {
    let mut rig = Rig::ready(&quiet());
    assert_eq!(rig.command(31_999, [0.0; 7]), None);
    assert_eq!(rig.nameless_answers, 1, "answered all the same");
    // One that the dialect knows, so that the answer can be read by its types.
    assert_eq!(rig.command(2510, [0.0; 7]), Some(MavResult::MAV_RESULT_UNSUPPORTED));
}

#[test]
fn take_off_to_an_altitude_below_the_ground_stays_on_the_ground() {
    let mut rig = Rig::ready(&quiet());
    rig.arm();
    assert_eq!(rig.command(22, [0.0, 0.0, 0.0, NAN, NAN, NAN, 5.0]), ACCEPTED);
    assert!(rig.heard("Already higher than takeoff altitude"));
    rig.run_until(20.0, |t| !t.armed).expect("disarms by itself");
    assert!(rig.truth().touches_ground && rig.truth().touch_down_max_m_s == 0.0);
}

#[test]
fn take_off_without_an_altitude_goes_to_the_default() {
    let mut rig = Rig::ready(&quiet());
    rig.arm();
    assert_eq!(rig.command(22, [NAN; 7]), ACCEPTED);
    assert!(rig.heard("Using default takeoff altitude: 2.5 m"));
    rig.run(15.0);
    assert!((rig.truth().height_m - 2.5).abs() < 0.3, "{}", rig.truth().height_m);
}

#[test]
fn take_off_while_disarmed_waits_for_arming() {
    let mut rig = Rig::ready(&quiet());
    let altitude = rig.amsl(4.0);
    assert_eq!(rig.command(22, [0.0, 0.0, 0.0, NAN, NAN, NAN, altitude]), ACCEPTED);
    rig.run(5.0);
    assert_eq!(rig.truth().mode, FlightMode::TakeOff);
    assert!(rig.truth().touches_ground);
    assert_eq!(rig.arm(), ACCEPTED);
    rig.run(14.0);
    assert!((rig.truth().height_m - 4.0).abs() < 0.4);
}

#[test]
fn modes_are_accepted_on_the_ground_and_judged_in_the_air() {
    let mut rig = Rig::ready(&quiet());
    for (main, sub) in [(4, 4), (4, 2), (3, 0), (6, 0), (4, 3)] {
        assert_eq!(rig.set_mode(main, sub), ACCEPTED, "{main}/{sub}");
    }
    assert_eq!(rig.set_mode(3, 0), ACCEPTED);
    assert_eq!(rig.arm(), REJECTED, "POSCTL without a pilot");
    assert_eq!(rig.set_mode(6, 0), ACCEPTED);
    assert_eq!(rig.arm(), REJECTED, "OFFBOARD without setpoints");
    assert_eq!(rig.set_mode(4, 3), ACCEPTED);
    rig.take_off(5.0);
    rig.run(10.0);
    for (main, sub, name) in [(3, 0, "Position"), (4, 4, "Mission"), (6, 0, "Offboard")] {
        assert_eq!(rig.set_mode(main, sub), REJECTED, "{name}");
        assert!(rig.heard(&format!("Switching to {name} is currently not available")));
        assert_eq!(rig.truth().mode, FlightMode::Hold);
    }
}

#[test]
fn set_mode_message_is_answered_as_a_command() {
    let mut rig = Rig::ready(&quiet());
    let before = rig.received.len();
    rig.send_bytes(LinkKind::Onboard, &super::rig::frame(11, &[0, 0, 6, 0, 1, 1]));
    rig.run(0.1);
    let acknowledged = rig.received.iter().skip(before).any(|(_, _, m)| {
        matches!(m, MavMessage::COMMAND_ACK(a) if a.command == MavCmd::MAV_CMD_DO_SET_MODE && a.result == MavResult::MAV_RESULT_ACCEPTED)
    });
    assert!(acknowledged);
    assert_eq!(rig.truth().mode, FlightMode::Offboard);
}

#[test]
fn the_pilot_takes_over_and_keeps_it() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    rig.vehicle.pilot_mode(FlightMode::Position);
    rig.run(3.0);
    let truth = rig.truth();
    assert_eq!(truth.mode, FlightMode::Position);
    assert!(truth.velocity.norm() < 0.1);
    assert_eq!(
        truth.mode_changes.last().map(|c| c.cause),
        Some(crate::ModeCause::Pilot)
    );
}

#[test]
fn reposition_flies_there_and_holds() {
    let mut rig = Rig::flying(&quiet(), 5.0);
    let before = rig.truth();
    let goal = skein_domain::SwarmFrame::new(quiet().origin)
        .geodetic(&before.position.moved(nalgebra::Vector3::new(8.0, 6.0, -2.0)));
    let mut payload: Vec<u8> = [-1.0_f32, 1.0, 0.0, NAN].iter().flat_map(|p| p.to_le_bytes()).collect();
    payload.extend(((goal.latitude_deg * 1e7).round() as i32).to_le_bytes());
    payload.extend(((goal.longitude_deg * 1e7).round() as i32).to_le_bytes());
    payload.extend((goal.altitude_amsl_m as f32).to_le_bytes());
    payload.extend(192_u16.to_le_bytes());
    payload.extend([1, 1, 5, 0, 0]);
    rig.send_bytes(LinkKind::Onboard, &super::rig::frame(75, &payload));
    rig.run(15.0);
    let gone = rig.truth().position.vector() - before.position.vector();
    assert!((gone - nalgebra::Vector3::new(8.0, 6.0, -2.0)).norm() < 0.3, "{gone:?}");
    assert_eq!(rig.truth().mode, FlightMode::Hold);
}

#[test]
fn a_reboot_gives_a_new_origin() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    let p = rig.own_position();
    rig.stream = Some(super::rig::position(p + nalgebra::Vector3::new(6.0, 0.0, 0.0)));
    rig.run(6.0);
    assert_eq!(
        rig.command(246, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        REJECTED,
        "not in the air"
    );
    rig.stream = None;
    rig.land();
    rig.run_until(30.0, |t| !t.armed).expect("lands");
    let before = rig.truth().local_origin;
    assert_eq!(rig.command(246, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ACCEPTED);
    rig.run(2.0);
    assert_eq!(rig.arm(), REJECTED, "not ready again yet");
    let truth = rig.truth();
    assert!((truth.local_origin.distance_m(&before) - 6.0).abs() < 0.5);
    assert!(rig.own_position().norm() < 0.1);
    assert_eq!((truth.landed, truth.mode), (LandedState::OnGround, FlightMode::Hold));
    let boot_ms = rig.last(|m| match m {
        MavMessage::ATTITUDE(a) => Some(a.time_boot_ms),
        _ => None,
    });
    assert!(boot_ms.is_some_and(|ms| ms < 2_000));
}
