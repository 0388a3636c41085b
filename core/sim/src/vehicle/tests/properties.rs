//! What must hold for any input: no panic, nothing but finite numbers, the same seed the same flight.

use super::rig::{Rig, command_frame, frame, position, quiet};
use crate::settings::SimSettings;
use crate::vehicle::{LinkKind, Outbox, SimVehicle};
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_survived(datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 1..40)) {
        let mut vehicle = SimVehicle::new(super::rig::identity(), &quiet());
        let mut out = Outbox::default();
        for datagram in &datagrams {
            vehicle.receive(LinkKind::Onboard, datagram, &mut out);
            vehicle.step(0.004, &Vector3::zeros(), &mut out);
        }
        prop_assert!(vehicle.truth().position.is_finite());
    }

    #[test]
    fn any_payload_in_a_correct_frame_is_survived(
        id in prop::sample::select(vec![0_u32, 4, 11, 20, 21, 23, 43, 44, 45, 51, 75, 76, 84, 86, 111, 253]),
        payload in prop::collection::vec(any::<u8>(), 0..64),
    ) {
        let mut rig = Rig::offboard(&quiet(), 4.0);
        rig.send_bytes(LinkKind::Onboard, &frame(id, &payload));
        rig.run(1.0);
        let truth = rig.truth();
        prop_assert!(truth.position.is_finite() && truth.velocity.is_finite() && truth.yaw_rad.is_finite());
    }

    #[test]
    fn any_setpoint_leaves_it_finite_and_within_its_limits(
        p in prop::array::uniform3(-1e3..1e3_f64), v in prop::array::uniform3(prop_oneof![-50.0..50.0_f32, Just(f32::NAN), Just(f32::INFINITY)]),
        a in prop::array::uniform3(-50.0..50.0_f32), mask in 0_u16..4096, yaw in -10.0..10.0_f32,
    ) {
        let mut rig = Rig::offboard(&quiet(), 6.0);
        let mut setpoint = position(Vector3::from(p));
        [setpoint.vx, setpoint.vy, setpoint.vz] = v;
        [setpoint.afx, setpoint.afy, setpoint.afz] = a;
        (setpoint.yaw, setpoint.yaw_rate) = (yaw, yaw);
        setpoint.type_mask = PositionTargetTypemask::from_bits_retain(mask);
        rig.stream = Some(setpoint);
        let mut tilt = 0.0_f64;
        rig.run_until(3.0, |t| { tilt = tilt.max(t.tilt_rad); false });
        let truth = rig.truth();
        prop_assert!(truth.position.is_finite() && truth.velocity.is_finite() && truth.yaw_rad.is_finite(), "{truth:?}");
        prop_assert!(tilt < 1.0, "tilt {tilt}");
    }

    #[test]
    fn the_same_seed_gives_the_same_flight(seed in any::<u64>()) {
        let fly = || {
            let mut rig = Rig::ready(&SimSettings { seed, ..SimSettings::default() });
            rig.take_off(3.0);
            rig.run(6.0);
            (rig.truth(), rig.received.len())
        };
        prop_assert_eq!(fly(), fly());
    }

    #[test]
    fn any_command_is_answered_at_most_once_and_survived(
        command in any::<u16>(), param in prop::array::uniform7(prop_oneof![any::<f32>(), Just(f32::NAN), Just(0.0), Just(1.0)]),
    ) {
        let mut rig = Rig::flying(&quiet(), 4.0);
        rig.received.clear();
        rig.send_bytes(LinkKind::Onboard, &command_frame(1, 1, command, param));
        rig.run(2.0);
        let answers = rig.received.iter().filter(|(_, _, m)| matches!(m, MavMessage::COMMAND_ACK(_))).count();
        prop_assert!(answers + rig.nameless_answers <= 1);
        prop_assert!(rig.truth().position.is_finite());
    }
}
