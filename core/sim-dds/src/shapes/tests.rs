//! Every release's message says what the simulation does, read by the code that reads PX4's.

use super::*;
use crate::octets::sample;
use nalgebra::{UnitQuaternion, Vector3};
use skein_domain::Geodetic;
use skein_link_dds::cdr::{Encoding, decode};
use skein_link_dds::definitions::{DEFINITIONS, Definition};
use skein_link_dds::messages::v1_18;
use skein_link_dds::sample::Sample;
use skein_sim::topics::{AttitudeReport, LandedReport};

const STAMP_US: u64 = 12_345_678;
const PLACE: Geodetic = Geodetic {
    latitude_deg: 47.397_742,
    longitude_deg: 8.545_594,
    altitude_amsl_m: 490.0,
};

fn all() -> Vec<Published> {
    let mut all = condition();
    all.extend(motion());
    all
}

fn condition() -> Vec<Published> {
    let stamp_us = STAMP_US;
    vec![
        Published::Status(StatusReport {
            stamp_us,
            system_id: 7,
            armed: true,
            armed_us: 9_000_000,
            mode: FlightMode::Offboard,
            intention: FlightMode::Offboard,
            failsafe: false,
            checks_pass: true,
        }),
        Published::Landed(LandedReport { stamp_us, landed: true }),
        Published::Battery(BatteryReport {
            stamp_us,
            voltage_v: 15.5,
            current_a: 4.0,
            consumed_mah: 250.0,
            charge: 0.75,
            remaining_s: 600.0,
            warning: 0,
        }),
        Published::Timesync(TimesyncReport {
            stamp_us,
            offset_us: -1_699_999_987_654_322,
        }),
        Published::CommandAnswer(CommandAnswer {
            stamp_us,
            command: 400,
            result: 0,
            to_system: 245,
            to_component: 300,
        }),
    ]
}

fn motion() -> Vec<Published> {
    let stamp_us = STAMP_US;
    vec![
        Published::Local(LocalReport {
            stamp_us,
            horizontal_valid: true,
            vertical_valid: true,
            position_m: Vector3::new(1.0, -2.0, -3.0),
            velocity_m_s: Vector3::new(0.5, 0.25, -0.125),
            acceleration_m_s2: Vector3::zeros(),
            yaw_rad: 1.0,
            origin: Some(PLACE),
            origin_us: 1_100_000,
            height_m: 3.0,
            accuracy_horizontal_m: 0.25,
            accuracy_vertical_m: 0.5,
            dead_reckoning: false,
        }),
        Published::Attitude(AttitudeReport {
            stamp_us,
            turned: UnitQuaternion::from_euler_angles(0.1, -0.2, 0.3),
        }),
        Published::Global(GlobalReport {
            stamp_us,
            horizontal_valid: true,
            place: PLACE,
            accuracy_horizontal_m: 0.25,
            accuracy_vertical_m: 0.5,
            dead_reckoning: false,
        }),
        Published::Gnss(GnssReport {
            stamp_us,
            fixed: true,
            satellites: 16,
            place: PLACE,
            velocity_m_s: Vector3::new(1.0, 0.0, 0.0),
            accuracy_horizontal_m: 0.5,
            accuracy_vertical_m: 0.5,
            utc_us: 1_700_000_000_000_000,
        }),
        Published::Home(HomeReport {
            stamp_us,
            place: PLACE,
            position_m: Vector3::zeros(),
            count: 1,
        }),
    ]
}

fn of(topic: Topic, release: Release) -> &'static Definition {
    let mut all = DEFINITIONS.iter();
    all.find(|d| d.topic == topic && d.releases.contains(&release))
        .expect("each release has each topic")
}

fn says(read: &Sample) -> bool {
    let degrees = |place: Geodetic| (place.latitude_deg, place.longitude_deg, place.altitude_amsl_m);
    let there = |place: Geodetic| degrees(place) == degrees(PLACE);
    match read {
        Sample::Status(s) => (s.system_id, s.nav_state, s.failsafe) == (7, 14, false) && s.armed() && s.ready_to_arm,
        Sample::Local(s) => {
            s.position_m == [1.0, -2.0, -3.0]
                && s.velocity_m_s == [0.5, 0.25, -0.125]
                && s.origin().is_some_and(there)
                && s.valid.horizontal
                && s.valid.velocity_vertical
                && s.accuracy_m == [0.25, 0.5]
                && !s.dead_reckoning
        }
        Sample::Global(s) => s.valid && there(s.place),
        Sample::Attitude(s) => {
            let [w, x, y, z] = s.quaternion.map(f64::from);
            let q = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
            q.angle_to(&UnitQuaternion::from_euler_angles(0.1, -0.2, 0.3)) < 1e-5
        }
        Sample::Landed(s) => s.landed,
        Sample::Battery(s) => {
            s.id == 1
                && s.connected
                && (s.voltage_v, s.current_a, s.remaining) == (15.5, 4.0, 0.75)
                && (s.discharged_mah, s.time_remaining_s) == (250.0, 600.0)
        }
        Sample::Gnss(s) => s.has_fix() && s.satellites == 16 && s.horizontal_accuracy_m == 0.5 && there(s.place),
        Sample::Home(s) => s.valid && there(s.place),
        Sample::Timesync(s) => s.source == 2 && s.offset_us == -1_699_999_987_654_322,
        Sample::Ack(s) => (s.command, s.result, s.target_system, s.target_component) == (400, 0, 245, 300),
    }
}

#[test]
fn every_release_says_what_is_published() {
    for release in Release::ALL {
        for published in all() {
            let (topic, record) = outgoing(&published, release).expect("is published");
            let definition = of(topic, release);
            let octets = sample(definition.fields, &record).0;
            assert_eq!(octets.len(), definition.size_bytes(), "{topic:?} of {release}");
            let read = definition.read(Encoding::LittleEndian, &octets).expect("can be true");
            assert!(says(&read), "{topic:?} of {release}: {read:?}");
            assert!(read.stamp_us().is_none_or(|stamp_us| stamp_us == STAMP_US));
        }
    }
}

#[test]
fn every_name_that_is_written_is_one_of_a_message() {
    for published in all() {
        for release in Release::ALL {
            let (topic, record) = outgoing(&published, release).expect("is published");
            for name in record.names() {
                let known = DEFINITIONS.iter().filter(|d| d.topic == topic);
                let found = known.flat_map(|d| d.fields).any(|field| field.name == name);
                assert!(found, "{topic:?} has no {name}");
            }
        }
    }
}

#[test]
fn a_place_that_is_not_valid_is_not_told_or_said_to_be_none() {
    let lost = Published::Global(GlobalReport {
        stamp_us: STAMP_US,
        horizontal_valid: false,
        place: PLACE,
        accuracy_horizontal_m: 50.0,
        accuracy_vertical_m: 0.5,
        dead_reckoning: true,
    });
    assert_eq!(outgoing(&lost, Release::V1_15), None);
    let (topic, record) = outgoing(&lost, Release::Later).expect("is published");
    let definition = of(topic, Release::Later);
    let octets = sample(definition.fields, &record).0;
    let read = definition.read(Encoding::LittleEndian, &octets).expect("can be true");
    assert!(matches!(read, Sample::Global(place) if !place.valid), "{read:?}");
}

#[test]
fn each_mode_has_the_number_that_the_link_reads() {
    use FlightMode as M;
    let modes = [
        M::Manual,
        M::Altitude,
        M::Position,
        M::Mission,
        M::Hold,
        M::Return,
        M::Acro,
        M::Descend,
        M::Termination,
        M::Offboard,
        M::Stabilized,
        M::TakeOff,
        M::Land,
    ];
    for mode in modes {
        assert_eq!(skein_link_dds::session::estimate::flight_mode(nav_state(mode)), mode);
    }
}

#[test]
fn the_other_fields_of_a_status_are_a_quadrotors() {
    let (_, record) = outgoing(&all()[0], Release::V1_18).expect("is published");
    let octets = sample(of(Topic::Status, Release::V1_18).fields, &record).0;
    let read: v1_18::VehicleStatus = decode(Encoding::LittleEndian, &octets).expect("is one");
    assert_eq!((read.vehicle_type, read.system_type, read.component_id), (1, 2, 1));
    assert_eq!((read.armed_time, read.accepts_offboard_setpoints), (9_000_000, true));
}
