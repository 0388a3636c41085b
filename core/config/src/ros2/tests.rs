//! Each senseless value is refused by its key.

use crate::{ConfigError, NodeConfig};

fn keys(text: &str) -> Vec<String> {
    match NodeConfig::parse(&format!("[ros2]\n{text}")) {
        Ok(_) => Vec::new(),
        Err(ConfigError::Wrong { problems, .. }) => problems.into_iter().map(|p| p.key).collect(),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn senseless_values_are_refused_by_name() {
    assert!(keys("enabled = true\nnamespace = \"fleet_2\"").is_empty());
    for namespace in ["", "2b", "a-b", "a__b", "_a"] {
        assert_eq!(keys(&format!("namespace = {namespace:?}")), ["ros2.namespace"]);
    }
    assert_eq!(keys("motion_rate_hz = nan"), ["ros2.motion_rate_hz"]);
    assert_eq!(keys("cmd_vel_valid_s = 60.0"), ["ros2.cmd_vel_valid_s"]);
}
