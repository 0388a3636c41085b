//! The table has no two meanings, and any bytes are survived.

use super::*;
use crate::cdr::encode;
use crate::messages::v1_15;
use crate::naming::type_name;
use proptest::prelude::*;

#[test]
fn the_length_of_a_sample_tells_definitions_of_one_topic_apart() {
    for (i, one) in DEFINITIONS.iter().enumerate() {
        for other in DEFINITIONS.iter().skip(i + 1) {
            if (one.topic, one.version) == (other.topic, other.version) {
                let (a, b) = (one.size_bytes(), other.size_bytes());
                assert_ne!(
                    a.div_ceil(4),
                    b.div_ceil(4),
                    "{:?} {:?} and {:?}",
                    one.topic,
                    one.releases,
                    other.releases
                );
            }
        }
    }
}

#[test]
fn each_release_has_each_topic_once() {
    for release in Release::ALL {
        for topic in Topic::ALL {
            let found = DEFINITIONS
                .iter()
                .filter(|d| d.topic == topic && d.releases.contains(&release));
            assert_eq!(found.count(), 1, "{topic:?} of {release}");
        }
    }
}

/// Octets as PX4's own tools give them: the sum of the sizes with alignment, worked out by hand.
#[test]
fn sizes_are_those_of_the_wire() {
    let size = |topic, version, release| {
        let found = of(topic, version).find(|d| d.releases.contains(&release));
        found.map(Definition::size_bytes).unwrap()
    };
    assert_eq!(size(Topic::Attitude, 0, Release::V1_16), 8 + 8 + 16 + 16 + 1);
    assert_eq!(size(Topic::LandDetected, 0, Release::V1_16), 8 + 12);
    assert_eq!(size(Topic::Timesync, 0, Release::V1_16), 8 + (1 + 7) + 8 + 8 + 8 + 4);
    assert_eq!(
        size(Topic::CommandAck, 0, Release::V1_16),
        8 + 4 + 1 + 1 + 2 + 4 + (1 + 1) + 2 + 1
    );
    assert_eq!(size_bytes(Command::TrajectorySetpoint.fields()), 8 + 4 * 12 + 8);
    assert_eq!(size_bytes(Command::OffboardControlMode.fields()), 8 + 7);
    assert_eq!(
        size_bytes(Command::VehicleCommand.fields()),
        8 + 16 + 16 + 4 + 4 + (1 + 1 + 1 + 1) + 2 + 1 + 1
    );
}

#[test]
fn names_lead_to_topics_and_back() {
    for topic in Topic::ALL {
        assert_eq!(Topic::of(topic.base()), Some(topic));
        assert!(!topic.message().is_empty());
    }
    for command in Command::ALL {
        assert_eq!(Command::of(command.base()), Some(command));
    }
    assert_eq!(type_name(Topic::Gnss.message()), "px4_msgs::msg::dds_::SensorGps_");
}

#[test]
fn a_truncated_or_longer_sample_is_named_as_such() {
    let ack = v1_15::VehicleCommandAck {
        timestamp: 5,
        command: 400,
        result: 1,
        result_param1: 2,
        result_param2: -3,
        target_system: 245,
        target_component: 190,
        from_external: false,
    };
    let whole = encode(&ack).unwrap();
    let definition = of(Topic::CommandAck, 0).next().unwrap();
    for length in (0..whole.len()).chain([whole.len() + 4, 4 * whole.len()]) {
        let mut bytes = whole.clone();
        bytes.resize(length, 0);
        let error = definition.read(Encoding::LittleEndian, &bytes).unwrap_err();
        let size = CdrError::Size {
            got: length,
            expected: whole.len(),
        };
        assert_eq!(error, SampleError::Cdr(size), "{length}");
    }
    let mut padded = whole.clone();
    padded.resize(whole.len().div_ceil(4) * 4, 0xEE);
    let read = definition.read(Encoding::LittleEndian, &padded).unwrap();
    let Sample::Ack(read) = read else { panic!("{read:?}") };
    assert_eq!(
        (read.command, read.result, read.target_system, read.target_component),
        (400, 1, 245, 190)
    );
    let other = definition.read(Encoding::Other(7), &whole).unwrap_err();
    assert_eq!(other, SampleError::Cdr(CdrError::Encoding(7)));
}

fn any_encoding() -> impl Strategy<Value = Encoding> {
    any::<u16>().prop_map(|number| Encoding::of(number % 4))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_survived(which in 0..DEFINITIONS.len(), encoding in any_encoding(), bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = DEFINITIONS[which].read(encoding, &bytes);
    }

    /// Of the right length, with numbers that are no numbers, or huge: what comes through is finite where it is said to be valid.
    #[test]
    fn what_comes_through_is_sane(
        which in 0..DEFINITIONS.len(),
        seed in prop::collection::vec(prop_oneof![
            Just(f32::NAN.to_le_bytes()), Just(f32::INFINITY.to_le_bytes()), Just(f32::MAX.to_le_bytes()), Just([0; 4]), Just([1; 4]),
            Just([1, 0, 1, 0]), any::<[u8; 4]>(), (-100.0_f32..100.0).prop_map(f32::to_le_bytes),
        ], 200),
    ) {
        let definition = &DEFINITIONS[which];
        let mut bytes = seed.concat();
        bytes.truncate(definition.size_bytes());
        match definition.read(Encoding::LittleEndian, &bytes) {
            Ok(Sample::Local(local)) => {
                prop_assert!(!local.valid.horizontal || local.position_m[0].abs() <= 1e6);
                prop_assert!(!local.valid.velocity_vertical || local.velocity_m_s[2].abs() <= 1e3);
                prop_assert!(local.origin().is_none_or(|origin| origin.is_valid()));
            }
            Ok(Sample::Global(place) | Sample::Home(place)) => prop_assert!(!place.valid || place.place.is_valid()),
            Ok(Sample::Attitude(attitude)) => prop_assert!(attitude.quaternion.iter().all(|part| part.is_finite())),
            Ok(Sample::Gnss(gnss)) => prop_assert!(!gnss.has_fix() || gnss.place.is_valid()),
            Ok(_) | Err(_) => {}
        }
    }
}
