//! Any bytes as the life of a vehicle over DDS: nothing panics, nothing comes out that is no number.

#[path = "../../../tests/fuzz/src/drive_dds.rs"]
mod drive_dds;

use proptest::prelude::*;

/// Octets that floats, truth values and lengths are sensitive to.
fn octet() -> impl Strategy<Value = u8> {
    prop_oneof![
        Just(0_u8),
        Just(1),
        Just(0x7F),
        Just(0x80),
        Just(0xF0),
        Just(0xFF),
        any::<u8>()
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    #[test]
    fn any_life_is_survived(data in prop::collection::vec(any::<u8>(), 0..1500)) {
        drive_dds::drive(&data);
    }

    /// Operations that make sense more often than chance would have it, on a vehicle that is admitted.
    #[test]
    fn likely_lives_are_survived(
        release in 0_u8..5,
        operations in prop::collection::vec(
            prop_oneof![
                // A good sample, or one with some octets changed, after some time.
                (0_u8..16, 0_u8..10, any::<u8>(), prop::collection::vec((0_u8..110, 0_u8..110, octet()), 0..6)).prop_map(
                    |(time, topic, ahead, changes)| {
                        let mut bytes = vec![time << 3 | 2, topic, ahead, changes.len() as u8];
                        bytes.extend(changes.iter().flat_map(|(at, more, value)| [*at, *more, *value]));
                        bytes
                    }
                ),
                // Octets as they come.
                (0_u8..22, 0_u8..4, prop::collection::vec(octet(), 0..240))
                    .prop_map(|(which, encoding, octets)| [vec![1, which, encoding, (octets.len() / 2) as u8], octets].concat()),
                // A setpoint with any numbers, valid for a while.
                (0_u8..32, prop::collection::vec(octet(), 48)).prop_map(|(parts, numbers)| [vec![5, parts, 60], numbers].concat()),
                // Half a second passes, with ticks.
                Just([0xFE_u8, 6].repeat(2)),
                // Requests and the like.
                (0_u8..8).prop_map(|which| vec![4, which, 0, 0, 0x14, 0x40]),
                (0_u8..4).prop_map(|which| vec![7, which]),
            ],
            0..200,
        )
    ) {
        drive_dds::drive(&[vec![release << 1], operations.concat()].concat());
    }
}
