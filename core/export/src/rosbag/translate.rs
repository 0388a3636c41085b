//! What a recording tells, as messages.
//!
//! Must never do: read a clock, or say what was not recorded.

use crate::told::Told;
use skein_domain::exchange::Severity;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, Setpoint};
use skein_recording::VehicleTelemetry;
use skein_ros2_messages::interfaces::geometry::{Pose, PoseStamped, TransformStamped, Twist, TwistStamped, Vector3};
use skein_ros2_messages::interfaces::rcl::Log;
use skein_ros2_messages::interfaces::sensor::{BatteryState, NavSatFix};
use skein_ros2_messages::interfaces::standard::{Header, Time};
use skein_ros2_messages::{frames, names, values};
use skein_view::EventRecord;

fn time(unix_ns: u64) -> Time {
    Time {
        sec: i32::try_from(unix_ns / 1_000_000_000).unwrap_or(i32::MAX),
        nanosec: (unix_ns % 1_000_000_000) as u32,
    }
}

fn header(unix_ns: u64, frame_id: &str) -> Header {
    Header {
        stamp: time(unix_ns),
        frame_id: frame_id.to_owned(),
    }
}

pub(super) fn pose(stamp_ns: u64, of: &VehicleTelemetry, at: &VehicleKinematics) -> PoseStamped {
    PoseStamped {
        header: header(stamp_ns, frames::MAP),
        pose: Pose {
            position: frames::point(&at.position),
            orientation: frames::orientation(of.roll_rad.into(), of.pitch_rad.into(), at.yaw_rad),
        },
    }
}

/// Along the axes of `map`.
pub(super) fn twist(stamp_ns: u64, at: &VehicleKinematics) -> TwistStamped {
    TwistStamped {
        header: header(stamp_ns, frames::MAP),
        twist: Twist {
            linear: frames::velocity(&at.velocity),
            angular: Vector3::default(),
        },
    }
}

/// Where a setpoint wants a vehicle; nothing for one without a place.
pub(super) fn setpoint(told: &Told, of: &Setpoint) -> Option<PoseStamped> {
    let position = of.position?;
    let orientation = of
        .yaw_rad
        .map_or_else(frames::unrotated, |yaw_rad| frames::orientation(0.0, 0.0, yaw_rad));
    Some(PoseStamped {
        header: header(told.at_ns, frames::MAP),
        pose: Pose {
            position: frames::point(&position),
            orientation,
        },
    })
}

/// `map` to the vehicle's `odom` at its launch place, and from there to its `base_link`.
pub(super) fn transforms(
    pose: &PoseStamped,
    at: &PositionNed,
    name: &str,
    origin: &PositionNed,
) -> [TransformStamped; 2] {
    let here = Pose {
        position: frames::point(&PositionNed::from(at.vector() - origin.vector())),
        orientation: pose.pose.orientation.clone(),
    };
    let (odom, base_link) = (names::odom(name), names::base_link(name));
    values::transforms(&pose.header, [&odom, &base_link], origin, &here)
}

pub(super) fn fix(stamp_ns: u64, of: &VehicleTelemetry, name: &str) -> Option<NavSatFix> {
    let header = header(stamp_ns, &names::base_link(name));
    of.global.map(|place| values::fix(header, &place, &of.gnss))
}

pub(super) fn battery(stamp_ns: u64, of: &VehicleTelemetry, name: &str) -> BatteryState {
    values::battery(header(stamp_ns, &names::base_link(name)), &of.battery)
}

/// An event as a line of the log; of a vehicle by its node's name there.
pub(super) fn log(told: &Told, event: &EventRecord, vehicle: Option<&str>) -> Log {
    let level = match event.severity {
        Severity::Info | Severity::Advisory => 20,
        Severity::Warning => 30,
        Severity::Critical => 40,
    };
    let swarm = || format!("skein.{}", names::SWARM_NODE);
    Log {
        stamp: time(told.at_ns),
        level,
        name: vehicle.map_or_else(swarm, |vehicle| format!("skein.{vehicle}.{}", names::VEHICLE_NODE)),
        msg: event.text.clone(),
        ..Log::default()
    }
}
