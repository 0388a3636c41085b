//! Frames and units as types, so that a position in one vehicle's frame cannot be taken for one in the swarm's.
//!
//! * [`Geodetic`]: WGS 84 latitude and longitude in degrees, altitude above mean sea level in metres.
//! * [`PositionNed`]: north, east, down in metres in the swarm's one common frame ([`SwarmFrame`]).
//! * [`LocalPositionNed`]: the same axes in one vehicle's own frame ([`LocalFrame`]), whose origin is where its estimator started.
//! * [`VelocityNed`], [`AccelerationNed`]: along those axes. Both frames are tangent planes a few kilometres apart at most, so
//!   that their axes differ by less than 0.1 degree and a velocity is the same in both.
//! * [`OffsetFrd`]: forward, right, down in metres relative to a formation's heading.
//!
//! The projection is the spherical azimuthal equidistant one that PX4 itself uses for its local frame. With any other,
//! a setpoint hundreds of metres from a vehicle's origin would come out up to 0.3 % wrong in that vehicle's frame.

use minicbor::{Decode, Encode};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Radius of the sphere of the projection in metres (the value PX4 uses).
pub const EARTH_RADIUS_M: f64 = 6_371_000.0;

/// A place on Earth: WGS 84 degrees and metres above mean sea level.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Geodetic {
    /// Latitude in degrees, north positive.
    #[n(0)]
    pub latitude_deg: f64,
    /// Longitude in degrees, east positive.
    #[n(1)]
    pub longitude_deg: f64,
    /// Altitude above mean sea level in metres.
    #[n(2)]
    pub altitude_amsl_m: f64,
}

impl Geodetic {
    /// Whether all parts are finite and within the range of the globe.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.latitude_deg.abs() <= 90.0 && self.longitude_deg.abs() <= 180.0 && self.altitude_amsl_m.is_finite()
    }
}

// The ranges are those within which the published documents say that numbers mean something: beyond 100 km the tangent plane is no use.
macro_rules! triple {
    ($(#[$doc:meta])* $name:ident { $a:ident, $b:ident, $c:ident } $unit:literal, $least:literal to $most:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        #[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            #[doc = concat!("First axis, in ", $unit, ".")]
            #[n(0)]
            #[schemars(range(min = $least, max = $most))]
            pub $a: f64,
            #[doc = concat!("Second axis, in ", $unit, ".")]
            #[n(1)]
            #[schemars(range(min = $least, max = $most))]
            pub $b: f64,
            #[doc = concat!("Third axis, in ", $unit, ".")]
            #[n(2)]
            #[schemars(range(min = $least, max = $most))]
            pub $c: f64,
        }

        impl $name {
            /// From the three axes in order.
            #[must_use]
            pub const fn new($a: f64, $b: f64, $c: f64) -> Self {
                Self { $a, $b, $c }
            }

            /// As a vector for arithmetic; the frame is then the caller's to remember.
            #[must_use]
            pub fn vector(&self) -> Vector3<f64> {
                Vector3::new(self.$a, self.$b, self.$c)
            }

            /// Whether all three parts are finite numbers.
            #[must_use]
            pub fn is_finite(&self) -> bool {
                self.$a.is_finite() && self.$b.is_finite() && self.$c.is_finite()
            }

            /// Length of the vector.
            #[must_use]
            pub fn norm(&self) -> f64 {
                self.vector().norm()
            }
        }

        impl From<Vector3<f64>> for $name {
            fn from(v: Vector3<f64>) -> Self {
                Self::new(v.x, v.y, v.z)
            }
        }
    };
}

triple!(
    /// A position in the swarm's common frame: metres north, east and down of its origin.
    PositionNed { north_m, east_m, down_m } "metres", -100_000.0 to 100_000.0
);
triple!(
    /// A position in one vehicle's own frame: metres north, east and down of where its estimator started.
    LocalPositionNed { north_m, east_m, down_m } "metres", -100_000.0 to 100_000.0
);
triple!(
    /// A velocity along north, east and down.
    VelocityNed { north_m_s, east_m_s, down_m_s } "metres per second", -1000.0 to 1000.0
);
triple!(
    /// An acceleration along north, east and down.
    AccelerationNed { north_m_s2, east_m_s2, down_m_s2 } "metres per second squared", -10_000.0 to 10_000.0
);
triple!(
    /// A place relative to a formation's anchor: metres forward, right and down of it.
    OffsetFrd { forward_m, right_m, down_m } "metres", -100_000.0 to 100_000.0
);

impl PositionNed {
    /// Distance to another position in metres.
    #[must_use]
    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.vector() - other.vector()).norm()
    }

    /// Horizontal distance to another position in metres.
    #[must_use]
    pub fn horizontal_distance_m(&self, other: &Self) -> f64 {
        (self.vector() - other.vector()).xy().norm()
    }

    /// This position moved by a vector in the same axes, in metres.
    #[must_use]
    pub fn moved(&self, by_m: Vector3<f64>) -> Self {
        Self::from(self.vector() + by_m)
    }

    /// Where one arrives from here after `seconds` at a constant velocity.
    #[must_use]
    pub fn after(&self, velocity: &VelocityNed, seconds: f64) -> Self {
        self.moved(velocity.vector() * seconds)
    }
}

impl OffsetFrd {
    /// The offset along north, east and down in metres when forward points to `heading_rad` (clockwise from north).
    #[must_use]
    pub fn rotated(&self, heading_rad: f64) -> Vector3<f64> {
        let (sin, cos) = heading_rad.sin_cos();
        Vector3::new(
            self.forward_m * cos - self.right_m * sin,
            self.forward_m * sin + self.right_m * cos,
            self.down_m,
        )
    }

    /// The inverse of [`Self::rotated`]: the offset that points along `ned_m` when forward is `heading_rad`.
    #[must_use]
    pub fn from_ned(ned_m: Vector3<f64>, heading_rad: f64) -> Self {
        let (sin, cos) = heading_rad.sin_cos();
        Self::new(ned_m.x * cos + ned_m.y * sin, -ned_m.x * sin + ned_m.y * cos, ned_m.z)
    }
}

/// Tangent plane about a geodetic origin; the shared arithmetic of [`SwarmFrame`] and [`LocalFrame`].
fn project(origin: &Geodetic, place: &Geodetic) -> Vector3<f64> {
    let (lat0, lat) = (origin.latitude_deg.to_radians(), place.latitude_deg.to_radians());
    let d_lon = (place.longitude_deg - origin.longitude_deg).to_radians();
    let cos_c = (lat0.sin() * lat.sin() + lat0.cos() * lat.cos() * d_lon.cos()).clamp(-1.0, 1.0);
    let c = cos_c.acos();
    let k = if c.abs() < 1e-12 { 1.0 } else { c / c.sin() };
    Vector3::new(
        k * (lat0.cos() * lat.sin() - lat0.sin() * lat.cos() * d_lon.cos()) * EARTH_RADIUS_M,
        k * lat.cos() * d_lon.sin() * EARTH_RADIUS_M,
        origin.altitude_amsl_m - place.altitude_amsl_m,
    )
}

/// How often a vehicle's origin is corrected at most, and what it may be off by.
const STEPS_TO_ORIGIN: usize = 12;
const CLOSE_TO_ORIGIN_M: f64 = 1e-4;

/// Inverse of [`project`].
fn unproject(origin: &Geodetic, ned_m: Vector3<f64>) -> Geodetic {
    let (x, y) = (ned_m.x / EARTH_RADIUS_M, ned_m.y / EARTH_RADIUS_M);
    let c = x.hypot(y);
    let lat0 = origin.latitude_deg.to_radians();
    let (lat, lon) = if c < 1e-15 {
        (lat0, origin.longitude_deg.to_radians())
    } else {
        let (sin_c, cos_c) = c.sin_cos();
        (
            (cos_c * lat0.sin() + x * sin_c * lat0.cos() / c).asin(),
            origin.longitude_deg.to_radians() + (y * sin_c).atan2(c * lat0.cos() * cos_c - x * lat0.sin() * sin_c),
        )
    };
    Geodetic {
        latitude_deg: lat.to_degrees(),
        longitude_deg: lon.to_degrees(),
        altitude_amsl_m: origin.altitude_amsl_m - ned_m.z,
    }
}

/// The swarm's one common frame: north-east-down about a geodetic origin that all members share.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct SwarmFrame {
    /// The shared origin.
    pub origin: Geodetic,
}

impl SwarmFrame {
    /// The frame about `origin`.
    #[must_use]
    pub fn new(origin: Geodetic) -> Self {
        Self { origin }
    }

    /// A place on Earth in this frame.
    #[must_use]
    pub fn position(&self, place: &Geodetic) -> PositionNed {
        project(&self.origin, place).into()
    }

    /// A position of this frame as a place on Earth.
    #[must_use]
    pub fn geodetic(&self, position: &PositionNed) -> Geodetic {
        unproject(&self.origin, position.vector())
    }
}

/// One vehicle's own frame: north-east-down about the place where its estimator started.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LocalFrame {
    /// The vehicle's own origin.
    pub origin: Geodetic,
}

impl LocalFrame {
    /// The origin that explains a place and a local position measured at the same moment.
    #[must_use]
    pub fn from_pair(place: &Geodetic, local: &LocalPositionNed) -> Self {
        let mut origin = unproject(place, -local.vector());
        // The tangent planes of the place and of the origin are turned against each other, near the poles by much: each step takes out
        // most of what is left, and two or three are enough outside the last degrees.
        for _ in 0..STEPS_TO_ORIGIN {
            let left = local.vector() - project(&origin, place);
            if left.norm() < CLOSE_TO_ORIGIN_M {
                break;
            }
            origin = unproject(&origin, -left);
        }
        Self { origin }
    }

    /// A place on Earth in this vehicle's frame.
    #[must_use]
    pub fn position(&self, place: &Geodetic) -> LocalPositionNed {
        project(&self.origin, place).into()
    }

    /// A position of this vehicle's frame as a place on Earth.
    #[must_use]
    pub fn geodetic(&self, position: &LocalPositionNed) -> Geodetic {
        unproject(&self.origin, position.vector())
    }

    /// A swarm position in this vehicle's frame.
    #[must_use]
    pub fn from_swarm(&self, frame: &SwarmFrame, position: &PositionNed) -> LocalPositionNed {
        self.position(&frame.geodetic(position))
    }

    /// A position of this vehicle's frame in the swarm's.
    #[must_use]
    pub fn to_swarm(&self, frame: &SwarmFrame, position: &LocalPositionNed) -> PositionNed {
        frame.position(&self.geodetic(position))
    }
}

/// An angle in radians brought into -pi..=pi.
#[must_use]
pub fn wrap_angle_rad(angle_rad: f64) -> f64 {
    let wrapped = (angle_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    if wrapped == -std::f64::consts::PI {
        std::f64::consts::PI
    } else {
        wrapped
    }
}

#[cfg(test)]
mod tests;
