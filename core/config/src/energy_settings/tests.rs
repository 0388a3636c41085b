//! Values with which nobody would get home are refused by name.

use crate::NodeConfig;

fn assert_refused(text: &str, key: &str) {
    let error = NodeConfig::parse(&format!("[safety.energy]\n{text}\n"))
        .expect_err(text)
        .to_string();
    assert!(error.contains(&format!("safety.energy.{key}:")), "{error}");
}

#[test]
fn a_wind_that_the_vehicle_cannot_fly_against_is_no_assumption() {
    assert_refused("assumed_wind_m_s = 8.0", "assumed_wind_m_s");
    assert_refused("airspeed_m_s = 4.0", "assumed_wind_m_s");
    assert_refused("gust_m_s = 5.0", "gust_m_s");
    assert!(NodeConfig::parse("[safety.energy]\nassumed_wind_m_s = 6.0\n").is_ok());
}

#[test]
fn shares_rates_and_cells_make_sense() {
    for (text, key) in [
        ("reserve_share = 1.0", "reserve_share"),
        ("critical_share = 0.0", "critical_share"),
        ("model_error_share = -0.1", "model_error_share"),
        ("hover_endurance_s = 0.0", "hover_endurance_s"),
        ("descent_m_s = nan", "descent_m_s"),
        ("climb_factor = 0.5", "climb_factor"),
        ("cells = 0", "cells"),
        ("capacity_ah = 0.0", "capacity_ah"),
        ("full_cell_v = 3.5", "full_cell_v"),
        ("memory_s = inf", "memory_s"),
    ] {
        assert_refused(text, key);
    }
    assert!(NodeConfig::parse("[safety.energy]\ncells = 6\ncapacity_ah = 16.0\n").is_ok());
}
