//! The messages of a bag, field by field in the order of their definitions.
//!
//! Must never do: differ from the text in `definitions.rs`. Another order of fields is another message.
#![allow(
    missing_docs,
    reason = "what the fields of standard messages mean stands in their definitions under these names"
)]

use serde::Serialize;

/// A message that stands on a topic.
pub trait Ros2Message: Serialize {
    /// Package, `msg` and name.
    const KIND: &'static str;
}

macro_rules! messages {
    ($($name:ident $(: $kind:literal)? { $($field:ident: $of:ty),+ $(,)? })+) => {
        $(
            #[derive(Debug, Clone, PartialEq, Default, Serialize)]
            pub struct $name { $(pub $field: $of),+ }
            $(impl Ros2Message for $name {
                const KIND: &'static str = $kind;
            })?
        )+
    };
}

messages! {
    Time { sec: i32, nanosec: u32 }
    Header { stamp: Time, frame_id: String }
    Point { x: f64, y: f64, z: f64 }
    Vector3 { x: f64, y: f64, z: f64 }
    Quaternion { x: f64, y: f64, z: f64, w: f64 }
    Pose { position: Point, orientation: Quaternion }
    PoseStamped: "geometry_msgs/msg/PoseStamped" { header: Header, pose: Pose }
    Twist { linear: Vector3, angular: Vector3 }
    TwistStamped: "geometry_msgs/msg/TwistStamped" { header: Header, twist: Twist }
    Transform { translation: Vector3, rotation: Quaternion }
    TransformStamped { header: Header, child_frame_id: String, transform: Transform }
    TfMessage: "tf2_msgs/msg/TFMessage" { transforms: Vec<TransformStamped> }
    NavSatStatus { status: i8, service: u16 }
    NavSatFix: "sensor_msgs/msg/NavSatFix" {
        header: Header,
        status: NavSatStatus,
        latitude: f64,
        longitude: f64,
        altitude: f64,
        position_covariance: [f64; 9],
        position_covariance_type: u8,
    }
    BatteryState: "sensor_msgs/msg/BatteryState" {
        header: Header,
        voltage: f32,
        temperature: f32,
        current: f32,
        charge: f32,
        capacity: f32,
        design_capacity: f32,
        percentage: f32,
        power_supply_status: u8,
        power_supply_health: u8,
        power_supply_technology: u8,
        present: bool,
        cell_voltage: Vec<f32>,
        cell_temperature: Vec<f32>,
        location: String,
        serial_number: String,
    }
    Log: "rcl_interfaces/msg/Log" {
        stamp: Time,
        level: u8,
        name: String,
        msg: String,
        file: String,
        function: String,
        line: u32,
    }
}
