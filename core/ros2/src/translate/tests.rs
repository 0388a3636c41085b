//! What a snapshot says is what the messages say, in the frames that they name.

use super::*;
use serde_json::json;
use skein_domain::{Geodetic, NodeTime, VelocityNed};
use skein_view::{ActorHealth, PluginHealth};
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

fn stamps() -> Stamps {
    Stamps {
        node: NodeTime::from_seconds(100.0),
        system: Duration::from_secs(1_700_000_000),
    }
}

fn vehicle() -> VehicleSnapshot {
    let origin = Geodetic {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_amsl_m: 400.0,
    };
    serde_json::from_value(json!({
        "id": 3, "name": "uav-3", "system_id": 3, "plugin": "generic-uav", "plugin_version": "1",
        "flight_state": "holding", "state_detail": "", "mode": "offboard", "armed": true, "landed": "in_air",
        "ready_to_arm": null, "global": origin, "kinematics": null, "roll_rad": 0.0, "pitch_rad": 0.0, "home": null,
        "battery": skein_domain::Battery::default(), "gnss": skein_domain::Gnss::default(),
        "link": skein_domain::LinkHealth { connected: true, ..Default::default() },
        "age_s": 0.1, "slot": null, "tracking_error_m": null, "is_leader": false,
        "actor": ActorHealth::default(), "model": PluginHealth::default(), "model_state": null, "avoiding": null,
        "failsafe": null, "energy": null, "stopped": false, "limits": null, "capability": null, "payloads": [], "degraded": [],
    }))
    .expect("a snapshot")
}

fn at() -> VehicleKinematics {
    VehicleKinematics {
        position: PositionNed::new(10.0, 20.0, -5.0),
        velocity: VelocityNed::new(0.0, 3.0, 0.0),
        yaw_rad: FRAC_PI_2,
        measured: NodeTime::from_seconds(99.5),
    }
}

#[test]
fn a_moment_of_the_nodes_clock_is_one_since_1970() {
    let time = stamps().time(NodeTime::from_seconds(99.5));
    assert_eq!((time.sec, time.nanosec), (1_699_999_999, 500_000_000));
    // Before 1970 there is nothing.
    let odd = Stamps {
        system: Duration::from_secs(1),
        ..stamps()
    };
    assert_eq!(odd.time(NodeTime(0)).sec, 0);
}

#[test]
fn motion_is_told_in_map_and_about_the_launch_place() {
    let stamped = pose_stamped(&vehicle(), &at(), &stamps());
    assert_eq!(stamped.header.frame_id, "map");
    assert_eq!(stamped.header.stamp.sec, 1_699_999_999);
    assert_eq!(
        (
            stamped.pose.position.x,
            stamped.pose.position.y,
            stamped.pose.position.z
        ),
        (20.0, 10.0, 5.0)
    );
    let origin = PositionNed::new(10.0, 0.0, 0.0);
    let told = odometry(&vehicle(), "uav_3", &at(), &origin, &stamps());
    assert_eq!(
        (told.header.frame_id.as_str(), told.child_frame_id.as_str()),
        ("uav_3/odom", "uav_3/base_link")
    );
    assert_eq!((told.pose.pose.position.x, told.pose.pose.position.y), (20.0, 0.0));
    // It flies east and looks east: forward.
    let linear = &told.twist.twist.linear;
    assert!((linear.x - 3.0).abs() < 1e-9 && linear.y.abs() < 1e-9, "{linear:?}");
    // Both transforms, one after the other, are the pose.
    let [to_odom, to_base] = transforms(&told, &origin);
    assert_eq!(
        (to_odom.header.frame_id.as_str(), to_odom.child_frame_id.as_str()),
        ("map", "uav_3/odom")
    );
    assert_eq!(
        (to_base.header.frame_id.as_str(), to_base.child_frame_id.as_str()),
        ("uav_3/odom", "uav_3/base_link")
    );
    let sum = to_odom.transform.translation.x + to_base.transform.translation.x;
    assert!((sum - stamped.pose.position.x).abs() < 1e-9);
    assert_eq!(to_base.transform.rotation, stamped.pose.orientation);
}

#[test]
fn what_is_not_known_is_not_a_number() {
    let told = battery(&vehicle(), "uav_3", &stamps());
    assert!(told.voltage.is_nan() && told.percentage.is_nan() && !told.present);
    let mut full = vehicle();
    full.battery.voltage_v = Some(16.0);
    full.battery.current_a = Some(4.0);
    let told = battery(&full, "uav_3", &stamps());
    assert!(told.present && told.current == -4.0 && told.power_supply_status == 2);
    let told = fix(&vehicle(), "uav_3", &stamps()).expect("a place");
    assert_eq!((told.status.status, told.position_covariance_type), (-1, 0));
    let mut nowhere = vehicle();
    nowhere.global = None;
    assert_eq!(fix(&nowhere, "uav_3", &stamps()), None);
}

#[test]
fn what_is_wrong_shows() {
    let level = |vehicle: &VehicleSnapshot| health(vehicle, "uav_3", Vec::new()).level;
    assert_eq!(level(&vehicle()), Level::Ok as u8);
    let mut changed = vehicle();
    changed.degraded.push("no camera".into());
    assert_eq!(level(&changed), Level::Warn as u8);
    changed.stopped = true;
    assert_eq!(level(&changed), Level::Error as u8);
    changed.age_s = 10.0;
    assert_eq!(level(&changed), Level::Stale as u8);
}

#[test]
fn no_formation_is_told_too() {
    let fleet = FleetSnapshot::default();
    assert!(!formation(&fleet, &stamps()).active);
    let told = state(&vehicle(), &fleet, "uav_3", &stamps());
    assert_eq!(
        (told.flight_state.as_str(), told.mode.as_str(), told.in_formation),
        ("holding", "offboard", false)
    );
}

#[test]
fn a_track_says_what_it_may_be_and_how_well_it_is_known() {
    let told = TrackEstimate::told(skein_domain::payload::Track {
        track: 4,
        position: PositionNed::new(1.0, 2.0, -3.0),
        velocity: VelocityNed::default(),
        time: NodeTime::from_seconds(99.0),
        error_m: None,
    });
    let plain = track(&told, &stamps());
    assert_eq!((plain.id.as_str(), plain.results.len()), ("4", 1));
    assert_eq!(plain.results[0].hypothesis.class_id, "unknown");
    assert_eq!(plain.results[0].pose.covariance, Fixed::default());
    let known = TrackEstimate {
        classes: [("bird".to_owned(), 0.2), ("drone".to_owned(), 0.7)].into(),
        covariance_m2: Some([4.0, 0.0, 0.0, 9.0, 0.0, 16.0]),
        ..told
    };
    let known = track(&known, &stamps());
    let classes: Vec<_> = known.results.iter().map(|r| r.hypothesis.class_id.as_str()).collect();
    assert_eq!(classes, ["drone", "bird"]);
    assert_eq!(known.results[0].pose.covariance.0[0], 9.0);
    assert_eq!(
        known.bbox.center.position,
        crate::interfaces::geometry::Point { x: 2.0, y: 1.0, z: 3.0 }
    );
}
