//! Where a gimbal looks, where it is to look, and how far it can turn.

use minicbor::{Decode, Encode};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{Geodetic, NodeTime, SwarmFrame};
use std::f64::consts::FRAC_PI_2;

/// Nearer than this, in metres, straight above or below has no direction: the yaw stays as it is.
const NO_DIRECTION_M: f64 = 0.3;

/// Where a gimbal looks, as it last said.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Attitude {
    #[n(0)]
    pub(crate) heard: NodeTime,
    #[n(1)]
    pub(crate) roll_rad: f64,
    #[n(2)]
    pub(crate) pitch_rad: f64,
    #[n(3)]
    pub(crate) yaw: Yaw,
}

/// An angle about the vertical, clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) enum Yaw {
    /// From the vehicle's nose, in radians.
    #[n(0)]
    Vehicle(#[n(0)] f64),
    /// From north, in radians.
    #[n(1)]
    North(#[n(0)] f64),
}

impl Yaw {
    /// From the vehicle's nose, where that can be said.
    pub(crate) fn off_nose(self, vehicle_yaw_rad: Option<f64>) -> Option<f64> {
        match self {
            Self::Vehicle(yaw) => Some(wrap_angle_rad(yaw)),
            Self::North(yaw) => vehicle_yaw_rad.map(|nose| wrap_angle_rad(yaw - nose)),
        }
    }

    /// From north, where that can be said.
    pub(crate) fn off_north(self, vehicle_yaw_rad: Option<f64>) -> Option<f64> {
        match self {
            Self::North(yaw) => Some(wrap_angle_rad(yaw)),
            Self::Vehicle(yaw) => vehicle_yaw_rad.map(|nose| wrap_angle_rad(yaw + nose)),
        }
    }
}

impl Attitude {
    /// From a quaternion (w, x, y, z) that turns the axes of the frame into the camera's. `None` if it is none.
    pub(crate) fn from_quaternion(heard: NodeTime, q: [f32; 4], yaw: fn(f64) -> Yaw) -> Option<Self> {
        let [w, x, y, z] = q.map(f64::from);
        let q = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-3)?;
        let (roll_rad, pitch_rad, yaw_rad) = q.euler_angles();
        let finite = roll_rad.is_finite() && pitch_rad.is_finite() && yaw_rad.is_finite();
        finite.then(|| Self {
            heard,
            roll_rad,
            pitch_rad,
            yaw: yaw(yaw_rad),
        })
    }
}

/// Where a gimbal is to look.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Direction {
    #[n(0)]
    pub(crate) pitch_rad: f64,
    #[n(1)]
    pub(crate) yaw: Yaw,
}

impl Direction {
    /// From one place to another. `None` where they are one above the other, for then every yaw is right: `yaw` is kept.
    pub(crate) fn towards(from: &Geodetic, place: &Geodetic, yaw: f64) -> Self {
        let way = SwarmFrame::new(*from).position(place).vector();
        let level_m = way.xy().norm();
        let yaw = if level_m < NO_DIRECTION_M {
            yaw
        } else {
            way.y.atan2(way.x)
        };
        Self {
            pitch_rad: (-way.z).atan2(level_m),
            yaw: Yaw::North(yaw),
        }
    }

    /// The axis as seen from the vehicle; `None` if that cannot be said.
    pub(crate) fn seen_from_nose(&self, vehicle_yaw_rad: Option<f64>) -> Option<Vector3<f64>> {
        Some(axis(self.pitch_rad, self.yaw.off_nose(vehicle_yaw_rad)?))
    }

    /// The angle between this direction and where the gimbal looks; `None` if their frames cannot be compared.
    pub(crate) fn off_rad(&self, attitude: &Attitude, vehicle_yaw_rad: Option<f64>) -> Option<f64> {
        let (wanted, is) = match (self.yaw, attitude.yaw) {
            (Yaw::North(wanted), is) => (wanted, is.off_north(vehicle_yaw_rad)?),
            (Yaw::Vehicle(wanted), is) => (wanted, is.off_nose(vehicle_yaw_rad)?),
        };
        Some(axis(self.pitch_rad, wanted).angle(&axis(attitude.pitch_rad, is)))
    }
}

/// The direction of a pitch and a yaw in radians.
fn axis(pitch: f64, yaw: f64) -> Vector3<f64> {
    Vector3::new(pitch.cos() * yaw.cos(), pitch.cos() * yaw.sin(), pitch.sin())
}

/// How far a gimbal can turn, in radians.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Limits {
    #[n(0)]
    pub(crate) pitch_min_rad: f64,
    #[n(1)]
    pub(crate) pitch_max_rad: f64,
    /// From the vehicle's nose; absent if it turns all the way round or does not say.
    #[n(2)]
    pub(crate) yaw_min_rad: Option<f64>,
    #[n(3)]
    pub(crate) yaw_max_rad: Option<f64>,
}

impl Limits {
    /// Of a device that says nothing.
    pub(crate) const ANY: Self = Self {
        pitch_min_rad: -FRAC_PI_2,
        pitch_max_rad: FRAC_PI_2,
        yaw_min_rad: None,
        yaw_max_rad: None,
    };

    /// The same, with the axes at zero that there are not.
    pub(crate) fn of_axes(self, pitches: bool, yaws: bool) -> Self {
        let mut limits = self;
        if !pitches {
            (limits.pitch_min_rad, limits.pitch_max_rad) = (0.0, 0.0);
        }
        if !yaws {
            (limits.yaw_min_rad, limits.yaw_max_rad) = (Some(0.0), Some(0.0));
        }
        limits
    }

    /// From what a device says: no limit where its numbers make none.
    pub(crate) fn said(pitch: (f32, f32), yaw: (f32, f32)) -> Option<Self> {
        let (pitch_min_rad, pitch_max_rad) = (f64::from(pitch.0), f64::from(pitch.1));
        let (yaw_min, yaw_max) = (f64::from(yaw.0), f64::from(yaw.1));
        let turns = yaw_min < yaw_max && yaw_max - yaw_min < std::f64::consts::TAU - 0.01;
        (pitch_min_rad < pitch_max_rad && pitch_min_rad.is_finite() && pitch_max_rad.is_finite()).then_some(Self {
            pitch_min_rad,
            pitch_max_rad,
            yaw_min_rad: turns.then_some(yaw_min),
            yaw_max_rad: turns.then_some(yaw_max),
        })
    }

    /// Both these limits and a range of pitch. Where they have nothing in common the range given wins.
    pub(crate) fn within(self, low_rad: f64, high_rad: f64) -> Self {
        let (low, high) = (self.pitch_min_rad.max(low_rad), self.pitch_max_rad.min(high_rad));
        let (pitch_min_rad, pitch_max_rad) = if low <= high { (low, high) } else { (low_rad, high_rad) };
        Self {
            pitch_min_rad,
            pitch_max_rad,
            ..self
        }
    }

    /// The nearest direction that can be reached.
    pub(crate) fn nearest(&self, direction: Direction, vehicle_yaw_rad: Option<f64>) -> Direction {
        let pitch_rad = direction.pitch_rad.max(self.pitch_min_rad).min(self.pitch_max_rad);
        let mut yaw = direction.yaw;
        if let (Some(low), Some(high), Some(from_nose)) =
            (self.yaw_min_rad, self.yaw_max_rad, yaw.off_nose(vehicle_yaw_rad))
            && !(low..=high).contains(&from_nose)
        {
            let to = |end: f64| wrap_angle_rad(end - from_nose).abs();
            let end = if to(low) < to(high) { low } else { high };
            yaw = match yaw {
                Yaw::Vehicle(_) => Yaw::Vehicle(end),
                Yaw::North(_) => Yaw::North(wrap_angle_rad(end + vehicle_yaw_rad.unwrap_or_default())),
            };
        }
        Direction { pitch_rad, yaw }
    }
}
