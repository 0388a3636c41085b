//! What was written is read; anything else is told, and never believed.

use super::super::{Flown, Kept};
use super::*;
use skein_coordination::Interrupted;
use skein_domain::{FormationRequest, NodeTime, PositionNed, Route, Shape, VehicleCommand, VehicleId};

fn kept() -> Kept {
    let formation = Interrupted {
        request: FormationRequest::new(Shape::Wedge, 5.5),
        route: Some(Route {
            waypoints: vec![PositionNed::new(100.0, -20.1, -12.3)],
            speed_m_s: 4.0,
            corner_radius_m: 8.0,
        }),
        missing: vec![VehicleId(1), VehicleId(2)],
    };
    let go_to = VehicleCommand::GoTo {
        position: PositionNed::new(1.0 / 3.0, 2.0, -3.0),
        yaw_rad: None,
        speed_m_s: None,
    };
    Kept {
        node: "ground".into(),
        written_us: 1_800_000_000_000_000,
        time: NodeTime::from_seconds(12.0),
        flown: Flown {
            formation: Some(formation),
            withdrawn: [VehicleId(3)].into(),
            vehicles: [(VehicleId(1), None), (VehicleId(3), Some(go_to))].into(),
            ..Flown::default()
        },
    }
}

#[test]
fn what_was_written_is_read_and_an_older_file_gives_way_to_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("node.resume");
    assert!(read(&path).expect("no file is no fault").is_none());
    for kept in [
        Kept {
            node: "other".into(),
            ..kept()
        },
        kept(),
    ] {
        crate::whole_file::replace(&path, &encode(&kept).expect("is small")).expect("is written");
        assert_eq!(read(&path).expect("is sound"), Some(kept));
    }
}

#[test]
fn cut_off_at_any_byte_it_is_of_no_use() {
    let whole = encode(&kept()).expect("is small");
    for length in 0..whole.len() {
        assert!(decode(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
    }
}

#[test]
fn with_any_byte_changed_it_is_of_no_use() {
    let whole = encode(&kept()).expect("is small");
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x20;
        // Letters of the checksum may be written large.
        if damaged.eq_ignore_ascii_case(&whole) && decode(&damaged).is_ok_and(|read| read == kept()) {
            continue;
        }
        assert!(decode(&damaged).is_err(), "byte {at}");
    }
}

#[test]
fn another_version_another_kind_and_too_much_are_told_by_name() {
    let whole = String::from_utf8(encode(&kept()).expect("is small")).expect("is text");
    let newer = whole.replacen(" 1 ", " 2 ", 1);
    assert!(matches!(decode(newer.as_bytes()), Err(FileFault::Version(2))));
    let wrong = whole.replacen("ground", "sky___", 1);
    assert!(matches!(decode(wrong.as_bytes()), Err(FileFault::Damaged)));
    assert!(matches!(decode(b"{}\n"), Err(FileFault::Foreign)));
    assert!(matches!(decode(&[0xff; 100]), Err(FileFault::Foreign)));
    let mut long = kept();
    long.node = "x".repeat(LARGEST_BYTES);
    assert!(matches!(encode(&long), Err(FileFault::TooLarge)));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("node.resume");
    std::fs::write(&path, vec![b'x'; LARGEST_BYTES + 1]).expect("is written");
    assert!(matches!(read(&path), Err(FileFault::TooLarge)));
}
