//! What others say of their place, from real frames.

use super::*;
use crate::EndpointCounters;
use crate::frame::each_in_datagram;
use mavlink::dialects::common::{AdsbFlags, MavMessage};
use mavlink::{MAVLinkV2MessageRaw, MavHeader};

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn sighted<M: MessageData<Message = MavMessage>>(system_id: u32, message: &M) -> Option<Sighting> {
    let mut raw = MAVLinkV2MessageRaw::new();
    let header = MavHeader {
        system_id,
        component_id: 190,
        sequence: 3,
    };
    raw.serialize_message_data(header, message);
    let mut seen = None;
    each_in_datagram(raw.raw_bytes(), &mut EndpointCounters::default(), |_, frame| {
        seen = read(at(100.0), frame);
    });
    seen
}

fn aircraft() -> ADSB_VEHICLE_DATA {
    ADSB_VEHICLE_DATA {
        ICAO_address: 0x004C_A123,
        lat: 473_900_000,
        lon: 85_400_000,
        altitude: 820_000,
        heading: 9_000,
        hor_velocity: 5_000,
        ver_velocity: -200,
        flags: AdsbFlags::from_bits_retain(1 | 2 | 4 | 8 | 128),
        tslc: 2,
        ..ADSB_VEHICLE_DATA::default()
    }
}

#[test]
fn an_aircraft_is_where_its_transponder_said() {
    let seen = sighted(1, &aircraft()).unwrap();
    assert_eq!(seen.source, "adsb:4CA123");
    assert_eq!(seen.time, at(98.0), "the receiver heard it two seconds ago");
    assert!((seen.place.latitude_deg - 47.39).abs() < 1e-9 && (seen.place.altitude_amsl_m - 820.0).abs() < 1e-9);
    let velocity = seen.velocity.unwrap();
    assert!(velocity.north_m_s.abs() < 1e-6 && (velocity.east_m_s - 50.0).abs() < 1e-6);
    assert!((velocity.down_m_s - 2.0).abs() < 1e-9);
    assert!((seen.heading_rad.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
}

#[test]
fn an_aircraft_without_place_or_height_is_nowhere_and_a_new_flag_hides_none() {
    for flags in [0, 1, 2, 4 | 8] {
        let unknown = ADSB_VEHICLE_DATA {
            flags: AdsbFlags::from_bits_retain(flags),
            ..aircraft()
        };
        assert_eq!(sighted(1, &unknown), None, "{flags}");
    }
    let newer = ADSB_VEHICLE_DATA {
        flags: AdsbFlags::from_bits_retain(1 | 2 | 0x4000),
        ..aircraft()
    };
    let seen = sighted(1, &newer).unwrap();
    assert_eq!((seen.velocity, seen.heading_rad), (None, None));
}

#[test]
fn a_mover_reports_itself() {
    let turn = std::f64::consts::FRAC_PI_4;
    let report = FOLLOW_TARGET_DATA {
        lat: 473_900_000,
        lon: 85_400_000,
        alt: 491.5,
        vel: [1.0, -2.0, 0.5],
        attitude_q: [(turn / 2.0).cos() as f32, 0.0, 0.0, (turn / 2.0).sin() as f32],
        est_capabilities: 0b1011,
        ..FOLLOW_TARGET_DATA::default()
    };
    let seen = sighted(42, &report).unwrap();
    assert_eq!(seen.source, "mavlink:42");
    assert_eq!(seen.velocity, Some(VelocityNed::new(1.0, -2.0, 0.5)));
    assert!((seen.heading_rad.unwrap() - turn).abs() < 1e-6);
    let less = FOLLOW_TARGET_DATA {
        est_capabilities: 1,
        ..report.clone()
    };
    let seen = sighted(42, &less).unwrap();
    assert_eq!((seen.velocity, seen.heading_rad), (None, None));
    let nowhere = FOLLOW_TARGET_DATA {
        lat: 0,
        lon: 0,
        ..report
    };
    assert_eq!(sighted(42, &nowhere), None);
}

#[test]
fn the_latest_of_each_wins_and_there_are_never_too_many() {
    let sightings = Sightings::new();
    let of = |source: String, seconds: f64| Sighting {
        source,
        place: Geodetic::default(),
        velocity: None,
        heading_rad: None,
        time: at(seconds),
    };
    sightings.sighted(of("a".to_owned(), 5.0));
    sightings.sighted(of("a".to_owned(), 4.0));
    assert_eq!(sightings.of("a").unwrap().time, at(5.0), "older news change nothing");
    for i in 0..SIGHTINGS_MAX {
        sightings.sighted(of(format!("x{i}"), 10.0 + i as f64));
    }
    assert_eq!(sightings.since(at(0.0)).len(), SIGHTINGS_MAX);
    assert_eq!(sightings.of("a"), None, "unheard for longest");
    assert_eq!(sightings.since(at(10.0 + (SIGHTINGS_MAX - 3) as f64)).len(), 3);
    sightings.forget("x7");
    assert_eq!(sightings.of("x7"), None);
    assert_eq!(sightings.since(at(0.0)).len(), SIGHTINGS_MAX - 1, "and nobody else");
}
