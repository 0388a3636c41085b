//! Each release is let in; what does not fit is named.

use super::*;
use crate::naming::Namespace;
use crate::specimen;
use proptest::prelude::*;

const LE: Encoding = Encoding::LittleEndian;

fn reader(command: Command, version: u32) -> TopicName {
    TopicName {
        namespace: Namespace::default(),
        direction: Direction::In,
        base: command.base().to_owned(),
        version,
    }
}

/// A vehicle of a release as discovery finds it.
fn found(release: Release) -> Admission {
    let mut admission = Admission::default();
    for topic in Topic::ALL {
        let name = specimen::name(topic, release);
        assert_eq!(admission.on_endpoint(&name, &type_name(topic.message()), b""), Ok(true));
    }
    for command in Command::ALL {
        assert_eq!(
            admission.on_endpoint(&reader(command, 0), &type_name(command.message()), b""),
            Ok(true)
        );
    }
    assert_eq!(
        admission.on_endpoint(
            &specimen::name(Topic::Status, release),
            &type_name("VehicleStatus"),
            b""
        ),
        Ok(true)
    );
    admission
}

fn hear(admission: &mut Admission, topic: Topic, release: Release, times: u64) {
    for i in 0..times {
        let bytes = specimen::sample(topic, release, 1_000_000 + i);
        assert!(
            admission
                .on_sample(&specimen::name(topic, release), LE, &bytes)
                .is_some(),
            "{topic:?} of {release}"
        );
    }
}

#[test]
fn vehicles_of_all_releases_are_admitted_and_known_for_what_they_are() {
    for release in Release::ALL {
        let mut admission = found(release);
        assert_eq!(admission.verdict(), Verdict::Open);
        assert_eq!(admission.waits_for(), ["vehicle_status", "vehicle_local_position"]);
        for topic in Topic::ALL {
            hear(&mut admission, topic, release, 3);
        }
        let Verdict::Admitted { system_id, releases } = admission.verdict() else {
            panic!("{release}: {:?}", admission.verdict())
        };
        assert_eq!((system_id, releases), (7, vec![release]));
    }
}

#[test]
fn a_vehicle_that_does_not_listen_is_waited_for() {
    let mut admission = Admission::default();
    // Answers and landing are not waited for: the first has no topic before the first command, the second none in 1.15.
    for topic in [Topic::Status, Topic::LocalPosition] {
        let name = specimen::name(topic, Release::V1_15);
        assert_eq!(admission.on_endpoint(&name, &type_name(topic.message()), b""), Ok(true));
        hear(&mut admission, topic, Release::V1_15, 3);
    }
    assert_eq!(admission.verdict(), Verdict::Open);
    assert_eq!(
        admission.waits_for(),
        ["vehicle_command", "offboard_control_mode", "trajectory_setpoint"]
    );
}

#[test]
fn another_type_is_named() {
    let mut admission = found(Release::V1_16);
    let name = specimen::name(Topic::Battery, Release::V1_16);
    let other = admission.on_endpoint(&name, "sensor_msgs::msg::dds_::BatteryState_", b"");
    assert!(matches!(other, Err(Mismatch::TypeName { .. })));
    let Verdict::Refused(mismatch) = admission.verdict() else {
        panic!()
    };
    assert_eq!(
        mismatch.to_string(),
        "/fmu/out/battery_status carries sensor_msgs::msg::dds_::BatteryState_ where px4_msgs::msg::dds_::BatteryStatus_ is expected"
    );
}

#[test]
fn an_unknown_version_is_named_unless_a_known_one_is_there_too() {
    let mut admission = Admission::default();
    let mut newer = specimen::name(Topic::Status, Release::V1_18);
    newer.version = 9;
    let judged = admission.on_endpoint(&newer, &type_name("VehicleStatus"), b"");
    assert!(matches!(judged, Err(Mismatch::Version { version: 9, .. })));
    let Verdict::Refused(mismatch) = admission.verdict() else {
        panic!()
    };
    assert_eq!(
        mismatch.to_string(),
        "/fmu/out/vehicle_status_v9 has version 9 of VehicleStatus; known are 0 (PX4 1.15), 1 (PX4 1.16, 1.17), 4 (PX4 1.18, after 1.18)"
    );
    let known = specimen::name(Topic::Status, Release::V1_18);
    assert_eq!(
        admission.on_endpoint(&known, &type_name("VehicleStatus"), b""),
        Ok(true)
    );
    assert_eq!(admission.verdict(), Verdict::Open);
    let older = specimen::name(Topic::Status, Release::V1_16);
    assert_eq!(
        admission.on_endpoint(&older, &type_name("VehicleStatus"), b""),
        Ok(false),
        "one is enough"
    );
    let setpoint = reader(Command::TrajectorySetpoint, 2);
    assert!(
        admission
            .on_endpoint(&setpoint, &type_name("TrajectorySetpoint"), b"")
            .is_err()
    );
    assert!(matches!(
        admission.verdict(),
        Verdict::Refused(Mismatch::Version { version: 2, .. })
    ));
}

#[test]
fn a_hash_decides_before_any_sample_and_another_hash_is_refused() {
    let name = specimen::name(Topic::Battery, Release::V1_16);
    let hash = specimen::definition(Topic::Battery, Release::V1_16).type_hash();
    let mut admission = found(Release::V1_16);
    let judged = admission.on_endpoint(
        &name,
        &type_name("BatteryStatus"),
        format!("typehash={hash};").as_bytes(),
    );
    assert_eq!(judged, Ok(true));
    assert_eq!(admission.releases(), [Release::V1_16]);
    let other = type_hash::of_px4("BatteryStatus", &[]);
    let judged = admission.on_endpoint(
        &name,
        &type_name("BatteryStatus"),
        format!("typehash={other};").as_bytes(),
    );
    assert!(matches!(judged, Err(Mismatch::TypeHash { .. })));
    assert!(matches!(
        admission.verdict(),
        Verdict::Refused(Mismatch::TypeHash { .. })
    ));
}

#[test]
fn samples_of_another_length_are_refused_at_once() {
    let mut admission = found(Release::V1_16);
    let name = specimen::name(Topic::LocalPosition, Release::V1_16);
    let mut bytes = specimen::sample(Topic::LocalPosition, Release::V1_16, 5);
    bytes.truncate(bytes.len() - 12);
    assert_eq!(admission.on_sample(&name, LE, &bytes), None);
    let Verdict::Refused(mismatch) = admission.verdict() else {
        panic!()
    };
    let text = mismatch.to_string();
    assert!(
        text.starts_with("/fmu/out/vehicle_local_position has samples of"),
        "{text}"
    );
    assert!(text.contains("(PX4 1.15)") && text.contains("(PX4 1.16)"), "{text}");
}

#[test]
fn samples_that_cannot_be_true_are_refused_when_they_go_on() {
    let release = Release::V1_17;
    let mut admission = found(release);
    let name = specimen::name(Topic::Status, release);
    let fields = specimen::definition(Topic::Status, release).fields;
    let bad = specimen::bytes(
        fields,
        &[("timestamp", &[5.0]), ("system_id", &[7.0]), ("arming_state", &[77.0])],
    );
    for _ in 0..2 {
        assert_eq!(admission.on_sample(&name, LE, &bad), None);
        assert_eq!(admission.verdict(), Verdict::Open, "one may be a glitch");
    }
    assert_eq!(admission.on_sample(&name, LE, &bad), None);
    let Verdict::Refused(mismatch) = admission.verdict() else {
        panic!()
    };
    assert!(mismatch.to_string().contains("arming_state is 77"), "{mismatch}");
}

#[test]
fn one_that_flies_is_not_refused_any_more() {
    let release = Release::V1_18;
    let mut admission = found(release);
    for topic in [Topic::Status, Topic::LocalPosition] {
        hear(&mut admission, topic, release, 3);
    }
    assert!(matches!(admission.verdict(), Verdict::Admitted { .. }));
    for topic in Topic::ALL {
        for _ in 0..10 {
            assert_eq!(
                admission.on_sample(&specimen::name(topic, release), LE, &[1, 2, 3]),
                None
            );
        }
    }
    let status = specimen::name(Topic::Status, release);
    assert!(admission.on_endpoint(&status, "another::Type", b"").is_err());
    assert!(matches!(admission.verdict(), Verdict::Admitted { .. }));
}

#[test]
fn another_encoding_is_named() {
    let mut admission = found(Release::V1_15);
    let name = specimen::name(Topic::Status, Release::V1_15);
    let bytes = specimen::sample(Topic::Status, Release::V1_15, 5);
    assert_eq!(admission.on_sample(&name, Encoding::Other(9), &bytes), None);
    assert!(matches!(
        admission.verdict(),
        Verdict::Refused(Mismatch::Encoding { encoding: 9, .. })
    ));
}

proptest! {
    #[test]
    fn any_bytes_on_any_topic_are_survived(
        steps in prop::collection::vec((0..Topic::ALL.len(), 0_u32..6, prop::collection::vec(any::<u8>(), 0..260)), 0..40)
    ) {
        let mut admission = found(Release::V1_16);
        for (topic, version, bytes) in steps {
            let mut name = specimen::name(Topic::ALL[topic], Release::V1_16);
            name.version = version;
            admission.on_sample(&name, LE, &bytes);
            let admitted = matches!(admission.verdict(), Verdict::Admitted { .. });
            prop_assert!(!admitted, "noise was taken for a vehicle");
        }
    }
}
