//! Tests of the binary telemetry frame.

use super::*;
use crate::generated::golden::{extreme, flying_vehicle, unknown_vehicle};
use proptest::prelude::*;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, VehicleId, VelocityNed};

/// Reads a little-endian number by the published table, as the browser does.
fn read(bytes: &[u8], fields: &[Field], name: &str) -> i64 {
    let field = fields
        .iter()
        .find(|field| field.name == name)
        .unwrap_or_else(|| panic!("no field {name}"));
    let at = |n: usize| &bytes[field.offset..field.offset + n];
    match field.kind {
        "u8" => i64::from(at(1)[0]),
        "u16" => i64::from(u16::from_le_bytes(at(2).try_into().unwrap())),
        "i16" => i64::from(i16::from_le_bytes(at(2).try_into().unwrap())),
        "u32" => i64::from(u32::from_le_bytes(at(4).try_into().unwrap())),
        "i32" => i64::from(i32::from_le_bytes(at(4).try_into().unwrap())),
        other => panic!("unknown kind {other}"),
    }
}

fn record_value(bytes: &[u8], index: usize, name: &str) -> i64 {
    read(
        &bytes[HEADER_BYTES + index * RECORD_BYTES..][..RECORD_BYTES],
        Record::FIELDS,
        name,
    )
}

#[test]
fn offsets_are_those_of_the_published_layout() {
    let published = [
        ("id", 0),
        ("mode", 2),
        ("flags", 3),
        ("latitude_e7", 4),
        ("longitude_e7", 8),
        ("altitude_amsl_mm", 12),
        ("velocity_north_cm_s", 16),
        ("velocity_east_cm_s", 18),
        ("velocity_down_cm_s", 20),
        ("roll_cdeg", 22),
        ("pitch_cdeg", 24),
        ("yaw_cdeg", 26),
        ("battery_percent", 28),
        ("loss_percent", 29),
        ("satellites", 30),
        ("fix", 31),
        ("battery_10_mv", 32),
        ("age_ms", 34),
        ("measured_ms", 36),
        ("slot_latitude_e7", 40),
        ("slot_longitude_e7", 44),
        ("slot_altitude_amsl_mm", 48),
        ("flight_state", 52),
        ("landed", 53),
        ("tracking_error_cm", 54),
        ("round_trip_100_us", 56),
        ("setpoint_rate_dhz", 58),
        ("actor_incarnation", 60),
        ("model_incarnation", 62),
    ];
    let table: Vec<_> = Record::FIELDS.iter().map(|field| (field.name, field.offset)).collect();
    assert_eq!(table, published);
    let header: Vec<_> = Header::FIELDS
        .iter()
        .map(|field| (field.name, field.offset, field.kind))
        .collect();
    assert_eq!(
        header,
        [
            ("magic", 0, "u32"),
            ("sequence", 4, "u32"),
            ("count", 8, "u32"),
            ("server_time_ms", 12, "u32")
        ]
    );
    assert_eq!(&FRAME_MAGIC.to_le_bytes(), b"SKN1");
}

#[test]
fn age_grows_while_no_newer_snapshot_comes() {
    let snapshot = FleetSnapshot {
        time: NodeTime::from_seconds(10.0),
        vehicles: vec![VehicleSnapshot {
            age_s: 0.25,
            ..flying_vehicle(1)
        }],
        ..FleetSnapshot::default()
    };
    let age = |now_s| record_value(&encode(&snapshot, NodeTime::from_seconds(now_s)), 0, "age_ms");
    assert_eq!(age(10.0), 250);
    assert_eq!(age(12.0), 2250);
    assert_eq!(age(1000.0), 65535);
    assert_eq!(
        age(9.0),
        250,
        "a clock read before the snapshot was made makes nothing younger"
    );
}

#[test]
fn what_is_not_known_is_marked_so() {
    let snapshot = FleetSnapshot {
        vehicles: vec![unknown_vehicle(7)],
        ..FleetSnapshot::default()
    };
    let bytes = encode(&snapshot, NodeTime(0));
    assert_eq!(record_value(&bytes, 0, "flags"), 0);
    assert_eq!(record_value(&bytes, 0, "battery_percent"), i64::from(UNKNOWN_PERCENT));
    assert_eq!(record_value(&bytes, 0, "battery_10_mv"), i64::from(UNKNOWN_VOLTAGE));
    assert_eq!(record_value(&bytes, 0, "tracking_error_cm"), i64::from(UNKNOWN_U16));
    assert_eq!(record_value(&bytes, 0, "round_trip_100_us"), i64::from(UNKNOWN_U16));
}

#[test]
fn numbers_beyond_their_range_stop_at_its_end_and_are_not_taken_for_unknown() {
    let bytes = encode(&extreme(), NodeTime(u64::MAX));
    assert_eq!(record_value(&bytes, 0, "velocity_north_cm_s"), i64::from(i16::MAX));
    assert_eq!(record_value(&bytes, 0, "velocity_east_cm_s"), i64::from(i16::MIN));
    assert_eq!(record_value(&bytes, 0, "velocity_down_cm_s"), 0, "not a number");
    assert_eq!(record_value(&bytes, 0, "altitude_amsl_mm"), i64::from(i32::MIN));
    assert_eq!(record_value(&bytes, 0, "yaw_cdeg"), 0, "a full turn");
    assert_eq!(record_value(&bytes, 0, "battery_percent"), 100);
    assert_eq!(record_value(&bytes, 0, "tracking_error_cm"), 65534);
    assert_eq!(record_value(&bytes, 0, "round_trip_100_us"), 65534);
    assert_eq!(record_value(&bytes, 0, "age_ms"), 65535);
    assert_eq!(record_value(&bytes, 0, "actor_incarnation"), 65535);
    let flags = record_value(&bytes, 0, "flags") as u8;
    assert_eq!(
        flags,
        flag::POSITION | flag::FAULTED,
        "a slot without a swarm frame has no place on Earth"
    );
}

#[test]
fn a_place_comes_from_the_swarm_frame_when_the_vehicle_gives_none() {
    let origin = Geodetic {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_amsl_m: 400.0,
    };
    let vehicle = VehicleSnapshot {
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(0.0, 0.0, -12.5),
            ..Default::default()
        }),
        ..unknown_vehicle(1)
    };
    let without_frame = record(&vehicle, None, 0.0);
    assert_eq!(without_frame.flags & flag::POSITION, 0);
    let with_frame = record(&vehicle, Some(&SwarmFrame::new(origin)), 0.0);
    assert_eq!(with_frame.flags & flag::POSITION, flag::POSITION);
    assert_eq!(
        (
            with_frame.latitude_e7,
            with_frame.longitude_e7,
            with_frame.altitude_amsl_mm
        ),
        (470_000_000, 80_000_000, 412_500)
    );
}

proptest! {
    #[test]
    fn what_the_browser_reads_is_what_was_measured_within_the_resolution(
        id in any::<u16>(),
        latitude_deg in -90.0..=90.0f64,
        longitude_deg in -180.0..=180.0f64,
        altitude_amsl_m in -500.0..9000.0f64,
        velocity in prop::array::uniform3(-300.0..300.0f64),
        yaw_rad in -10.0..10.0f64,
        roll_rad in -3.1..3.1f32,
        remaining in 0.0..=1.0f32,
        tracking_error_m in 0.0..655.0f64,
        sequence in any::<u64>(),
    ) {
        let place = Geodetic { latitude_deg, longitude_deg, altitude_amsl_m };
        let base = flying_vehicle(id);
        let vehicle = VehicleSnapshot {
            id: VehicleId(id),
            global: Some(place),
            kinematics: Some(VehicleKinematics {
                velocity: VelocityNed::new(velocity[0], velocity[1], velocity[2]),
                yaw_rad,
                ..base.kinematics.unwrap()
            }),
            roll_rad,
            battery: skein_domain::Battery { remaining: Some(remaining), ..base.battery },
            tracking_error_m: Some(tracking_error_m),
            ..base
        };
        let snapshot = FleetSnapshot { sequence, vehicles: vec![unknown_vehicle(0), vehicle], ..FleetSnapshot::default() };
        let bytes = encode(&snapshot, NodeTime(5_000_000));
        prop_assert_eq!(bytes.len(), HEADER_BYTES + 2 * RECORD_BYTES);
        prop_assert_eq!(read(&bytes, Header::FIELDS, "magic"), i64::from(FRAME_MAGIC));
        prop_assert_eq!(read(&bytes, Header::FIELDS, "sequence"), (sequence & 0xffff_ffff) as i64);
        prop_assert_eq!(read(&bytes, Header::FIELDS, "count"), 2);
        let value = |name| record_value(&bytes, 1, name) as f64;
        prop_assert_eq!(value("id"), f64::from(id));
        prop_assert!((value("latitude_e7") * 1e-7 - latitude_deg).abs() <= 0.6e-7);
        prop_assert!((value("longitude_e7") * 1e-7 - longitude_deg).abs() <= 0.6e-7);
        prop_assert!((value("altitude_amsl_mm") * 1e-3 - altitude_amsl_m).abs() <= 0.6e-3);
        for (name, measured) in [("velocity_north_cm_s", velocity[0]), ("velocity_east_cm_s", velocity[1]), ("velocity_down_cm_s", velocity[2])] {
            prop_assert!((value(name) * 0.01 - measured).abs() <= 0.0051);
        }
        let yaw_error = skein_domain::frames::wrap_angle_rad((value("yaw_cdeg") * 0.01).to_radians() - yaw_rad);
        prop_assert!(yaw_error.abs() <= 0.0051f64.to_radians());
        prop_assert!((value("yaw_cdeg")) < 36_000.0);
        prop_assert!((value("roll_cdeg") * 0.01 - f64::from(roll_rad).to_degrees()).abs() <= 0.0051);
        prop_assert!((value("battery_percent") - f64::from(remaining) * 100.0).abs() <= 0.51);
        prop_assert!((value("tracking_error_cm") * 0.01 - tracking_error_m).abs() <= 0.0051);
    }
}
