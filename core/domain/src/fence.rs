//! Where a swarm may fly and where not, as operators draw it: zones on the map or in the swarm's frame, with altitude bands and what
//! happens when one is left or entered. Configuration, API and dashboard share this description; what is inside of it, and how
//! near, is `skein-safety`'s to say.

use crate::SwarmFrame;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A place on the ground: WGS 84 degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapPoint {
    /// Latitude in degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude in degrees, east positive.
    pub longitude_deg: f64,
}

impl MapPoint {
    /// From latitude and longitude in degrees.
    #[must_use]
    pub const fn new(latitude_deg: f64, longitude_deg: f64) -> Self {
        Self {
            latitude_deg,
            longitude_deg,
        }
    }

    /// Whether it is on the globe.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.latitude_deg.abs() <= 90.0 && self.longitude_deg.abs() <= 180.0
    }

    /// North and east of the frame's origin in metres.
    #[must_use]
    pub fn in_frame_m(&self, frame: &SwarmFrame) -> [f64; 2] {
        let position = frame.position(&crate::Geodetic {
            latitude_deg: self.latitude_deg,
            longitude_deg: self.longitude_deg,
            altitude_amsl_m: frame.origin.altitude_amsl_m,
        });
        [position.north_m, position.east_m]
    }
}

/// Whether a zone is to be stayed in or kept out of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ZoneKind {
    /// To be stayed in: with several, in any of them.
    Inclusion,
    /// To be kept out of.
    Exclusion,
}

/// What floor and ceiling of a zone count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AltitudeReference {
    /// The origin of the swarm's frame.
    #[default]
    Origin,
    /// Mean sea level.
    Amsl,
}

/// What a vehicle does that is where a zone does not let it be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BreachAction {
    /// It is reported, no more.
    Warn,
    /// It stops and holds its position.
    #[default]
    Hold,
    /// It returns to where it was launched.
    Return,
    /// It lands where it is.
    Land,
}

impl BreachAction {
    /// The word for it, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Warn => "warn",
            Self::Hold => "hold",
            Self::Return => "return",
            Self::Land => "land",
        }
    }
}

/// The outline of a zone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum ZoneOutline {
    /// A polygon on the map, its corners in either direction.
    Polygon {
        /// Its corners; the first may be repeated at the end.
        corners: Vec<MapPoint>,
    },
    /// A circle on the map.
    Circle {
        /// Its middle.
        centre: MapPoint,
        /// Its radius in metres.
        radius_m: f64,
    },
    /// A polygon in the swarm's frame.
    LocalPolygon {
        /// Its corners as `[north_m, east_m]`.
        corners_m: Vec<[f64; 2]>,
    },
    /// A circle in the swarm's frame.
    LocalCircle {
        /// Its middle as `[north_m, east_m]`.
        centre_m: [f64; 2],
        /// Its radius in metres.
        radius_m: f64,
    },
}

impl ZoneOutline {
    /// Whether it stands on the map, so that the swarm's origin has to be known before it means anything.
    #[must_use]
    pub fn is_geographic(&self) -> bool {
        matches!(self, Self::Polygon { .. } | Self::Circle { .. })
    }
}

/// One zone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FenceZone {
    /// Name shown to people and in refusals.
    pub name: String,
    /// To be stayed in or kept out of.
    pub kind: ZoneKind,
    /// Its outline.
    pub outline: ZoneOutline,
    /// Lowest height in metres; without one it reaches down without end.
    #[serde(default)]
    pub floor_m: Option<f64>,
    /// Greatest height in metres; without one it reaches up without end.
    #[serde(default)]
    pub ceiling_m: Option<f64>,
    /// What the two count from.
    #[serde(default)]
    pub altitude_reference: AltitudeReference,
    /// What becomes of a vehicle that is where it must not be.
    #[serde(default)]
    pub action: BreachAction,
}

/// Why a zone is none.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ZoneError {
    /// It has no name, so that no refusal could say which it is.
    #[error("a zone needs a name")]
    NoName,
    /// A corner, or the middle, is not on the globe or not finite.
    #[error("point {index} is not a place: {first}, {second}")]
    NotAPlace {
        /// Its place in the list, from 0; 0 for the middle of a circle.
        index: usize,
        /// Latitude, or metres north.
        first: f64,
        /// Longitude, or metres east.
        second: f64,
    },
    /// A circle without a usable radius.
    #[error("the radius of {radius_m} m must be above 0 and at most {MAX_RADIUS_M} m")]
    Radius {
        /// What was given.
        radius_m: f64,
    },
    /// The floor is not below the ceiling, or one of them is not a number.
    #[error("the floor at {floor_m} m must be below the ceiling at {ceiling_m} m")]
    FloorAboveCeiling {
        /// The floor in metres.
        floor_m: f64,
        /// The ceiling in metres.
        ceiling_m: f64,
    },
}

/// No circle is larger.
pub const MAX_RADIUS_M: f64 = 100_000.0;

impl FenceZone {
    /// What can be said of a zone without a frame.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), ZoneError> {
        if self.name.trim().is_empty() {
            return Err(ZoneError::NoName);
        }
        let (floor_m, ceiling_m) = (
            self.floor_m.unwrap_or(f64::NEG_INFINITY),
            self.ceiling_m.unwrap_or(f64::INFINITY),
        );
        let finite = self.floor_m.is_none_or(f64::is_finite) && self.ceiling_m.is_none_or(f64::is_finite);
        if !(floor_m < ceiling_m && finite) {
            return Err(ZoneError::FloorAboveCeiling { floor_m, ceiling_m });
        }
        let on_map = |index: usize, p: &MapPoint| ZoneError::NotAPlace {
            index,
            first: p.latitude_deg,
            second: p.longitude_deg,
        };
        let local = |index: usize, p: &[f64; 2]| ZoneError::NotAPlace {
            index,
            first: p[0],
            second: p[1],
        };
        let finite_m = |p: &[f64; 2]| p.iter().all(|x| x.is_finite());
        let wrong = match &self.outline {
            ZoneOutline::Polygon { corners } => first_wrong(corners, MapPoint::is_valid, on_map),
            ZoneOutline::Circle { centre, .. } => first_wrong(&[*centre], MapPoint::is_valid, on_map),
            ZoneOutline::LocalPolygon { corners_m } => first_wrong(corners_m, finite_m, local),
            ZoneOutline::LocalCircle { centre_m, .. } => first_wrong(&[*centre_m], finite_m, local),
        };
        if let Some(error) = wrong {
            return Err(error);
        }
        match self.outline {
            ZoneOutline::Circle { radius_m, .. } | ZoneOutline::LocalCircle { radius_m, .. }
                if !(radius_m > 0.0 && radius_m <= MAX_RADIUS_M) =>
            {
                Err(ZoneError::Radius { radius_m })
            }
            _ => Ok(()),
        }
    }
}

fn first_wrong<P>(
    points: &[P],
    is_right: impl Fn(&P) -> bool,
    error: impl Fn(usize, &P) -> ZoneError,
) -> Option<ZoneError> {
    let (index, point) = points.iter().enumerate().find(|(_, p)| !is_right(p))?;
    Some(error(index, point))
}

/// Where a vehicle that has left a fence is to come back to, as some ground stations let operators set.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreachReturn {
    /// The place.
    pub place: MapPoint,
    /// Height above the swarm's origin in metres, if given.
    #[serde(default)]
    pub height_m: Option<f64>,
}

/// All zones of a swarm. A vehicle may be where at least one inclusion zone is (anywhere, if there is none) and no exclusion zone.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FencePlan {
    /// The zones.
    #[serde(default)]
    pub zones: Vec<FenceZone>,
    /// Where to come back to.
    #[serde(default)]
    pub breach_return: Option<BreachReturn>,
}

impl FencePlan {
    /// Whether a zone can only be placed when the swarm's origin is known.
    #[must_use]
    pub fn needs_origin(&self) -> bool {
        self.zones
            .iter()
            .any(|zone| zone.outline.is_geographic() || zone.altitude_reference == AltitudeReference::Amsl)
    }
}

#[cfg(test)]
mod tests;
