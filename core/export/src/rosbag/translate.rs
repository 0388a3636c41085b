//! What a recording tells, as messages.
//!
//! Must never do: read a clock, or say what was not recorded.

use super::messages::{
    BatteryState, Header, Log, NavSatFix, NavSatStatus, Pose, PoseStamped, TfMessage, Time, Transform,
    TransformStamped, Twist, TwistStamped, Vector3,
};
use super::{frames, names};
use crate::told::Told;
use skein_domain::exchange::Severity;
use skein_domain::telemetry::{GnssFix, VehicleKinematics};
use skein_domain::{Battery, PositionNed, Setpoint};
use skein_recording::VehicleTelemetry;
use skein_view::EventRecord;

// The codes of `sensor_msgs` that are used here.
const STATUS_NO_FIX: i8 = -1;
const STATUS_FIX: i8 = 0;
const STATUS_GBAS_FIX: i8 = 2;
const SERVICE_GPS: u16 = 1;
const COVARIANCE_UNKNOWN: u8 = 0;
const COVARIANCE_APPROXIMATED: u8 = 1;
const SUPPLY_UNKNOWN: u8 = 0;
const SUPPLY_DISCHARGING: u8 = 2;

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
pub(super) fn transforms(pose: &PoseStamped, name: &str, origin: PositionNed) -> TfMessage {
    let origin = frames::translation(&origin);
    let at = &pose.pose.position;
    let here = Vector3 {
        x: at.x - origin.x,
        y: at.y - origin.y,
        z: at.z - origin.z,
    };
    let odom = names::odom(name);
    TfMessage {
        transforms: vec![
            TransformStamped {
                header: pose.header.clone(),
                child_frame_id: odom.clone(),
                transform: Transform {
                    translation: origin,
                    rotation: frames::unrotated(),
                },
            },
            TransformStamped {
                header: Header {
                    frame_id: odom,
                    ..pose.header.clone()
                },
                child_frame_id: names::base_link(name),
                transform: Transform {
                    translation: here,
                    rotation: pose.pose.orientation.clone(),
                },
            },
        ],
    }
}

/// Altitude is above the sea, not above the ellipsoid: no model of the difference is at hand.
pub(super) fn fix(stamp_ns: u64, of: &VehicleTelemetry, name: &str) -> Option<NavSatFix> {
    let place = of.global?;
    let status = match of.gnss.fix {
        GnssFix::Unknown | GnssFix::None => STATUS_NO_FIX,
        GnssFix::TwoD | GnssFix::ThreeD => STATUS_FIX,
        GnssFix::Dgps | GnssFix::RtkFloat | GnssFix::RtkFixed => STATUS_GBAS_FIX,
    };
    let accuracy_m = of.gnss.horizontal_accuracy_m.map(f64::from).filter(|m| m.is_finite());
    let square = accuracy_m.map_or(0.0, |m| m * m);
    Some(NavSatFix {
        header: header(stamp_ns, &names::base_link(name)),
        status: NavSatStatus {
            status,
            service: SERVICE_GPS,
        },
        latitude: place.latitude_deg,
        longitude: place.longitude_deg,
        altitude: place.altitude_amsl_m,
        // The vertical one is not reported; it is usually twice the horizontal one.
        position_covariance: [square, 0.0, 0.0, 0.0, square, 0.0, 0.0, 0.0, 4.0 * square],
        position_covariance_type: accuracy_m.map_or(COVARIANCE_UNKNOWN, |_| COVARIANCE_APPROXIMATED),
    })
}

/// What is not known is not a number, as the definition has it.
pub(super) fn battery(stamp_ns: u64, of: &Battery, name: &str) -> BatteryState {
    let discharging = of.current_a.is_some_and(|a| a > 0.0);
    BatteryState {
        header: header(stamp_ns, &names::base_link(name)),
        voltage: of.voltage_v.unwrap_or(f32::NAN),
        temperature: f32::NAN,
        // Negative when it is discharged.
        current: of.current_a.map_or(f32::NAN, |current_a| -current_a),
        charge: f32::NAN,
        capacity: f32::NAN,
        design_capacity: f32::NAN,
        percentage: of.remaining.unwrap_or(f32::NAN),
        power_supply_status: if discharging {
            SUPPLY_DISCHARGING
        } else {
            SUPPLY_UNKNOWN
        },
        present: of.voltage_v.is_some() || of.remaining.is_some(),
        ..BatteryState::default()
    }
}

/// An event as a line of the log; of a vehicle by its node's name there.
pub(super) fn log(told: &Told, event: &EventRecord, vehicle: Option<&str>) -> Log {
    let level = match event.severity {
        Severity::Info | Severity::Advisory => 20,
        Severity::Warning => 30,
        Severity::Critical => 40,
    };
    Log {
        stamp: time(told.at_ns),
        level,
        name: vehicle.map_or_else(
            || "skein.swarm".to_owned(),
            |vehicle| format!("skein.{vehicle}.vehicle"),
        ),
        msg: event.text.clone(),
        ..Log::default()
    }
}
