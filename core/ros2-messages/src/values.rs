//! What is known of a vehicle as messages, where that needs no more than the value and a header.
//!
//! Must never do: read a clock, or say what is not known: that has the value that the definition has for it.

use crate::frames;
use crate::interfaces::Fixed;
use crate::interfaces::geometry::{Point, Pose, Transform, TransformStamped, Vector3};
use crate::interfaces::sensor::{BatteryState, NavSatFix, NavSatStatus};
use crate::interfaces::standard::Header;
use skein_domain::telemetry::GnssFix;
use skein_domain::{Battery, Geodetic, Gnss, PositionNed};

// The codes of `sensor_msgs` that are used here.
const STATUS_NO_FIX: i8 = -1;
const STATUS_FIX: i8 = 0;
const STATUS_GBAS_FIX: i8 = 2;
const SERVICE_GPS: u16 = 1;
const COVARIANCE_UNKNOWN: u8 = 0;
const COVARIANCE_APPROXIMATED: u8 = 1;
const SUPPLY_UNKNOWN: u8 = 0;
const SUPPLY_DISCHARGING: u8 = 2;

/// A place on Earth. Altitude is above the sea, not above the ellipsoid: no model of the difference is at hand.
#[must_use]
pub fn fix(header: Header, place: &Geodetic, gnss: &Gnss) -> NavSatFix {
    let status = match gnss.fix {
        GnssFix::Unknown | GnssFix::None => STATUS_NO_FIX,
        GnssFix::TwoD | GnssFix::ThreeD => STATUS_FIX,
        GnssFix::Dgps | GnssFix::RtkFloat | GnssFix::RtkFixed => STATUS_GBAS_FIX,
    };
    let accuracy_m = gnss.horizontal_accuracy_m.map(f64::from).filter(|m| m.is_finite());
    let mut covariance = Fixed::default();
    if let Some(accuracy_m) = accuracy_m {
        let square = accuracy_m * accuracy_m;
        // The vertical one is not reported; it is usually twice the horizontal one.
        (covariance.0[0], covariance.0[4], covariance.0[8]) = (square, square, 4.0 * square);
    }
    NavSatFix {
        header,
        status: NavSatStatus {
            status,
            service: SERVICE_GPS,
        },
        latitude: place.latitude_deg,
        longitude: place.longitude_deg,
        altitude: place.altitude_amsl_m,
        position_covariance: covariance,
        position_covariance_type: accuracy_m.map_or(COVARIANCE_UNKNOWN, |_| COVARIANCE_APPROXIMATED),
    }
}

/// A battery; what is not known is not a number, as the definition has it.
#[must_use]
pub fn battery(header: Header, of: &Battery) -> BatteryState {
    BatteryState {
        header,
        voltage: of.voltage_v.unwrap_or(f32::NAN),
        temperature: f32::NAN,
        // Negative when it is discharged.
        current: of.current_a.map_or(f32::NAN, |current_a| -current_a),
        charge: f32::NAN,
        capacity: f32::NAN,
        design_capacity: f32::NAN,
        percentage: of.remaining.unwrap_or(f32::NAN),
        power_supply_status: if of.current_a.is_some_and(|a| a > 0.0) {
            SUPPLY_DISCHARGING
        } else {
            SUPPLY_UNKNOWN
        },
        present: of.voltage_v.is_some() || of.remaining.is_some(),
        ..BatteryState::default()
    }
}

/// `map` to a vehicle's `odom` at its launch place, and from there to its `base_link`, which is `here` about that place. The header's frame is not read.
#[must_use]
pub fn transforms(
    header: &Header,
    [odom, base_link]: [&str; 2],
    origin: &PositionNed,
    here: &Pose,
) -> [TransformStamped; 2] {
    let translation = |point: &Point| Vector3 {
        x: point.x,
        y: point.y,
        z: point.z,
    };
    let within = |frame_id: &str| Header {
        frame_id: frame_id.to_owned(),
        ..header.clone()
    };
    [
        TransformStamped {
            header: within(frames::MAP),
            child_frame_id: odom.to_owned(),
            transform: Transform {
                translation: translation(&frames::point(origin)),
                rotation: frames::unrotated(),
            },
        },
        TransformStamped {
            header: within(odom),
            child_frame_id: base_link.to_owned(),
            transform: Transform {
                translation: translation(&here.position),
                rotation: here.orientation.clone(),
            },
        },
    ]
}
