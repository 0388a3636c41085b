//! What is written is read again, in both orders of bytes, and of the size that the fields say.

use super::*;
use crate::cdr::{Encoding, decode, encode};
use crate::messages::incoming::VehicleCommand;
use byteorder::BigEndian;
use std::path::Path;

#[path = "../../build.rs"]
#[allow(
    dead_code,
    clippy::duplicate_mod,
    reason = "this is the build's own program, and not all of it is run here"
)]
mod build;

fn command() -> VehicleCommand {
    VehicleCommand {
        timestamp: 1_700_000_000_123_456,
        param1: 1.0,
        param2: 21_196.0,
        param3: -0.5,
        param4: f32::INFINITY,
        param5: 47.397_742,
        param6: 8.545_594,
        param7: 500.0,
        command: 400,
        target_system: 3,
        target_component: 1,
        source_system: 245,
        source_component: 190,
        confirmation: 2,
        from_external: true,
    }
}

#[test]
fn what_is_written_is_read_again() {
    let written = encode(&command()).unwrap();
    assert_eq!(written.len(), size_bytes(VehicleCommand::FIELDS));
    assert_eq!(
        decode::<VehicleCommand>(Encoding::LittleEndian, &written).unwrap(),
        command()
    );
    let other = cdr_encoding::to_vec::<_, BigEndian>(&command()).unwrap();
    assert_eq!(
        decode::<VehicleCommand>(Encoding::BigEndian, &other).unwrap(),
        command()
    );
}

#[test]
fn an_octet_that_is_no_truth_value_is_refused() {
    let mut written = encode(&command()).unwrap();
    *written.last_mut().unwrap() = 2;
    assert!(decode::<VehicleCommand>(Encoding::LittleEndian, &written).is_err());
}

#[test]
fn fields_are_told_as_they_are_declared() {
    let first: Vec<_> = incoming::TrajectorySetpoint::FIELDS.iter().take(3).collect();
    assert_eq!(
        (first[0].name, first[0].kind, first[0].elements),
        ("timestamp", Kind::U64, None)
    );
    assert_eq!(
        (first[1].name, first[1].kind, first[1].elements),
        ("position", Kind::F32, Some(3))
    );
    assert_eq!(first[2].kind.word(), "float32");
}

#[test]
fn a_line_that_defines_nothing_ends_the_build_with_its_place() {
    let parsed = |text: &str| build::parse(Path::new("1.19/Some.msg"), text).map(|shape| shape.fields.len());
    assert_eq!(
        parsed("uint32 MESSAGE_VERSION = 3\nuint64 timestamp\nfloat32[4] q\n"),
        Ok(2)
    );
    for bad in [
        "",
        "# text",
        "uint64",
        "uint64 ",
        "uint64  timestamp",
        "uint64 timestamp # text",
        "string name",
        "int128 wide",
        "float32[] q",
        "float32[x] q",
        "float32[4 q",
        "uint8 FIX = 3",
        "uint32 MESSAGE_VERSION = x",
    ] {
        let error = parsed(&format!("uint64 timestamp\n{bad}\n")).unwrap_err();
        assert!(error.starts_with("1.19/Some.msg:2: "), "{error}");
    }
}
