//! Where the slots of a formation are, relative to its leader or to the place it is anchored to.
//!
//! Any two slots of a shape are at least the spacing apart. For shapes that have heights of their own (box, sphere, helix) vertical
//! distances count by `1 /` [`VERTICAL_FACTOR`] only, since one above another flies in its downwash; all others keep the spacing
//! horizontally, so that an altitude step only adds. A free shape is as close as its offsets are: [`smallest_distance_m`] says it.

mod distance;
mod errors;
mod import;
mod shapes;
mod view;

pub use distance::{VERTICAL_FACTOR, smallest_distance_m, smallest_separation_m};
pub use errors::FormationError;
pub use import::{OffsetsError, offsets_from_csv, offsets_from_json};
pub use view::{VIEW_HALF_ANGLE_RAD, View, views};

use nalgebra::Vector3;
use skein_domain::{FormationAnchor, FormationRequest, OffsetFrd, Shape};
use std::f64::consts::PI;

/// Slots are laid out this much wider than asked, so that rounding never makes a distance smaller than the spacing.
const ROUNDING_MARGIN: f64 = 1.0 + 1e-9;

/// Offsets of a free shape nearer than this are the same place, in metres. What else is too near is the safety gate's to say.
pub const LEAST_FREE_DISTANCE_M: f64 = 0.1;

/// An arc whose size is left out is a half circle.
const DEFAULT_ARC_DEG: f64 = 180.0;
/// A helix whose pitch is left out rises by so many spacings in a turn.
const DEFAULT_PITCH_SPACINGS: f64 = 2.0;

/// The slots of a formation of `count` vehicles as offsets from its leader, whose own (the first) is zero; spacing, scale, altitude
/// step and rotation applied. What the formation is anchored to is not looked at.
///
/// # Errors
/// [`FormationError`] if the count is zero or a parameter is not usable.
pub fn slots(request: &FormationRequest, count: usize) -> Result<Vec<OffsetFrd>, FormationError> {
    let places = laid_out(request, count)?;
    let leader = places.first().copied().unwrap_or_default();
    finished(&places, leader, request)
}

/// The same as offsets from an anchor that is no vehicle: the shape's centre (the mean of its places) is at the anchor, and every
/// slot is a follower's. The offsets of a free shape are taken as they are.
///
/// # Errors
/// As [`slots`].
pub fn centred_slots(request: &FormationRequest, count: usize) -> Result<Vec<OffsetFrd>, FormationError> {
    let places = laid_out(request, count)?;
    let centre = if request.shape == Shape::Free {
        Vector3::zeros()
    } else {
        places.iter().sum::<Vector3<f64>>() / count as f64
    };
    finished(&places, centre, request)
}

/// [`slots`] where the formation is anchored to its leader, else [`centred_slots`].
///
/// # Errors
/// As [`slots`].
pub fn anchored_slots(request: &FormationRequest, count: usize) -> Result<Vec<OffsetFrd>, FormationError> {
    match request.anchor {
        FormationAnchor::Leader => slots(request, count),
        FormationAnchor::Path { .. } | FormationAnchor::Reference { .. } | FormationAnchor::Place { .. } => {
            centred_slots(request, count)
        }
    }
}

/// Places as the shape, spacing, scale and altitude step ask for, about any origin.
fn laid_out(request: &FormationRequest, count: usize) -> Result<Vec<Vector3<f64>>, FormationError> {
    check(request, count)?;
    let spacing_m = request.spacing_m * request.scale;
    let unit_m = spacing_m * ROUNDING_MARGIN;
    let mut places = match request.shape {
        Shape::Line => shapes::line(count, unit_m),
        Shape::Column => shapes::column(count, unit_m),
        Shape::Wedge => shapes::wedge(count, unit_m),
        Shape::EchelonLeft => shapes::echelon(count, unit_m, -1.0),
        Shape::EchelonRight => shapes::echelon(count, unit_m, 1.0),
        Shape::Diamond => shapes::diamond(count, unit_m),
        Shape::Circle => shapes::circle(count, unit_m),
        Shape::Arc => shapes::arc(count, unit_m, arc_rad(request)?),
        Shape::Square => shapes::square(count, unit_m),
        Shape::Grid => shapes::grid(count, unit_m),
        Shape::Box => match request.layers {
            Some(0) => return Err(FormationError::NoLayers),
            layers => shapes::solid_box(count, unit_m, layers),
        },
        Shape::Sphere => shapes::sphere(count, unit_m),
        Shape::Helix => shapes::helix(count, unit_m, pitch_m(request)? * request.scale * ROUNDING_MARGIN),
        Shape::Free => free(request, count)?,
    };
    let step_m = request.altitude_step_m * request.scale;
    for (i, place) in places.iter_mut().enumerate() {
        place.z -= i as f64 * step_m;
    }
    if step_m != 0.0 && matches!(request.shape, Shape::Box | Shape::Sphere | Shape::Helix) {
        let flat: Vec<_> = places.iter().map(|place| distance::flattened(*place)).collect();
        let closest = distance::closest_pair(&flat);
        if let Some(pair) = closest.filter(|pair| pair.distance_m < spacing_m) {
            return Err(FormationError::AltitudeStepTooClose {
                altitude_step_m: request.altitude_step_m,
                distance_m: pair.distance_m,
                least_m: spacing_m,
            });
        }
    }
    Ok(places)
}

fn check(request: &FormationRequest, count: usize) -> Result<(), FormationError> {
    let FormationRequest {
        spacing_m,
        altitude_step_m,
        rotation_deg,
        scale,
        ..
    } = *request;
    if count == 0 {
        return Err(FormationError::NoMembers);
    }
    if !(spacing_m > 0.0 && spacing_m.is_finite()) {
        return Err(FormationError::InvalidSpacing { spacing_m });
    }
    if !altitude_step_m.is_finite() {
        return Err(FormationError::InvalidAltitudeStep { altitude_step_m });
    }
    if !rotation_deg.is_finite() {
        return Err(FormationError::InvalidRotation { rotation_deg });
    }
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(FormationError::InvalidScale { scale });
    }
    Ok(())
}

fn arc_rad(request: &FormationRequest) -> Result<f64, FormationError> {
    let arc_deg = request.arc_deg.unwrap_or(DEFAULT_ARC_DEG);
    if arc_deg > 0.0 && arc_deg <= 360.0 {
        Ok(arc_deg.to_radians())
    } else {
        Err(FormationError::InvalidArc { arc_deg })
    }
}

fn pitch_m(request: &FormationRequest) -> Result<f64, FormationError> {
    let pitch_m = request.pitch_m.unwrap_or(DEFAULT_PITCH_SPACINGS * request.spacing_m);
    let least_m = VERTICAL_FACTOR * request.spacing_m;
    if pitch_m >= least_m && pitch_m.is_finite() {
        Ok(pitch_m)
    } else {
        Err(FormationError::InvalidPitch { pitch_m, least_m })
    }
}

/// The first `count` of the offsets, scaled.
fn free(request: &FormationRequest, count: usize) -> Result<Vec<Vector3<f64>>, FormationError> {
    let offsets = request.offsets.as_deref().ok_or(FormationError::NoOffsets)?;
    let used = offsets.get(..count).ok_or(FormationError::TooFewOffsets {
        members: count,
        offsets: offsets.len(),
    })?;
    if let Some(index) = used.iter().position(|offset| !offset.is_finite()) {
        return Err(FormationError::NotFinite { index });
    }
    let places: Vec<_> = used.iter().map(|offset| offset.vector() * request.scale).collect();
    match distance::closest_pair(&places) {
        Some(pair) if pair.distance_m.is_nan() || pair.distance_m < LEAST_FREE_DISTANCE_M => {
            Err(FormationError::OffsetsTooClose {
                first: pair.first,
                second: pair.second,
                distance_m: pair.distance_m,
                least_m: LEAST_FREE_DISTANCE_M,
            })
        }
        _ => Ok(places),
    }
}

/// The places about `origin`, turned.
fn finished(
    places: &[Vector3<f64>],
    origin: Vector3<f64>,
    request: &FormationRequest,
) -> Result<Vec<OffsetFrd>, FormationError> {
    // Whole turns, so that no rotation at all leaves every number as it is.
    let (sin, cos) = ((request.rotation_deg % 360.0) * PI / 180.0).sin_cos();
    let turned = |place: &Vector3<f64>| {
        let p = place - origin;
        OffsetFrd::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z)
    };
    let slots: Vec<_> = places.iter().map(turned).collect();
    if slots.iter().all(OffsetFrd::is_finite) {
        Ok(slots)
    } else {
        Err(FormationError::TooLarge)
    }
}

#[cfg(test)]
mod tests;
