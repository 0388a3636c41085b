//! The codes of manifests are those on the wire.

use super::*;
use crate::{RequestId, Setpoint, command::AutopilotCommand};

#[test]
fn codes_are_the_numbers_of_the_variants_on_the_wire() {
    let effects = [
        Effect::Setpoint(Setpoint::default()),
        Effect::StopStream,
        Effect::Autopilot {
            request: RequestId(1),
            command: AutopilotCommand::Arm,
        },
        Effect::TrackingError { distance_m: 1.0 },
        Effect::RouteFinished,
    ];
    for effect in effects {
        let bytes = minicbor::to_vec(&effect).expect("encodes");
        // A variant is an array of its number and its fields.
        let mut decoder = minicbor::Decoder::new(&bytes);
        decoder.array().expect("an array");
        assert_eq!(
            decoder.u32().expect("a number"),
            effect.kind().code(),
            "{}",
            effect.kind()
        );
    }
    for (i, kind) in EffectKind::ALL.iter().enumerate() {
        assert_eq!(EffectKind::from_code(i as u32), Some(*kind));
        assert_eq!(kind.code() as usize, i);
    }
    assert_eq!(EffectKind::from_code(EffectKind::ALL.len() as u32), None);
}
