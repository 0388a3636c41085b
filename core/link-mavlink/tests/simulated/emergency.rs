//! The emergency stop: at once, ahead of everything, through losses, and never halfway.

use crate::rig::Rig;
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::{AutopilotCommand, FlightMode, Refusal};
use skein_px4::{LinkSettings, MessageRates};
use skein_sim::{Fault, SimSettings};

/// Times at which the forced disarm was sent since `from_s`.
fn stops(rig: &Rig, from_s: f64) -> Vec<f64> {
    let forced = |payload: &[u8]| payload[28..30] == 400_u16.to_le_bytes() && payload[4..8] == 21_196_f32.to_le_bytes();
    let sent = rig
        .sent
        .iter()
        .filter(|(t, id, payload)| *t >= from_s && *id == 76 && forced(payload));
    sent.map(|(t, ..)| *t).collect()
}

#[test]
fn the_motors_stop_at_once_and_nothing_is_streamed_any_more() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.steer_north(3.0);
    rig.run(2.0);
    let asked_s = rig.now_s;
    let request = rig.request(AutopilotCommand::EmergencyStop);
    assert_eq!(stops(&rig, asked_s), [asked_s], "in the same moment");
    rig.run_until("motors off", 0.1, |rig| !rig.truth().armed);
    rig.run_until("outcome", 1.0, |rig| rig.outcome(request).is_some());
    assert_eq!(rig.outcome(request), Some(Ok(())));
    assert!(!rig.truth().touches_ground, "it was seen before it hit the ground");
    assert_eq!(rig.stream().last(), Some(&StreamState::Stopped));
    assert_eq!(
        rig.setpoints(asked_s + 0.001, rig.now_s),
        0,
        "though the actor goes on by habit"
    );
    let sent = stops(&rig, asked_s).len();
    rig.run(3.0);
    assert!(rig.truth().touches_ground && rig.truth().touch_down_max_m_s > 10.0);
    assert_eq!(stops(&rig, asked_s).len(), sent, "it has ended");
    assert!(rig.has(&LinkEvent::ArmedChanged { armed: false }));
}

#[test]
fn it_goes_ahead_of_all_that_is_under_way_and_nothing_flies_beside_it() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    assert_eq!(rig.ask(AutopilotCommand::Arm), Ok(()));
    assert_eq!(rig.ask(AutopilotCommand::TakeOff { height_m: 10.0 }), Ok(()));
    rig.run(8.0);
    // A disarm has the same number and is on its way; a landing waits for its acknowledgement.
    let disarm = rig.request(AutopilotCommand::Disarm);
    let land = rig.request(AutopilotCommand::Land);
    let asked_s = rig.now_s;
    let stop = rig.request(AutopilotCommand::EmergencyStop);
    assert_eq!(stops(&rig, asked_s), [asked_s]);
    let arm = rig.request(AutopilotCommand::Arm);
    assert!(matches!(rig.outcome(arm), Some(Err(Refusal::NotPermitted { .. }))));
    rig.run_until("outcome", 2.0, |rig| rig.outcome(stop).is_some());
    assert_eq!(rig.outcome(stop), Some(Ok(())));
    assert!(!rig.truth().armed);
    for replaced in [disarm, land] {
        assert_eq!(rig.outcome(replaced), Some(Err(Refusal::Superseded)));
    }
}

#[test]
fn it_gets_through_a_line_that_loses_most() {
    for seed in 0..5_u32 {
        let mut rig = Rig::new();
        rig.take_off();
        // Four of five datagrams are lost each way.
        let lossy = move |number: u32, _: &[u8]| number.wrapping_add(seed).wrapping_mul(2_654_435_761) >> 29 == 0;
        rig.passes_up = Box::new(lossy);
        rig.passes_down = Box::new(move |number, _| number.wrapping_mul(40_503).wrapping_add(seed) % 5 == 0);
        let request = rig.request(AutopilotCommand::EmergencyStop);
        rig.run_until("motors off", 2.0, |rig| !rig.truth().armed);
        rig.run_until("outcome", 6.0, |rig| rig.outcome(request).is_some());
        assert_eq!(rig.outcome(request), Some(Ok(())), "seed {seed}");
    }
}

#[test]
fn a_vehicle_that_is_not_heard_may_hear() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.passes_down = Box::new(|_, _| false);
    rig.run(3.0);
    assert!(!rig.read().1.connected);
    let asked_s = rig.now_s;
    let request = rig.request(AutopilotCommand::EmergencyStop);
    rig.run(1.0);
    assert!(!rig.truth().armed);
    rig.run_until("outcome", 12.0, |rig| rig.outcome(request).is_some());
    assert!(matches!(rig.outcome(request), Some(Err(Refusal::TimedOut { .. }))));
    let sent = stops(&rig, asked_s);
    let longest = sent.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(
        longest < 0.07 && sent.len() > 150,
        "{} times, {longest} s apart",
        sent.len()
    );
}

#[test]
fn one_that_does_not_hear_is_told_of_in_bounded_time_and_the_next_try_works() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.vehicle.inflict(Fault::Silent(true));
    let first = rig.request(AutopilotCommand::EmergencyStop);
    rig.run(0.9);
    assert!(!rig.is_told(|event| matches!(event, LinkEvent::StopUnconfirmed { .. })));
    rig.run(0.2);
    assert!(rig.is_told(|event| matches!(event, LinkEvent::StopUnconfirmed { .. })));
    rig.run(2.9);
    let second = rig.request(AutopilotCommand::EmergencyStop);
    assert_eq!(rig.outcome(first), Some(Err(Refusal::Superseded)));
    rig.vehicle.inflict(Fault::Silent(false));
    rig.run_until("outcome", 3.0, |rig| rig.outcome(second).is_some());
    assert_eq!((rig.outcome(second), rig.truth().armed), (Some(Ok(())), false));
}

#[test]
fn with_a_heartbeat_a_second_it_is_repeated_slowly_once_acknowledged() {
    let settings = LinkSettings {
        rates: MessageRates {
            heartbeat_hz: 1.0,
            ..MessageRates::default()
        },
        ..LinkSettings::default()
    };
    let mut rig = Rig::with(settings, SimSettings::default());
    rig.take_off();
    let asked_s = rig.now_s;
    let request = rig.request(AutopilotCommand::EmergencyStop);
    rig.run_until("outcome", 2.0, |rig| rig.outcome(request).is_some());
    assert_eq!(rig.outcome(request), Some(Ok(())));
    assert!(stops(&rig, asked_s).len() <= 8, "{:?}", stops(&rig, asked_s));
    assert_eq!(rig.ask(AutopilotCommand::SetMode { mode: FlightMode::Hold }), Ok(()));
}
