//! What goes out about how the vehicle knows where it is: the receivers as they are, the estimator's word on itself, the wind.

use super::SimVehicle;
use super::channel::{Channel, Outbox};
use super::gnss::Reception;
use super::telemetry::{centidegrees, e7, mm};
use mavlink::dialects::common::{
    ESTIMATOR_STATUS_DATA, EstimatorStatusFlags, GPS_RAW_INT_DATA, GPS2_RAW_DATA, GpsFixType, WIND_COV_DATA,
};
use nalgebra::Vector3;
use skein_domain::Geodetic;

// Flags of ESTIMATOR_STATUS.
const ATTITUDE: u16 = 1;
const VERTICAL: u16 = 4 | 32 | 64;
const HORIZONTAL: u16 = 2 | 8 | 16;
const HORIZONTAL_PREDICTED: u16 = 256 | 512;
const GLITCH: u16 = 1024;
/// `CONST_POS_MODE`: since 1.16 PX4 sets it of every vehicle that stands still, whatever holds its position.
const AT_REST: u16 = 128;

/// Satellites that a receiver in the open uses, and its accuracy in millimetres.
pub(super) const SATELLITES: u8 = 16;
const ACCURACY_MM: u32 = 700;
/// Accuracy of a receiver that hears nothing, in millimetres.
const NO_ACCURACY_MM: u32 = 100_000;

impl SimVehicle {
    /// Whether there is anything to tell by a message now: nothing that nobody knows any more.
    pub(super) fn has_to_tell(&self, id: u32) -> bool {
        let of_estimator = matches!(id, 32 | 33 | 230 | 231 | 331);
        // As PX4 has it: no position is sent when the horizontal one is invalid.
        let of_position = matches!(id, 32 | 33);
        let wind = id == 231 && (self.lift.is_landed() || self.parameters.number("EKF2_DRAG_CTRL") == 0.0);
        !(of_estimator && self.faults.estimate_stopped || of_position && !self.estimator.satellites.is_valid() || wind)
    }

    pub(super) fn estimator_status(&self) -> ESTIMATOR_STATUS_DATA {
        let satellites = &self.estimator.satellites;
        let mut flags = ATTITUDE | VERTICAL;
        if self.lift.is_landed() {
            flags |= AT_REST;
        }
        if self.commander.is_estimator_ready() {
            if satellites.is_valid() {
                flags |= HORIZONTAL | HORIZONTAL_PREDICTED;
            }
            if satellites.is_refused() {
                flags |= GLITCH;
            }
        }
        ESTIMATOR_STATUS_DATA {
            time_usec: self.up_us(),
            vel_ratio: 0.02,
            pos_horiz_ratio: (satellites.ratio() as f32).max(0.02),
            pos_vert_ratio: 0.01,
            mag_ratio: 0.01,
            pos_horiz_accuracy: self.horizontal_accuracy_m() as f32,
            pos_vert_accuracy: 0.2,
            flags: EstimatorStatusFlags::from_bits_retain(flags),
            ..ESTIMATOR_STATUS_DATA::default()
        }
    }

    /// Without aid the uncertainty grows faster and faster.
    pub(super) fn horizontal_accuracy_m(&self) -> f64 {
        let unaided_s = self.estimator.satellites.unaided_s();
        (0.2 + 0.1 * unaided_s + 0.05 * unaided_s * unaided_s).min(1e4)
    }

    pub(super) fn wind_cov(&self) -> WIND_COV_DATA {
        WIND_COV_DATA {
            time_usec: self.up_us(),
            wind_x: self.wind_seen.x as f32,
            wind_y: self.wind_seen.y as f32,
            wind_alt: self.geodetic_of(&self.estimator.now.position).altitude_amsl_m as f32,
            horiz_accuracy: 0.3,
            ..WIND_COV_DATA::default()
        }
    }

    /// What a receiver tells: the truth, its own error, and what the estimate wanders by for other reasons.
    pub(super) fn place_told(&self, reception: &Reception) -> (Geodetic, Vector3<f64>) {
        let now = &self.estimator.now;
        let satellites = &self.estimator.satellites;
        let told = now.position - satellites.error + reception.offset;
        (self.geodetic_of(&told), now.velocity - satellites.drift)
    }

    pub(super) fn hears(&self, reception: &Reception) -> bool {
        self.up_time_s() > 0.5 && !reception.lost
    }

    pub(super) fn gps_raw_int(&self) -> GPS_RAW_INT_DATA {
        self.told_by(&self.estimator.satellites.first())
    }

    /// What a receiver tells.
    fn told_by(&self, reception: &Reception) -> GPS_RAW_INT_DATA {
        let fixed = self.hears(reception);
        let (place, velocity) = self.place_told(reception);
        let mut message = GPS_RAW_INT_DATA {
            time_usec: self.up_us(),
            fix_type: fix(fixed),
            satellites_visible: if fixed { SATELLITES } else { 0 },
            eph: if fixed { 70 } else { 9_999 },
            epv: if fixed { 70 } else { 9_999 },
            h_acc: if fixed { ACCURACY_MM } else { NO_ACCURACY_MM },
            v_acc: 900,
            vel_acc: 150,
            ..GPS_RAW_INT_DATA::default()
        };
        if fixed {
            (message.lat, message.lon) = (e7(place.latitude_deg), e7(place.longitude_deg));
            message.alt = mm(place.altitude_amsl_m);
            message.alt_ellipsoid = mm(place.altitude_amsl_m + 47.2);
            message.vel = (velocity.norm() * 1e2) as u16;
            message.cog = centidegrees(velocity.y.atan2(velocity.x));
        }
        message
    }

    /// False for a vehicle without a second receiver.
    pub(super) fn send_second_gnss(&self, channel: &mut Channel, out: &mut Outbox) -> bool {
        let Some(reception) = self.estimator.satellites.second() else {
            return false;
        };
        let told = self.told_by(&reception);
        let message = GPS2_RAW_DATA {
            time_usec: told.time_usec,
            fix_type: told.fix_type,
            lat: told.lat,
            lon: told.lon,
            alt: told.alt,
            alt_ellipsoid: told.alt_ellipsoid,
            eph: told.eph,
            epv: told.epv,
            vel: told.vel,
            cog: told.cog,
            satellites_visible: told.satellites_visible,
            h_acc: told.h_acc,
            v_acc: told.v_acc,
            vel_acc: told.vel_acc,
            ..GPS2_RAW_DATA::default()
        };
        channel.send(out, &message);
        true
    }
}

fn fix(fixed: bool) -> GpsFixType {
    if fixed {
        GpsFixType::GPS_FIX_TYPE_3D_FIX
    } else {
        GpsFixType::GPS_FIX_TYPE_NO_FIX
    }
}
