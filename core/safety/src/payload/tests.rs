//! Nothing that flies, arms or sets a vehicle passes, whatever kind of payload sends it; what a payload is for does.

use super::*;
use crate::gate::Limits;
use proptest::prelude::*;

const OWN: SystemId = SystemId(7);
const KINDS: [PayloadKind; 4] = [
    PayloadKind::Gimbal,
    PayloadKind::Camera,
    PayloadKind::Radio,
    PayloadKind::Detector,
];

fn gate() -> Gate {
    let limits = Limits {
        max_speed_m_s: 10.0,
        max_climb_m_s: 3.0,
        max_descent_m_s: 2.0,
        min_separation_m: 2.0,
        separation_horizon_s: 0.8,
    };
    Gate::new(limits, None)
}

fn message(message_id: u32, payload: Vec<u8>) -> MavlinkMessage {
    MavlinkMessage {
        message_id,
        payload,
        ..MavlinkMessage::default()
    }
}

/// COMMAND_LONG or COMMAND_INT with its first two parameters, and its trailing zeros cut off as on the wire.
fn command_message(message_id: u32, number: u16, target: (u8, u8), first: f32, second: f32) -> MavlinkMessage {
    let mut payload = vec![0; 33];
    payload[0..4].copy_from_slice(&first.to_le_bytes());
    payload[4..8].copy_from_slice(&second.to_le_bytes());
    payload[28..30].copy_from_slice(&number.to_le_bytes());
    (payload[30], payload[31]) = target;
    while payload.last() == Some(&0) {
        payload.pop();
    }
    message(message_id, payload)
}

fn passes(kind: PayloadKind, message: &MavlinkMessage) -> bool {
    match gate().payload_message(kind, OWN, message) {
        Ok(()) => true,
        Err(Refusal::NotPermitted { detail }) => {
            assert!(detail.len() > 20, "a sentence: {detail}");
            false
        }
        Err(other) => panic!("{other:?}"),
    }
}

fn any_kind() -> impl Strategy<Value = PayloadKind> {
    prop::sample::select(KINDS.to_vec())
}

/// Payloads that are addressed to the vehicle wherever the target may stand.
fn any_payload() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        prop::collection::vec(any::<u8>(), 0..=255),
        prop::collection::vec(Just(OWN.0), 0..=60)
    ]
}

/// What flies, arms, sets or reprograms a vehicle: set mode, parameters, missions and fences, manual control and overrides,
/// setpoints of every kind, actuators, home and origin, external position, serial lines and files, tunnels.
const NEVER: [u32; 45] = [
    5, 7, 11, 20, 21, 23, 37, 38, 39, 40, 41, 43, 44, 45, 46, 47, 48, 50, 51, 54, 66, 67, 69, 70, 73, 81, 82, 84, 86,
    100, 101, 102, 103, 104, 110, 123, 126, 139, 140, 232, 233, 243, 256, 331, 385,
];

/// Commands that fly, arm, reboot, calibrate, release or set: each number below 195, and those above by name.
const NEVER_COMMANDED: [u16; 32] = [
    201, 203, 204, 205, 206, 207, 208, 209, 210, 211, 212, 214, 222, 223, 240, 241, 242, 243, 245, 246, 252, 300, 310,
    311, 400, 420, 500, 520, 2520, 3000, 5000, 42429,
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn what_flies_or_sets_a_vehicle_never_passes(kind in any_kind(), id in prop::sample::select(NEVER.to_vec()), payload in any_payload()) {
        prop_assert!(!passes(kind, &message(id, payload)));
    }

    #[test]
    fn no_command_that_flies_or_arms_passes(
        kind in any_kind(), id in prop::sample::select(vec![COMMAND_LONG, COMMAND_INT]),
        number in prop_oneof![0_u16..195, prop::sample::select(NEVER_COMMANDED.to_vec())],
        component in any::<u8>(), first in any::<f32>(), second in any::<f32>(),
    ) {
        prop_assert!(!passes(kind, &command_message(id, number, (OWN.0, component), first, second)));
    }

    #[test]
    fn only_what_is_named_passes_and_only_to_the_own_system(kind in any_kind(), id in 0_u32..70_000, payload in any_payload()) {
        let sent = message(id, payload);
        if !passes(kind, &sent) {
            return Ok(());
        }
        let fields = Fields(&sent.payload);
        let target = match id {
            75 | 76 | 284 => fields.byte(30),
            282 => fields.byte(32),
            287 | 288 => fields.byte(20),
            320 => fields.byte(2),
            321 | 323 => fields.byte(0),
            _ => return Err(TestCaseError::fail(format!("message {id} passed"))),
        };
        prop_assert_eq!(target, OWN.0);
        let sender = if matches!(id, 320 | 321 | 323) { PayloadKind::Camera } else { PayloadKind::Gimbal };
        prop_assert!(kind == sender || id == COMMAND_LONG);
    }

    #[test]
    fn nothing_passes_to_another_system(kind in any_kind(), number in any::<u16>(), other in any::<u8>(), first in 250_f32..290.0) {
        prop_assume!(other != OWN.0);
        prop_assert!(!passes(kind, &command_message(COMMAND_LONG, number, (other, 1), first.round(), 0.0)));
    }
}

#[test]
fn what_a_payload_is_for_passes() {
    for (id, target_at) in GIMBAL_MESSAGES {
        let mut payload = vec![0; target_at + 2];
        payload[target_at] = OWN.0;
        assert!(passes(PayloadKind::Gimbal, &message(id, payload.clone())), "{id}");
        assert!(!passes(PayloadKind::Camera, &message(id, payload.clone())), "{id}");
        payload[target_at] = 0;
        assert!(!passes(PayloadKind::Gimbal, &message(id, payload)), "{id}: to everyone");
    }
    for number in GIMBAL_COMMANDS {
        for id in [COMMAND_LONG, COMMAND_INT] {
            let sent = command_message(id, number, (OWN.0, 1), 0.0, 0.0);
            assert!(passes(PayloadKind::Gimbal, &sent), "{number}");
            assert!(!passes(PayloadKind::Camera, &sent), "{number}");
        }
    }
    for number in CAMERA_COMMANDS {
        let sent = command_message(COMMAND_LONG, number, (OWN.0, 100), 1.0, 0.0);
        assert!(passes(PayloadKind::Camera, &sent), "{number}");
        assert!(!passes(PayloadKind::Gimbal, &sent), "{number}");
    }
    for kind in [PayloadKind::Radio, PayloadKind::Detector] {
        assert!(!passes(
            kind,
            &command_message(COMMAND_LONG, 512, (OWN.0, 1), 109.0, 0.0)
        ));
    }
}

#[test]
fn a_payload_asks_for_its_own_messages_only_and_not_too_often() {
    let ask = |kind, number, first, second| passes(kind, &command_message(76, number, (OWN.0, 1), first, second));
    for id in GIMBAL_REPORTS {
        assert!(ask(PayloadKind::Gimbal, REQUEST_MESSAGE, id as f32, 0.0));
        assert!(ask(PayloadKind::Gimbal, SET_MESSAGE_INTERVAL, id as f32, 100_000.0));
        assert!(!ask(PayloadKind::Camera, REQUEST_MESSAGE, id as f32, 0.0));
    }
    for id in CAMERA_REPORTS {
        assert!(ask(PayloadKind::Camera, REQUEST_MESSAGE, id as f32, 0.0));
        assert!(!ask(PayloadKind::Gimbal, SET_MESSAGE_INTERVAL, id as f32, 100_000.0));
    }
    let gimbal = PayloadKind::Gimbal;
    assert!(ask(gimbal, SET_MESSAGE_INTERVAL, 285.0, -1.0));
    assert!(ask(gimbal, SET_MESSAGE_INTERVAL, 285.0, 0.0));
    for interval_us in [1.0, 9_999.0, -2.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(!ask(gimbal, SET_MESSAGE_INTERVAL, 285.0, interval_us), "{interval_us}");
    }
    // The autopilot's own streams stay as its link has set them.
    for id in [0.0, 30.0, 32.0, 33.0, 280.5, f32::NAN, f32::INFINITY] {
        assert!(!ask(gimbal, SET_MESSAGE_INTERVAL, id, 100_000.0), "{id}");
    }
}

#[test]
fn a_cameras_settings_are_never_the_autopilots() {
    for (id, target_at) in CAMERA_SETTINGS {
        for (component, permitted) in [
            (100, true),
            (105, true),
            (106, false),
            (154, false),
            (1, false),
            (0, false),
        ] {
            let mut payload = vec![0; 20];
            (payload[target_at], payload[target_at + 1]) = (OWN.0, component);
            assert_eq!(
                passes(PayloadKind::Camera, &message(id, payload)),
                permitted,
                "{id} to {component}"
            );
        }
    }
}

#[test]
fn a_cameras_storage_is_never_the_autopilots() {
    for number in STORAGE_COMMANDS {
        for (component, permitted) in [(100, true), (105, true), (154, false), (1, false), (0, false)] {
            let sent = command_message(COMMAND_LONG, number, (OWN.0, component), 1.0, 1.0);
            assert_eq!(passes(PayloadKind::Camera, &sent), permitted, "{number} to {component}");
        }
    }
}

#[test]
fn a_recording_is_not_reported_on_more_often_than_a_message_may_be_asked_for() {
    for (rate_hz, permitted) in [
        (0.0, true),
        (1.0, true),
        (100.0, true),
        (101.0, false),
        (f32::INFINITY, false),
    ] {
        let sent = command_message(COMMAND_LONG, VIDEO_START_CAPTURE, (OWN.0, 100), 0.0, rate_hz);
        assert_eq!(passes(PayloadKind::Camera, &sent), permitted, "{rate_hz}");
    }
}
