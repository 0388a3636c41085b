//! The definitions of the messages, as ROS 2 publishes them without their comments, for readers that do not have them.
//!
//! Must never do: change a name, a type or the order of fields.

/// By package and name, with what stands in them.
const ALL: [(&str, &[&str], &str); 15] = [
    ("builtin_interfaces/Time", &[], "int32 sec\nuint32 nanosec\n"),
    (
        "std_msgs/Header",
        &["builtin_interfaces/Time"],
        "builtin_interfaces/Time stamp\nstring frame_id\n",
    ),
    ("geometry_msgs/Point", &[], "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Vector3", &[], "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "geometry_msgs/Quaternion",
        &[],
        "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    ),
    (
        "geometry_msgs/Pose",
        &["geometry_msgs/Point", "geometry_msgs/Quaternion"],
        "Point position\nQuaternion orientation\n",
    ),
    (
        "geometry_msgs/PoseStamped",
        &["std_msgs/Header", "geometry_msgs/Pose"],
        "std_msgs/Header header\nPose pose\n",
    ),
    (
        "geometry_msgs/Twist",
        &["geometry_msgs/Vector3"],
        "Vector3 linear\nVector3 angular\n",
    ),
    (
        "geometry_msgs/TwistStamped",
        &["std_msgs/Header", "geometry_msgs/Twist"],
        "std_msgs/Header header\nTwist twist\n",
    ),
    (
        "geometry_msgs/Transform",
        &["geometry_msgs/Vector3", "geometry_msgs/Quaternion"],
        "Vector3 translation\nQuaternion rotation\n",
    ),
    (
        "geometry_msgs/TransformStamped",
        &["std_msgs/Header", "geometry_msgs/Transform"],
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    ),
    (
        "tf2_msgs/TFMessage",
        &["geometry_msgs/TransformStamped"],
        "geometry_msgs/TransformStamped[] transforms\n",
    ),
    (
        "sensor_msgs/NavSatStatus",
        &[],
        "int8 STATUS_UNKNOWN = -2\nint8 STATUS_NO_FIX = -1\nint8 STATUS_FIX = 0\nint8 STATUS_SBAS_FIX = 1\nint8 STATUS_GBAS_FIX = 2\n\
         int8 status -2\nuint16 SERVICE_UNKNOWN = 0\nuint16 SERVICE_GPS = 1\nuint16 SERVICE_GLONASS = 2\nuint16 SERVICE_COMPASS = 4\n\
         uint16 SERVICE_GALILEO = 8\nuint16 service\n",
    ),
    (
        "sensor_msgs/NavSatFix",
        &["std_msgs/Header", "sensor_msgs/NavSatStatus"],
        "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\nfloat64[9] position_covariance\n\
         uint8 COVARIANCE_TYPE_UNKNOWN = 0\nuint8 COVARIANCE_TYPE_APPROXIMATED = 1\nuint8 COVARIANCE_TYPE_DIAGONAL_KNOWN = 2\n\
         uint8 COVARIANCE_TYPE_KNOWN = 3\nuint8 position_covariance_type\n",
    ),
    (
        "sensor_msgs/BatteryState",
        &["std_msgs/Header"],
        "uint8 POWER_SUPPLY_STATUS_UNKNOWN = 0\nuint8 POWER_SUPPLY_STATUS_CHARGING = 1\nuint8 POWER_SUPPLY_STATUS_DISCHARGING = 2\n\
         uint8 POWER_SUPPLY_STATUS_NOT_CHARGING = 3\nuint8 POWER_SUPPLY_STATUS_FULL = 4\nuint8 POWER_SUPPLY_HEALTH_UNKNOWN = 0\n\
         uint8 POWER_SUPPLY_HEALTH_GOOD = 1\nuint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN = 0\nstd_msgs/Header header\nfloat32 voltage\n\
         float32 temperature\nfloat32 current\nfloat32 charge\nfloat32 capacity\nfloat32 design_capacity\nfloat32 percentage\n\
         uint8 power_supply_status\nuint8 power_supply_health\nuint8 power_supply_technology\nbool present\nfloat32[] cell_voltage\n\
         float32[] cell_temperature\nstring location\nstring serial_number\n",
    ),
];
const LOG: &str = "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time stamp\nuint8 level\n\
                   string name\nstring msg\nstring file\nstring function\nuint32 line\n";
/// What stands between two definitions.
const RULE: &str = "================================================================================";

fn found(name: &str) -> (&'static [&'static str], &'static str) {
    if name == "rcl_interfaces/Log" {
        return (&["builtin_interfaces/Time"], LOG);
    }
    let known = ALL.iter().find(|(known, ..)| *known == name);
    known.map_or((&[], ""), |(_, parts, text)| (parts, text))
}

/// The definition of a message with those of all that stands in it.
pub(super) fn whole(kind: &str) -> String {
    let (parts, text) = found(&kind.replace("/msg/", "/"));
    let (mut whole, mut told) = (text.to_owned(), Vec::new());
    let mut wait: Vec<&str> = parts.to_vec();
    while let Some(name) = wait.pop() {
        if told.contains(&name) {
            continue;
        }
        told.push(name);
        let (parts, text) = found(name);
        whole.push_str(&format!("{RULE}\nMSG: {name}\n{text}"));
        wait.extend(parts);
    }
    whole
}
