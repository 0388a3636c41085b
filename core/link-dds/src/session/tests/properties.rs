//! Any life of a session is survived, and nothing leaves that must not.

use crate::cdr::Encoding;
use crate::definitions::DEFINITIONS;
use crate::session::VehicleSession;
use crate::session::setpoint::Outgoing;
use crate::specimen;
use proptest::prelude::*;
use skein_domain::link::StreamState;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, FlightMode, LocalPositionNed, NodeTime, RequestId};
use skein_px4::LinkSettings;

#[derive(Debug, Clone)]
enum Step {
    Noise(usize, Vec<u8>),
    Good(usize, u64),
    Ask(u8, f64),
    Setpoint(f64, f64),
    Stop,
    Wait(f64),
}

fn any_step() -> impl Strategy<Value = Step> {
    let number = prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(1e308), -100.0..100.0_f64];
    prop_oneof![
        (0..DEFINITIONS.len(), prop::collection::vec(any::<u8>(), 0..300))
            .prop_map(|(which, bytes)| Step::Noise(which, bytes)),
        (0..DEFINITIONS.len(), prop_oneof![any::<u64>(), 0..100_000_000_u64])
            .prop_map(|(which, stamp)| Step::Good(which, stamp)),
        (any::<u8>(), number.clone()).prop_map(|(which, height_m)| Step::Ask(which, height_m)),
        (number, 0.0..2.0_f64).prop_map(|(north_m, for_s)| Step::Setpoint(north_m, for_s)),
        Just(Step::Stop),
        (0.0..3.0_f64).prop_map(Step::Wait),
    ]
}

fn command(which: u8, height_m: f64) -> AutopilotCommand {
    match which % 8 {
        0 => AutopilotCommand::Arm,
        1 => AutopilotCommand::Disarm,
        2 => AutopilotCommand::TakeOff { height_m },
        3 => AutopilotCommand::Land,
        4 => AutopilotCommand::ReturnToLaunch,
        5 => AutopilotCommand::SetMode {
            mode: FlightMode::ALL[usize::from(which) % FlightMode::ALL.len()],
        },
        6 => AutopilotCommand::EnterOffboard,
        _ => AutopilotCommand::EmergencyStop,
    }
}

fn live(session: &mut VehicleSession, now: &mut NodeTime, step: &Step, requests: &mut u32) {
    match step {
        Step::Noise(which, bytes) => {
            if let Ok(sample) = DEFINITIONS[*which].read(Encoding::LittleEndian, bytes) {
                session.on_sample(*now, &sample);
            }
        }
        Step::Good(which, stamp_us) => {
            let definition = &DEFINITIONS[*which];
            let bytes = specimen::sample(definition.topic, definition.releases[0], *stamp_us);
            if let Ok(sample) = definition.read(Encoding::LittleEndian, &bytes) {
                session.on_sample(*now, &sample);
            }
        }
        Step::Ask(which, height_m) => {
            *requests += 1;
            session.request(*now, RequestId(*requests), command(*which, *height_m));
        }
        Step::Setpoint(north_m, for_s) => {
            let position = Some(LocalPositionNed::new(*north_m, 0.0, -5.0));
            let setpoint = LocalSetpoint {
                position,
                ..LocalSetpoint::default()
            };
            session.stream(*now, setpoint, now.plus_seconds(*for_s));
        }
        Step::Stop => session.stop_stream(*now),
        Step::Wait(for_s) => *now = now.plus_seconds(*for_s),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn any_life_is_survived(steps in prop::collection::vec(any_step(), 0..120)) {
        let mut now = NodeTime::from_seconds(10.0);
        let mut session = VehicleSession::new(&LinkSettings::default(), 7, now);
        let mut requests = 0;
        for step in &steps {
            let before = session.stream_state();
            live(&mut session, &mut now, step, &mut requests);
            session.on_tick(now);
            let streamed = [before, session.stream_state()];
            for outgoing in session.take_outgoing() {
                let Outgoing::Setpoint(mode, setpoint) = outgoing else { continue };
                prop_assert!(
                    streamed.iter().any(|state| matches!(state, StreamState::Fresh | StreamState::HoldingExpired)),
                    "a setpoint left while {streamed:?}"
                );
                prop_assert!(!mode.position || setpoint.position.iter().all(|part| part.is_finite()));
                prop_assert!(mode.position || mode.velocity);
            }
            let (telemetry, health) = session.read(now);
            prop_assert!(telemetry.local.is_none_or(|local| local.is_finite()));
            prop_assert!(telemetry.global.is_none_or(|place| place.is_valid()));
            prop_assert!(telemetry.local_frame.is_none_or(|frame| frame.origin.is_valid()));
            prop_assert!(telemetry.yaw_rad.is_finite() && health.receive_rate_hz.is_finite());
            session.take_events();
        }
    }
}
