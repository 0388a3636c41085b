//! Any bytes as the life of a link: nothing panics, nothing leaves that must not.

#[path = "../../../tests/fuzz/src/drive.rs"]
mod drive;

use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn any_life_is_survived(data in prop::collection::vec(any::<u8>(), 0..1500)) {
        drive::drive(&data);
    }

    /// Operations that make sense more often than chance would have it.
    #[test]
    fn likely_lives_are_survived(
        operations in prop::collection::vec(
            prop_oneof![
                // A message with plausible numbers in it.
                (0_u8..3, 0_u8..20, any::<u8>(), prop::collection::vec(prop_oneof![Just(0_u8), Just(1), any::<u8>()], 0..60))
                    .prop_map(|(op, which, sequence, payload)| {
                        let mut bytes = vec![op, which, 0, sequence, payload.len() as u8];
                        bytes.extend(payload);
                        bytes
                    }),
                // A setpoint at rest, valid for a while.
                Just([vec![5, 3, 30], vec![0; 24]].concat()),
                // Half a second passes, with ticks.
                Just([0xFE_u8, 6].repeat(2)),
                // Requests.
                (0_u8..8).prop_map(|which| vec![4, which, 4, 0, 0, 0]),
            ],
            0..200,
        )
    ) {
        drive::drive(&operations.concat());
    }
}
