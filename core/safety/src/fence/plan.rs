//! From the description of zones to volumes in the swarm's frame.

use super::{Fence, FenceError, Fences, Zone};
use skein_domain::{AltitudeReference, FencePlan, FenceZone, MapPoint, SwarmFrame, ZoneError, ZoneKind, ZoneOutline};
use std::f64::consts::{PI, TAU};
use thiserror::Error;

/// More zones than this are refused.
const MAX_ZONES: usize = 500;
/// Zones that reach further from the origin than this are refused, in metres: the frame is a plane.
const MAX_DISTANCE_M: f64 = 200_000.0;
/// The polygon for a circle is off it by no more than this, in metres…
const CIRCLE_OFF_M: f64 = 0.1;
/// …or, where that is more, this share of its radius.
const CIRCLE_OFF_SHARE: f64 = 2e-4;

/// Why zones cannot be placed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FencePlanError {
    /// A value of a zone is not usable.
    #[error("zone {index} \"{name}\": {source}")]
    Zone {
        /// Its place in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        source: ZoneError,
    },
    /// The outline of a zone is none.
    #[error("zone {index} \"{name}\": {source}")]
    Outline {
        /// Its place in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        source: FenceError,
    },
    /// The zone stands on the map, or its heights count from the sea, and the origin of the swarm's frame is not known.
    #[error("zone {index} \"{name}\" can only be placed when the swarm's origin is known")]
    NoOrigin {
        /// Its place in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// A zone far away is a mistake: latitude and longitude exchanged, or another country's.
    #[error("zone {index} \"{name}\" reaches {distance_km:.0} km from the swarm's origin, more than {limit_km:.0} km", limit_km = MAX_DISTANCE_M / 1000.0)]
    TooFar {
        /// Its place in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// How far, in kilometres.
        distance_km: f64,
    },
    /// More zones than can be checked in every period.
    #[error("{count} zones are more than {MAX_ZONES}")]
    TooManyZones {
        /// How many were given.
        count: usize,
    },
}

impl Fences {
    /// The zones of a plan in the swarm's frame. Without a frame only what needs none can be placed. A circle becomes a polygon, off
    /// by at most 0.1 m or 0.02 % of its radius, on the safe side: within the circle of an inclusion, about that of an exclusion.
    ///
    /// # Errors
    /// [`FencePlanError`] with the zone and what is wrong with it.
    pub fn from_plan(plan: &FencePlan, frame: Option<&SwarmFrame>) -> Result<Self, FencePlanError> {
        let count = plan.zones.len();
        if count > MAX_ZONES {
            return Err(FencePlanError::TooManyZones { count });
        }
        let zones: Result<Vec<Zone>, FencePlanError> = plan
            .zones
            .iter()
            .enumerate()
            .map(|(index, zone)| placed(index, zone, frame))
            .collect();
        Ok(Self::new(zones?))
    }
}

fn placed(index: usize, zone: &FenceZone, frame: Option<&SwarmFrame>) -> Result<Zone, FencePlanError> {
    let name = || zone.name.clone();
    zone.check().map_err(|source| FencePlanError::Zone {
        index,
        name: name(),
        source,
    })?;
    let no_origin = || FencePlanError::NoOrigin { index, name: name() };
    let on_map = |point: &MapPoint| frame.map(|frame| point.in_frame_m(frame)).ok_or_else(no_origin);
    let corners_m = match &zone.outline {
        ZoneOutline::Polygon { corners } => corners.iter().map(on_map).collect::<Result<Vec<_>, _>>()?,
        ZoneOutline::Circle { centre, radius_m } => circle(on_map(centre)?, *radius_m, zone.kind),
        ZoneOutline::LocalPolygon { corners_m } => corners_m.clone(),
        ZoneOutline::LocalCircle { centre_m, radius_m } => circle(*centre_m, *radius_m, zone.kind),
    };
    let furthest_m = corners_m.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    if furthest_m > MAX_DISTANCE_M {
        return Err(FencePlanError::TooFar {
            index,
            name: name(),
            distance_km: furthest_m / 1000.0,
        });
    }
    let sea_m = match zone.altitude_reference {
        AltitudeReference::Origin => 0.0,
        AltitudeReference::Amsl => frame.ok_or_else(no_origin)?.origin.altitude_amsl_m,
    };
    let floor_m = zone.floor_m.map_or(f64::NEG_INFINITY, |m| m - sea_m);
    let ceiling_m = zone.ceiling_m.map_or(f64::INFINITY, |m| m - sea_m);
    let volume = Fence::open(corners_m, floor_m, ceiling_m).map_err(|source| FencePlanError::Outline {
        index,
        name: name(),
        source,
    })?;
    Ok(Zone {
        name: name(),
        kind: zone.kind,
        action: zone.action,
        volume,
    })
}

/// The polygon for a circle: in it for an inclusion, about it for an exclusion.
fn circle(centre_m: [f64; 2], radius_m: f64, kind: ZoneKind) -> Vec<[f64; 2]> {
    let off_m = CIRCLE_OFF_M.max(CIRCLE_OFF_SHARE * radius_m);
    let half_step = (1.0 - off_m / radius_m).clamp(0.0, 1.0).acos();
    let count = (PI / half_step).ceil().clamp(16.0, 200.0);
    let corner_m = match kind {
        ZoneKind::Inclusion => radius_m,
        ZoneKind::Exclusion => radius_m / (PI / count).cos(),
    };
    (0..count as u32)
        .map(|k| {
            let (sin, cos) = (f64::from(k) / count * TAU).sin_cos();
            [centre_m[0] + corner_m * cos, centre_m[1] + corner_m * sin]
        })
        .collect()
}

#[cfg(test)]
mod tests;
