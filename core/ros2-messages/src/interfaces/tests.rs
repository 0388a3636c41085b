//! The package for others says what is said here, whatever is sent can be read back, and whatever comes in is taken without a panic.

use super::skein::*;
use super::standard::*;
use super::*;
use byteorder::{BigEndian, LittleEndian};
use proptest::prelude::*;
use std::path::PathBuf;

/// Name and type of each field in a definition, in order.
fn defined(text: &str) -> Vec<(String, String)> {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim())
        .filter(|line| !line.is_empty() && !line.contains('='))
        .map(|line| {
            let (kind, name) = line.split_once(' ').expect("a type and a name");
            (name.trim().to_owned(), kind.to_owned())
        })
        .collect()
}

fn package() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../deploy/ros2/skein_msgs")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(package().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn own<T: Interface>() -> Vec<(String, String)> {
    T::fields()
        .into_iter()
        .map(|(name, kind)| (name.to_owned(), kind))
        .collect()
}

fn is_message<T: Interface>() -> String {
    let path = format!("msg/{}.msg", T::NAME);
    assert_eq!(defined(&read(&path)), own::<T>(), "{path}");
    path
}

fn is_service<S: Service>() -> String {
    let path = format!("srv/{}.srv", S::NAME);
    let text = read(&path);
    let (request, response) = text.split_once("---").expect("two halves");
    assert_eq!(defined(request), own::<S::Request>(), "{path}");
    assert_eq!(defined(response), own::<S::Response>(), "{path}");
    path
}

#[test]
fn the_package_for_others_says_the_same() {
    let mut spoken = vec![
        is_message::<Formation>(),
        is_message::<GimbalState>(),
        is_message::<VehicleState>(),
        is_service::<Follow>(),
        is_service::<GoTo>(),
        is_service::<PointGimbal>(),
        is_service::<SetFormation>(),
        is_service::<TakeOff>(),
    ];
    spoken.sort();
    // Nothing is defined that is not spoken, and everything is generated.
    let cmake = read("CMakeLists.txt");
    let mut there = Vec::new();
    for folder in ["msg", "srv"] {
        for entry in std::fs::read_dir(package().join(folder)).expect("the folder") {
            there.push(format!(
                "{folder}/{}",
                entry.expect("an entry").file_name().to_string_lossy()
            ));
        }
    }
    there.sort();
    assert_eq!(there, spoken);
    assert!(
        there.iter().all(|path| cmake.contains(&format!("\"{path}\""))),
        "{cmake}"
    );
}

#[test]
fn words_of_standard_definitions() {
    let odometry: Vec<_> = nav::Odometry::fields();
    assert_eq!(odometry[0], ("header", "std_msgs/Header".to_owned()));
    assert_eq!(geometry::PoseWithCovariance::fields()[1].1, "float64[36]");
    assert_eq!(sensor::CompressedImage::fields()[2].1, "uint8[]");
    assert_eq!(
        diagnostic::DiagnosticArray::fields()[1].1,
        "diagnostic_msgs/DiagnosticStatus[]"
    );
}

fn round_trip<T: Interface + PartialEq + fmt::Debug>(message: &T) {
    let bytes = cdr_encoding::to_vec::<T, LittleEndian>(message).expect("encodes");
    let (back, read) = cdr_encoding::from_bytes::<T, LittleEndian>(&bytes).expect("decodes");
    assert_eq!((&back, read), (message, bytes.len()));
    // A part of it is none; no panic either.
    for end in 0..bytes.len() {
        let _ = cdr_encoding::from_bytes::<T, LittleEndian>(&bytes[..end]);
    }
}

#[test]
fn what_is_sent_can_be_read_back() {
    let header = Header {
        stamp: Time { sec: 5, nanosec: 6 },
        frame_id: "map".into(),
    };
    let mut odometry = nav::Odometry {
        header: header.clone(),
        child_frame_id: "uav_1/base_link".into(),
        ..Default::default()
    };
    odometry.pose.covariance.0[35] = 3.5;
    round_trip(&odometry);
    round_trip(&sensor::CameraInfo {
        header: header.clone(),
        d: vec![1.0, 2.0],
        p: Fixed([1.5; 12]),
        ..Default::default()
    });
    round_trip(&VehicleState {
        header,
        degraded: vec!["a".into(), String::new()],
        tracking_error_m: 1.0,
        ..Default::default()
    });
}

#[test]
fn a_covariance_lies_on_the_wire_as_36_numbers_and_no_length() {
    let bytes = cdr_encoding::to_vec::<_, LittleEndian>(&Fixed([1.0; 36])).expect("encodes");
    assert_eq!(bytes.len(), 36 * 8);
}

/// Everything that is taken from others.
fn take_all(bytes: &[u8]) {
    fn take<T: Interface>(bytes: &[u8]) {
        let _ = cdr_encoding::from_bytes::<T, LittleEndian>(bytes);
        let _ = cdr_encoding::from_bytes::<T, BigEndian>(bytes);
    }
    take::<geometry::Twist>(bytes);
    take::<SetBoolRequest>(bytes);
    take::<Empty>(bytes);
    take::<TakeOffRequest>(bytes);
    take::<GoToRequest>(bytes);
    take::<PointGimbalRequest>(bytes);
    take::<SetFormationRequest>(bytes);
    take::<FollowRequest>(bytes);
}

proptest! {
    #[test]
    fn any_octets_are_taken_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        take_all(&bytes);
    }

    /// Lengths that are not true are what hurts: a text or a list of four milliards of elements.
    #[test]
    fn lengths_that_are_not_true_cost_nothing(mut bytes in proptest::collection::vec(any::<u8>(), 4..300), at in 0usize..75) {
        let at = (at * 4).min(bytes.len() - 4);
        bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        take_all(&bytes);
    }
}
