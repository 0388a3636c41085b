//! What is to be seen of the swarm in the graph of ROS 2: every topic and service, by name and type.
//!
//! Must never do: leave out what the documentation tables.

use anyhow::{Result, ensure};
use serde_json::Value;

/// Name and type of everything that is to be seen of one vehicle and of the swarm.
const OF_A_VEHICLE: &[(&str, &str)] = &[
    ("pose", "geometry_msgs/msg/PoseStamped"),
    ("odometry", "nav_msgs/msg/Odometry"),
    ("nav_sat_fix", "sensor_msgs/msg/NavSatFix"),
    ("battery", "sensor_msgs/msg/BatteryState"),
    ("state", "skein_msgs/msg/VehicleState"),
    ("cmd_vel", "geometry_msgs/msg/Twist"),
];
/// The same of a camera and a gimbal on a vehicle.
const OF_PAYLOADS: &[(&str, &str)] = &[
    ("gimbal/state", "skein_msgs/msg/GimbalState"),
    ("camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
    ("camera/camera_info", "sensor_msgs/msg/CameraInfo"),
    ("frame_counter/detections", "vision_msgs/msg/Detection2DArray"),
];
const OF_THE_SWARM: &[(&str, &str)] = &[
    ("/skein/formation", "skein_msgs/msg/Formation"),
    ("/skein/tracks", "vision_msgs/msg/Detection3DArray"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
];
const SERVICES_OF_A_VEHICLE: &[(&str, &str)] = &[
    ("arm", "std_srvs/srv/SetBool"),
    ("take_off", "std_srvs/srv/Trigger"),
    ("land", "std_srvs/srv/Trigger"),
    ("hold", "std_srvs/srv/Trigger"),
    ("return_home", "std_srvs/srv/Trigger"),
    ("take_off_to", "skein_msgs/srv/TakeOff"),
    ("go_to", "skein_msgs/srv/GoTo"),
    ("point_gimbal", "skein_msgs/srv/PointGimbal"),
];
const SERVICES_OF_THE_SWARM: &[(&str, &str)] = &[
    ("take_off", "std_srvs/srv/Trigger"),
    ("land", "std_srvs/srv/Trigger"),
    ("hold", "std_srvs/srv/Trigger"),
    ("return_home", "std_srvs/srv/Trigger"),
    ("dissolve_formation", "std_srvs/srv/Trigger"),
    ("set_formation", "skein_msgs/srv/SetFormation"),
    ("follow", "skein_msgs/srv/Follow"),
];

fn is_seen(report: &Value, kind: &str, name: &str, of: &str) -> Result<()> {
    let types = &report[kind][name];
    ensure!(types == &serde_json::json!([of]), "{kind}: {name} is {types}, not {of}");
    Ok(())
}

/// Whether the first vehicle's payloads are in a report.
pub fn payloads_are_seen(report: &Value) -> Result<()> {
    for (topic, kind) in OF_PAYLOADS {
        is_seen(report, "topics", &format!("/skein/uav_1/{topic}"), kind)?;
    }
    Ok(())
}

/// Whether so many vehicles and the swarm are in a report, with all that they have.
pub fn everything_is_seen(report: &Value, vehicles: u8) -> Result<()> {
    let seen = |kind: &str, name: &str, of: &str| is_seen(report, kind, name, of);
    for id in 1..=vehicles {
        for (topic, kind) in OF_A_VEHICLE {
            seen("topics", &format!("/skein/uav_{id}/{topic}"), kind)?;
        }
        for (service, kind) in SERVICES_OF_A_VEHICLE {
            seen("services", &format!("/skein/uav_{id}/{service}"), kind)?;
        }
    }
    for (topic, kind) in OF_THE_SWARM {
        seen("topics", topic, kind)?;
    }
    for (service, kind) in SERVICES_OF_THE_SWARM {
        seen("services", &format!("/skein/{service}"), kind)?;
    }
    Ok(())
}
