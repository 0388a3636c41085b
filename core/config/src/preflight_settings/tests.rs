//! Limits that nothing, or everything, would pass are refused by name.

use crate::NodeConfig;

#[test]
fn limits_make_sense() {
    for (text, key) in [
        ("loss_amber_share = 0.5", "loss_amber_share"),
        ("loss_red_share = 0.0", "loss_red_share"),
        ("position_within_s = nan", "position_within_s"),
        ("min_battery_share = 0.0", "min_battery_share"),
        ("full_battery_share = 0.2", "full_battery_share"),
        ("min_ground_distance_m = -1.0", "min_ground_distance_m"),
        ("max_clock_error_s = inf", "max_clock_error_s"),
    ] {
        let error = NodeConfig::parse(&format!("[safety.preflight]\n{text}\n"))
            .expect_err(text)
            .to_string();
        assert!(error.contains(&format!("safety.preflight.{key}:")), "{error}");
    }
}
