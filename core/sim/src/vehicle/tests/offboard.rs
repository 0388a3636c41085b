//! OFFBOARD: entered only with a stream, lost without one, and come back to by itself.

use super::flight::real;
use super::rig::{Rig, position, quiet};
use crate::settings::SimSettings;
use crate::truth::ModeCause;
use crate::vehicle::ParameterValue;
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use skein_domain::FlightMode;

const ACCEPTED: Option<MavResult> = Some(MavResult::MAV_RESULT_ACCEPTED);
const REJECTED: Option<MavResult> = Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED);

fn with(name: &str, value: ParameterValue) -> SimSettings {
    SimSettings {
        parameters: vec![(name.to_owned(), value)],
        ..quiet()
    }
}

#[test]
fn a_lost_stream_leads_to_the_configured_action_and_its_return_back() {
    let actions = [(0, FlightMode::Return), (5, FlightMode::Hold), (4, FlightMode::Land)];
    for (action, mode) in actions {
        let mut rig = Rig::offboard(&with("COM_OBL_RC_ACT", ParameterValue::Int(action)), 5.0);
        let stream = rig.stream.take();
        let lost_after = rig.run_until(3.0, |t| t.mode != FlightMode::Offboard).expect("is lost");
        assert!((1.0..1.2).contains(&lost_after), "{lost_after}");
        assert_eq!(rig.truth().mode, mode);
        assert!(rig.truth().failsafe && rig.heard("Failsafe activated"));
        let status = |m: &MavMessage| match m {
            MavMessage::HEARTBEAT(h) => Some(h.system_status),
            _ => None,
        };
        rig.run(1.1);
        assert_eq!(rig.last(status), Some(MavState::MAV_STATE_CRITICAL));
        rig.stream = stream;
        let back_after = rig
            .run_until(3.0, |t| t.mode == FlightMode::Offboard)
            .expect("comes back by itself");
        assert!(back_after < 1.0, "{back_after}");
        let causes: Vec<_> = rig.truth().mode_changes.iter().rev().take(2).map(|c| c.cause).collect();
        assert_eq!(causes, [ModeCause::Recovered, ModeCause::Failsafe]);
    }
}

#[test]
fn one_hertz_keeps_it_and_four_fifths_do_not() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    rig.stream_period_s = 1.0;
    rig.run(8.0);
    assert_eq!(rig.truth().mode, FlightMode::Offboard);
    let gap = rig.truth().offboard_gap_max_s;
    assert!((0.95..1.05).contains(&gap), "{gap}");
    rig.stream_period_s = 1.25;
    assert!(rig.run_until(5.0, |t| t.mode != FlightMode::Offboard).is_some());
}

#[test]
fn an_explicit_mode_wins_over_the_stream() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    assert_eq!(rig.set_mode(4, 3), ACCEPTED);
    rig.run(5.0);
    assert_eq!(rig.truth().mode, FlightMode::Hold);
    assert_eq!(rig.set_mode(6, 0), ACCEPTED);
    rig.land();
    rig.run(3.0);
    assert_eq!(rig.truth().mode, FlightMode::Land);
}

#[test]
fn after_landing_out_of_offboard_the_mode_shows_offboard_again() {
    let mut rig = Rig::offboard(&quiet(), 3.0);
    rig.land();
    rig.run(2.0);
    rig.stream = None;
    rig.run_until(30.0, |t| !t.armed).expect("lands");
    let truth = rig.truth();
    assert_eq!(truth.mode, FlightMode::Offboard);
    assert_eq!(truth.mode_changes.last().map(|c| c.cause), Some(ModeCause::Disarmed));
    assert_eq!(rig.arm(), REJECTED);
    assert!(rig.heard("Arming denied: Resolve system health failures first"));
    assert_eq!(rig.set_mode(4, 3), ACCEPTED);
    assert_eq!(rig.arm(), ACCEPTED);
}

#[test]
fn with_a_stream_it_can_be_armed_in_offboard_and_take_off_by_setpoint() {
    let mut rig = Rig::ready(&quiet());
    let p = rig.own_position();
    rig.stream = Some(position(p + Vector3::new(0.0, 0.0, -3.0)));
    rig.run(0.5);
    assert_eq!(rig.set_mode(6, 0), ACCEPTED);
    assert_eq!(rig.arm(), ACCEPTED);
    rig.run(12.0);
    assert!((rig.truth().height_m - 3.0).abs() < 0.2, "{}", rig.truth().height_m);
    // And down again: a velocity that leads into the ground is a landing.
    let mut down = position(Vector3::zeros());
    down.vz = 0.7;
    down.type_mask = PositionTargetTypemask::from_bits_retain(0b1101_1100_0111);
    rig.stream = Some(down);
    assert!(rig.run_until(20.0, |t| !t.armed).is_some());
}

#[test]
fn only_the_frames_that_px4_knows_are_taken() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    let mut other = rig.stream.clone().expect("streams");
    other.coordinate_frame = MavFrame::MAV_FRAME_LOCAL_OFFSET_NED;
    rig.stream = Some(other);
    let accepted = rig.truth().setpoints;
    rig.run(0.5);
    assert_eq!(rig.truth().setpoints, accepted);
    assert!(rig.truth().setpoints_refused > 5);
    assert!(rig.heard("SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported"));
    assert!(
        rig.run_until(2.0, |t| t.mode != FlightMode::Offboard).is_some(),
        "they do not keep OFFBOARD alive"
    );
}

#[test]
fn setpoints_for_others_do_not_count() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    let mut other = rig.stream.clone().expect("streams");
    other.target_system = 9;
    rig.stream = Some(other.clone());
    assert!(rig.run_until(2.0, |t| t.mode != FlightMode::Offboard).is_some());
    other.target_system = 0;
    rig.stream = Some(other);
    assert!(rig.run_until(2.0, |t| t.mode == FlightMode::Offboard).is_some());
}

#[test]
fn the_time_out_is_a_parameter() {
    let mut rig = Rig::offboard(&with("COM_OF_LOSS_T", real(0.3)), 5.0);
    rig.stream = None;
    let lost_after = rig.run_until(3.0, |t| t.mode != FlightMode::Offboard).expect("is lost");
    assert!((0.3..0.5).contains(&lost_after), "{lost_after}");
}

#[test]
fn gaps_are_told_apart_from_stalls_of_the_simulation() {
    let mut rig = Rig::offboard(&quiet(), 5.0);
    let stream = rig.stream.take();
    rig.run(0.3);
    rig.vehicle.note_stalls(0.25);
    rig.stream = stream;
    rig.run(0.5);
    let truth = rig.truth();
    assert!((0.3..0.4).contains(&truth.offboard_gap_max_s), "{truth:?}");
    assert!(truth.offboard_gap_sender_max_s < 0.36);
    assert!(truth.offboard_gap_s.is_some_and(|gap| gap < 0.06));
}
