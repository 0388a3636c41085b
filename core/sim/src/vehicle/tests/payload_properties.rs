//! What must hold whatever payloads are asked: limits, one answer at most, and no flight of it.

use super::payloads::{all, take_control};
use super::rig::{Rig, command_frame, frame};
use crate::vehicle::LinkKind;
use mavlink::dialects::common::MavMessage;
use proptest::prelude::*;

fn likely() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>(),
        Just(f32::NAN),
        Just(0.0),
        Just(1.0),
        -200_f32..200.0,
        prop::sample::select(vec![245.0, 190.0, 259.0, 271.0, 283.0, 285.0, 1e6]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn an_interval_without_end_is_survived(interval_us in likely(), id in prop::sample::select(vec![30_f32, 285.0, 262.0])) {
        let mut rig = Rig::ready(&all());
        for component in [1, 100, 154] {
            rig.command_to(1, component, 511, [id, interval_us * 1e36, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        rig.run(0.5);
        prop_assert!(rig.truth().position.is_finite());
    }

    #[test]
    fn whatever_payloads_are_asked_is_answered_once_at_most_and_within_their_limits(
        asked in prop::collection::vec(
            (
                prop::sample::select(vec![195_u16, 197, 400, 511, 512, 521, 525, 526, 529, 530, 531, 1000, 1001, 2000, 2001, 2500, 2501, 2502]),
                prop::sample::select(vec![0_u8, 1, 100, 154]), prop::array::uniform7(likely()),
            ),
            1..12,
        ),
        messages in prop::collection::vec((prop::sample::select(vec![282_u32, 284, 287, 288]), prop::collection::vec(any::<u8>(), 0..36)), 0..6),
    ) {
        let settings = all();
        let mut rig = Rig::ready(&settings);
        take_control(&mut rig);
        for (command, component, param) in asked {
            rig.received.clear();
            rig.send_bytes(LinkKind::Onboard, &command_frame(1, component, command, param));
            rig.run(0.2);
            let answers = rig.received.iter().filter(|(_, _, m)| matches!(m, MavMessage::COMMAND_ACK(_))).count();
            prop_assert!(answers + rig.nameless_answers <= 1, "{command} to {component}");
            rig.nameless_answers = 0;
        }
        for (id, mut payload) in messages {
            // To this vehicle, wherever the target stands.
            payload.resize(36, 0);
            for at in [20, 30, 32] {
                (payload[at], payload[at + 1]) = (1, 1);
            }
            let len = if id == 284 { 32 } else if id == 282 { 35 } else { 23 };
            rig.send_bytes(LinkKind::Onboard, &frame(id, &payload[..len]));
            rig.run(0.2);
        }
        let truth = rig.truth();
        let (gimbal, camera) = (truth.gimbal.unwrap(), truth.camera.unwrap());
        let limits = settings.payloads.gimbal.unwrap();
        prop_assert!((limits.pitch_min_rad..=limits.pitch_max_rad).contains(&gimbal.pitch_rad));
        prop_assert!(gimbal.yaw_vehicle_rad.abs() <= limits.yaw_max_rad);
        prop_assert!((1.0..=6.0).contains(&camera.zoom_factor));
        prop_assert!(!truth.armed || truth.touches_ground, "no payload's message takes off");
    }
}
