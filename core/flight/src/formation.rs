//! Where the slots of a formation are, relative to its leader.

use skein_domain::{OffsetFrd, Shape};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use thiserror::Error;

/// Why a formation or a transition cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FormationError {
    /// A formation needs at least its leader.
    #[error("a formation needs at least one vehicle")]
    NoMembers,
    /// The spacing is not a positive finite number.
    #[error("spacing {spacing_m} m: it must be a finite number above zero")]
    InvalidSpacing {
        /// What was given.
        spacing_m: f64,
    },
    /// The altitude step is not finite.
    #[error("altitude step {altitude_step_m} m: it must be a finite number")]
    InvalidAltitudeStep {
        /// What was given.
        altitude_step_m: f64,
    },
    /// A motion limit is not a positive finite number.
    #[error("{limit} = {value}: it must be a finite number above zero")]
    InvalidLimit {
        /// Which limit.
        limit: &'static str,
        /// What was given.
        value: f64,
    },
    /// An offset is not finite.
    #[error("the offset of member {index} is not finite")]
    NotFinite {
        /// Its place in the list, from 0.
        index: usize,
    },
    /// Fewer slots than members.
    #[error("{members} members, but {slots} slots")]
    NotEnoughSlots {
        /// Members, the leader included.
        members: usize,
        /// Slots, the leader's included.
        slots: usize,
    },
    /// No way into the slots was found that keeps the asked distance.
    #[error("no way into the slots keeps {limit_m:.1} m between the vehicles; the best found comes to {best_m:.1} m")]
    NoSafeTransition {
        /// The largest smallest distance of all ways tried, in metres.
        best_m: f64,
        /// The distance asked for in metres.
        limit_m: f64,
    },
}

/// Slots are laid out this much wider than asked, so that rounding never makes a distance smaller than the spacing.
const ROUNDING_MARGIN: f64 = 1.0 + 1e-9;

/// The slots of a formation of `count` vehicles as offsets from its leader, whose own (the first) is zero. Any two are at least
/// `spacing_m` apart horizontally. Each next one is `altitude_step_m` higher than the one before.
///
/// # Errors
/// [`FormationError`] if the count is zero or a number is not usable.
pub fn slots(
    shape: Shape,
    count: usize,
    spacing_m: f64,
    altitude_step_m: f64,
) -> Result<Vec<OffsetFrd>, FormationError> {
    if count == 0 {
        return Err(FormationError::NoMembers);
    }
    if !(spacing_m > 0.0 && spacing_m.is_finite()) {
        return Err(FormationError::InvalidSpacing { spacing_m });
    }
    if !altitude_step_m.is_finite() {
        return Err(FormationError::InvalidAltitudeStep { altitude_step_m });
    }
    let unit_m = spacing_m * ROUNDING_MARGIN;
    let planar: Vec<(f64, f64)> = match shape {
        Shape::Line => (0..count).map(|i| (0.0, alternating(i) * unit_m)).collect(),
        Shape::Column => (0..count).map(|i| (-(i as f64) * unit_m, 0.0)).collect(),
        Shape::Wedge => (0..count).map(|i| wedge(i, unit_m)).collect(),
        Shape::Circle => circle(count, unit_m),
        _ => grid(count, unit_m),
    };
    let place = |(i, (forward_m, right_m)): (usize, (f64, f64))| OffsetFrd {
        forward_m,
        right_m,
        // `0.0 -` instead of a negation: a plain zero stays a plain zero.
        down_m: 0.0 - i as f64 * altitude_step_m,
    };
    Ok(planar.into_iter().enumerate().map(place).collect())
}

/// 0, 1, -1, 2, -2, …: the place in a row that is filled from its middle outwards, right side first.
fn alternating(index: usize) -> f64 {
    let step = index.div_ceil(2) as f64;
    if index % 2 == 1 { step } else { 0.0 - step }
}

/// Arms at 45 degrees to the rear on both sides; neighbours on an arm are one unit apart.
fn wedge(index: usize, unit_m: f64) -> (f64, f64) {
    let right_m = alternating(index) * unit_m * FRAC_1_SQRT_2;
    (0.0 - right_m.abs(), right_m)
}

/// Neighbours one unit apart along the chord; the leader at the front, the others clockwise.
fn circle(count: usize, unit_m: f64) -> Vec<(f64, f64)> {
    if count == 1 {
        return vec![(0.0, 0.0)];
    }
    let radius_m = unit_m / (2.0 * (PI / count as f64).sin());
    let place = |i: usize| {
        let (sin, cos) = (2.0 * PI * i as f64 / count as f64).sin_cos();
        // cos - 1 = -2 sin²(half) would be as exact as needed only near zero; the plain form is exact at the leader itself.
        (radius_m * (cos - 1.0), radius_m * sin)
    };
    (0..count).map(place).collect()
}

/// Rows from front to back, each filled from its middle outwards; the leader in the middle of the first.
fn grid(count: usize, unit_m: f64) -> Vec<(f64, f64)> {
    let mut columns = (count as f64).sqrt().ceil() as usize;
    while columns * columns < count {
        columns += 1;
    }
    let place = |i: usize| (0.0 - (i / columns) as f64 * unit_m, alternating(i % columns) * unit_m);
    (0..count).map(place).collect()
}

#[cfg(test)]
mod tests;
