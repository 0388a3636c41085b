//! Rates, clocks, losses and parameters over good and bad lines.

use crate::rig::Rig;
use skein_domain::link::LinkEvent;
use skein_domain::{AutopilotCommand, FlightMode, ParameterError, ParameterValue, Refusal};
use skein_px4::{LinkSettings, MessageRates};

#[test]
fn only_what_is_read_is_sent_and_at_the_asked_rate() {
    let mut rig = Rig::new();
    rig.run(2.0);
    let before: u32 = rig.received.values().sum();
    assert!(
        before > 300,
        "PX4 sends hundreds of messages per second unasked: {before}"
    );
    rig.run(10.0);
    rig.received.clear();
    rig.run(10.0);
    let wanted = [
        (32, 50.0),
        (30, 10.0),
        (33, 5.0),
        (245, 2.0),
        (1, 1.0),
        (24, 2.0),
        (230, 1.0),
        (147, 1.0),
        (242, 0.5),
    ];
    for (id, rate_hz) in wanted {
        let measured_hz = f64::from(rig.received.remove(&id).unwrap_or(0)) / 10.0;
        assert!(
            (measured_hz - rate_hz).abs() <= rate_hz * 0.1 + 0.15,
            "message {id}: {measured_hz}"
        );
    }
    let heartbeats_hz = f64::from(rig.received.remove(&0).unwrap()) / 10.0;
    assert!((0.9..=4.4).contains(&heartbeats_hz));
    let timesync_hz = f64::from(rig.received.remove(&111).unwrap_or(0)) / 10.0;
    assert!(timesync_hz < 1.3, "only answers: {timesync_hz}");
    let rest: f64 = rig.received.values().map(|count| f64::from(*count) / 10.0).sum();
    // PX4 sends MISSION_CURRENT once a second whatever it is told.
    assert!(rest < 2.0, "the rest is off: {:?}", rig.received);
}

#[test]
fn rates_are_left_alone_where_they_are_not_ours() {
    let rates = MessageRates {
        manage: false,
        ..MessageRates::default()
    };
    let mut rig = Rig::with(
        LinkSettings {
            rates,
            ..LinkSettings::default()
        },
        skein_sim::SimSettings::default(),
    );
    rig.run(10.0);
    assert!(
        rig.sent
            .iter()
            .all(|(_, id, payload)| *id != 76 || payload[28..30] != 511_u16.to_le_bytes())
    );
}

#[test]
fn positions_carry_the_time_they_were_measured_at() {
    let mut rig = Rig::new();
    rig.delay_s = 0.06;
    rig.run(20.0);
    let (telemetry, health) = rig.read();
    let age_s = rig.now_s - telemetry.position_time.as_seconds();
    assert!(
        (0.055..0.095).contains(&age_s),
        "sixty milliseconds on the way, and up to a period old: {age_s}"
    );
    assert!(
        (f64::from(health.round_trip_s.unwrap()) - 0.12).abs() < 0.02,
        "{health:?}"
    );
    // The vehicle's clock began when the node's was at fifty seconds.
    assert!((health.clock_offset_s.unwrap() + 50.0).abs() < 0.01, "{health:?}");
}

#[test]
fn losses_are_measured_and_a_lossy_line_still_flies() {
    let mut rig = Rig::new();
    // A line that loses a fifth, each way, in no pattern.
    let mut state = 12_345_u32;
    let mut lossy = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8 > (1 << 24) / 5
    };
    let mut other = lossy;
    rig.passes_down = Box::new(move |_, _| lossy());
    rig.passes_up = Box::new(move |_, _| {
        other();
        other()
    });
    rig.take_off();
    rig.run(6.0);
    let loss = rig.read().1.loss;
    assert!((0.14..0.26).contains(&loss), "{loss}");
    assert_eq!(rig.ask(AutopilotCommand::Land), Ok(()));
    assert!(
        !rig.modes().iter().any(|(_, _, commanded)| !commanded),
        "{:?}",
        rig.modes()
    );
    assert!(!rig.has(&LinkEvent::Lost));
}

#[test]
fn a_node_that_stood_still_has_lost_nobody() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.now_s += 2.0;
    assert!(rig.read().1.connected, "nothing was listened for");
    rig.run(1.0);
    assert!(!rig.has(&LinkEvent::Lost));
    // Who is silent is lost all the same, after the time in which it was listened for.
    rig.passes_down = Box::new(|_, _| false);
    rig.run(1.0);
    rig.now_s += 2.0;
    let went_on_s = rig.now_s;
    rig.run_until("lost", 2.0, |rig| rig.has(&LinkEvent::Lost));
    assert!((rig.now_s - went_on_s - 0.5).abs() < 0.1, "{}", rig.now_s - went_on_s);
}

#[test]
fn silence_is_a_loss_and_the_first_frame_a_return() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.passes_down = Box::new(|_, _| false);
    let silent_s = rig.now_s;
    assert!(rig.read().0.ready_to_arm.is_some());
    rig.run_until("lost", 3.0, |rig| rig.has(&LinkEvent::Lost));
    assert_eq!(rig.read().0.ready_to_arm, None, "nobody knows");
    assert!((rig.now_s - silent_s - 1.5).abs() < 0.1, "{}", rig.now_s - silent_s);
    assert!(!rig.read().1.connected);
    assert!(matches!(rig.ask(AutopilotCommand::Land), Err(Refusal::LinkLost { .. })));
    assert_eq!(
        rig.truth().mode,
        FlightMode::Offboard,
        "it still gets its setpoints: only we do not hear it"
    );
    rig.passes_down = Box::new(|_, _| true);
    rig.run_until("regained", 1.0, |rig| rig.has(&LinkEvent::Regained));
    rig.run_until("ready or not", 2.0, |rig| rig.read().0.ready_to_arm.is_some());
    assert_eq!(rig.ask(AutopilotCommand::Land), Ok(()));
}

#[test]
fn a_lost_command_or_answer_is_made_up_for() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    let mut commands = 0;
    rig.passes_up = Box::new(move |_, bytes| {
        let is_arm = bytes[7] == 76 && bytes[10 + 28..10 + 30] == 400_u16.to_le_bytes();
        commands += u32::from(is_arm);
        !is_arm || commands > 2
    });
    let mut answers = 0;
    rig.passes_down = Box::new(move |_, bytes| {
        let is_answer = bytes[7] == 77 && bytes[10..12] == 400_u16.to_le_bytes();
        answers += u32::from(is_answer);
        !is_answer || answers > 1
    });
    assert_eq!(rig.ask(AutopilotCommand::Arm), Ok(()));
    let sent: Vec<u8> = rig
        .sent
        .iter()
        .filter(|(_, id, p)| *id == 76 && p[28..30] == 400_u16.to_le_bytes())
        .map(|(_, _, payload)| payload.get(32).copied().unwrap_or(0))
        .collect();
    assert_eq!(sent, [0, 1, 2, 3], "the confirmation counts");
}

#[test]
fn parameters_over_the_line() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    let finish = |rig: &mut Rig| {
        let mut found = Vec::new();
        rig.run_until("parameter", 5.0, |rig| {
            found = rig.core().parameters().take_events();
            !found.is_empty()
        });
        assert_eq!(found.len(), 1);
        found.pop().unwrap().outcome
    };
    let now = rig.now();
    rig.core()
        .parameter(now, "COM_OBL_RC_ACT", Some(ParameterValue::Integer(5)))
        .unwrap();
    assert_eq!(finish(&mut rig), Ok(ParameterValue::Integer(5)));
    let now = rig.now();
    rig.core().parameter(now, "COM_OBL_RC_ACT", None).unwrap();
    assert_eq!(finish(&mut rig), Ok(ParameterValue::Integer(5)));
    let now = rig.now();
    rig.core()
        .parameter(now, "COM_OF_LOSS_T", Some(ParameterValue::Integer(2)))
        .unwrap();
    assert_eq!(finish(&mut rig), Ok(ParameterValue::Real(2.0)));
    let now = rig.now();
    rig.core()
        .parameter(now, "NO_SUCH_THING", Some(ParameterValue::Integer(2)))
        .unwrap();
    assert!(matches!(
        finish(&mut rig),
        Err(ParameterError::NoAnswer { .. } | ParameterError::Unknown { .. })
    ));
    assert_eq!(
        rig.core().parameters().known("COM_OBL_RC_ACT"),
        Some(ParameterValue::Integer(5))
    );
    assert!(
        rig.core().identity().firmware.is_some(),
        "and who it is, is known by then"
    );
}
