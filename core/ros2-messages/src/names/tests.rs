//! Every name that is given is one that ROS 2 takes, and nobody else's.

use super::*;
use proptest::prelude::*;
use ros2_client::{Name, NodeName};

#[test]
fn usual_names() {
    assert_eq!(sanitised("uav-3"), "uav_3");
    assert_eq!(sanitised("3 of us"), "n3_of_us");
    assert_eq!(sanitised("__x--y__"), "x_y");
    assert_eq!(sanitised("äöü"), "");
    let mut names = Names::default();
    assert_eq!(names.of(VehicleId(1), "a b"), "a_b");
    assert_eq!(names.of(VehicleId(2), "a-b"), "a_b_id2");
    assert_eq!(names.of(VehicleId(3), "swarm"), "swarm_id3");
    assert_eq!(names.of(VehicleId(4), "…"), "uav_4");
    assert_eq!(names.of(VehicleId(1), "now another"), "a_b");
}

proptest! {
    #[test]
    fn ros_takes_every_name_and_no_two_are_alike(texts in proptest::collection::vec("\\PC{0,80}", 1..12)) {
        let mut names = Names::default();
        let mut seen = std::collections::BTreeSet::new();
        for (i, text) in (0..).zip(&texts) {
            let name = names.of(VehicleId(i), text);
            prop_assert!(seen.insert(name.clone()), "{} twice", name);
            prop_assert!(NodeName::new(&format!("/skein/{name}"), VEHICLE_NODE).is_ok(), "{}", name);
            prop_assert!(Name::new(&format!("/skein/{name}"), "pose").is_ok(), "{}", name);
            prop_assert!(Name::new("/skein", &name).is_ok(), "{}", name);
        }
    }
}
