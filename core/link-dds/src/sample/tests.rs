//! Numbers that no vehicle can have.

use super::*;

fn local() -> LocalPosition {
    LocalPosition {
        stamp_us: 5_000_000,
        measured_us: 4_990_000,
        valid: Validity {
            horizontal: true,
            vertical: true,
            velocity_horizontal: true,
            velocity_vertical: true,
        },
        position_m: [1.0, 2.0, -3.0],
        velocity_m_s: [0.1, 0.2, 0.3],
        origin_deg: Some([47.4, 8.5]),
        origin_altitude_m: Some(488.0),
        accuracy_m: [0.5, 0.7],
        dead_reckoning: false,
    }
}

fn field(sample: Sample) -> Option<&'static str> {
    sample.check().err().map(|implausible| implausible.field)
}

#[test]
fn a_position_is_checked_where_it_is_said_to_be_valid() {
    assert_eq!(field(Sample::Local(local())), None);
    for bad in [f32::NAN, f32::INFINITY, -3e38, 1.1e6] {
        let mut sample = local();
        sample.position_m[1] = bad;
        assert_eq!(field(Sample::Local(sample)), Some("y"), "{bad}");
        sample.valid.horizontal = false;
        assert_eq!(field(Sample::Local(sample)), None, "{bad}");
        let mut sample = local();
        sample.velocity_m_s[2] = bad;
        assert_eq!(field(Sample::Local(sample)), Some("vz"), "{bad}");
    }
    let mut sample = local();
    sample.origin_deg = Some([1e308, 8.5]);
    assert_eq!(field(Sample::Local(sample)), Some("ref_lat"));
    let mut sample = local();
    sample.measured_us = u64::MAX;
    assert_eq!(field(Sample::Local(sample)), Some("timestamp"));
}

#[test]
fn places_modes_and_attitudes_are_checked() {
    let place = |latitude_deg| {
        Sample::Global(Place {
            stamp_us: 1,
            measured_us: 1,
            valid: true,
            place: Geodetic {
                latitude_deg,
                longitude_deg: 8.5,
                altitude_amsl_m: 488.0,
            },
        })
    };
    assert_eq!(field(place(47.4)), None);
    assert_eq!(field(place(1e308)), Some("lat"));
    assert_eq!(field(place(f64::NAN)), Some("lat"));
    let status = |nav_state, system_id| {
        Sample::Status(Status {
            stamp_us: 1,
            system_id,
            arming_state: 1,
            nav_state,
            failsafe: false,
            ready_to_arm: true,
            took_off: false,
        })
    };
    assert_eq!(field(status(14, 1)), None);
    assert_eq!(field(status(77, 1)), Some("nav_state"));
    assert_eq!(field(status(14, 0)), Some("system_id"));
    let attitude = |quaternion| {
        Sample::Attitude(Attitude {
            stamp_us: 1,
            quaternion,
        })
    };
    assert_eq!(field(attitude([1.0, 0.0, 0.0, 0.0])), None);
    assert_eq!(field(attitude([0.0; 4])), Some("q"));
    assert_eq!(field(attitude([f32::NAN, 0.0, 0.0, 1.0])), Some("q"));
}
