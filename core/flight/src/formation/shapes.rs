//! The outlines: where the places of each shape are, the leader's first, for neighbours `unit_m` apart. Forward, right, down.

use super::distance::{VERTICAL_FACTOR, closest_pair, flattened};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Places of one shape.
pub(super) type Places = Vec<Vector3<f64>>;

fn level(forward: f64, right: f64) -> Vector3<f64> {
    Vector3::new(forward, right, 0.0)
}

/// 0, 1, -1, 2, -2, …: the place in a row that is filled from its middle outwards, right side first.
fn alternating(index: usize) -> f64 {
    let step = index.div_ceil(2) as f64;
    if index % 2 == 1 { step } else { 0.0 - step }
}

pub(super) fn line(count: usize, unit_m: f64) -> Places {
    (0..count).map(|i| level(0.0, alternating(i) * unit_m)).collect()
}

pub(super) fn column(count: usize, unit_m: f64) -> Places {
    (0..count).map(|i| level(0.0 - i as f64 * unit_m, 0.0)).collect()
}

/// Arms at 45 degrees to the rear on both sides; neighbours on an arm are one unit apart.
pub(super) fn wedge(count: usize, unit_m: f64) -> Places {
    let place = |i| {
        let right_m = alternating(i) * unit_m * FRAC_1_SQRT_2;
        level(0.0 - right_m.abs(), right_m)
    };
    (0..count).map(place).collect()
}

/// One arm of the wedge: `side` is 1 for the right, -1 for the left.
pub(super) fn echelon(count: usize, unit_m: f64, side: f64) -> Places {
    let place = |i: usize| {
        let along_m = i as f64 * unit_m * FRAC_1_SQRT_2;
        level(0.0 - along_m, 0.0 + side * along_m)
    };
    (0..count).map(place).collect()
}

/// A lattice that stands on a corner, as large as the number asks for, filled from its outermost ring inwards: of each ring first
/// the corners, so that the outline is there however few there are.
pub(super) fn diamond(count: usize, unit_m: f64) -> Places {
    let side = side_for(count);
    let mut cells: Vec<(usize, usize)> = Vec::with_capacity(side * side);
    for ring in 0..side.div_ceil(2) {
        let far = side - 1 - ring;
        if far == ring {
            cells.push((ring, ring));
            continue;
        }
        cells.extend([(ring, ring), (far, ring), (ring, far), (far, far)]);
        // An odd one goes into the middle where the outermost ring is not full, so that both sides stay alike.
        let outer = 4 * (side - 1);
        if ring == 0 && side % 2 == 1 && count % 2 == 1 && count < outer {
            cells.push((side / 2, side / 2));
        }
        cells.extend((ring + 1..far).flat_map(|k| [(k, ring), (ring, k)]));
        cells.extend((ring + 1..far).flat_map(|k| [(far, k), (k, far)]));
    }
    let place = |&(a, b): &(usize, usize)| {
        let (a, b) = (a as f64, b as f64);
        level(0.0 - (a + b) * FRAC_1_SQRT_2 * unit_m, (a - b) * FRAC_1_SQRT_2 * unit_m)
    };
    cells.iter().take(count).map(place).collect()
}

/// Neighbours one unit apart along the chord; the leader at the front, the others clockwise.
pub(super) fn circle(count: usize, unit_m: f64) -> Places {
    let step_rad = TAU / count as f64;
    let radius_m = radius_for(step_rad, unit_m);
    let place = |i: usize| on_circle(i as f64 * step_rad, radius_m);
    (0..count).map(place).collect()
}

/// `arc_rad` of a circle, the leader in the middle, the others alternately to its right and left. The two ends never come closer
/// to each other than neighbours are: of a full circle one gap is left out.
pub(super) fn arc(count: usize, unit_m: f64, arc_rad: f64) -> Places {
    let step_rad = (arc_rad / (count.max(2) - 1) as f64).min(TAU / count as f64);
    if step_rad < STRAIGHT_RAD {
        return line(count, unit_m);
    }
    let radius_m = radius_for(step_rad, unit_m);
    let place = |i: usize| on_circle(alternating(i) * step_rad, radius_m);
    (0..count).map(place).collect()
}

/// Neighbours on an arc that see each other under less of it stand on a straight line as far as anybody can measure.
const STRAIGHT_RAD: f64 = 1e-7;

/// The radius on which places `step_rad` apart are one unit apart. A single one needs none.
fn radius_for(step_rad: f64, unit_m: f64) -> f64 {
    if step_rad < TAU {
        unit_m / (2.0 * (0.5 * step_rad.min(PI)).sin())
    } else {
        0.0
    }
}

/// The place `angle_rad` clockwise from the front, relative to the front.
fn on_circle(angle_rad: f64, radius_m: f64) -> Vector3<f64> {
    let half_sin = (0.5 * angle_rad).sin();
    // cos - 1 in the form that does not cancel on a large circle.
    level(0.0 - 2.0 * radius_m * half_sin * half_sin, radius_m * angle_rad.sin())
}

/// Evenly along the sides of a square that is as small as the corners allow; the leader in the middle of the front, the others
/// clockwise.
pub(super) fn square(count: usize, unit_m: f64) -> Places {
    let place = |i: usize| {
        let along = 4.0 * i as f64 / count as f64;
        if along < 0.5 {
            level(0.5, along)
        } else if along < 1.5 {
            level(1.0 - along, 0.5)
        } else if along < 2.5 {
            level(-0.5, 2.0 - along)
        } else if along < 3.5 {
            level(along - 3.0, -0.5)
        } else {
            level(0.5, along - 4.0)
        }
    };
    widened((0..count).map(place).collect(), unit_m)
}

/// Rows from front to back, each filled from its middle outwards; the leader in the middle of the first.
pub(super) fn grid(count: usize, unit_m: f64) -> Places {
    rows(count, side_for(count), unit_m)
}

fn rows(count: usize, columns: usize, unit_m: f64) -> Places {
    let columns = columns.max(1);
    let place = |i: usize| level(0.0 - (i / columns) as f64 * unit_m, alternating(i % columns) * unit_m);
    (0..count).map(place).collect()
}

/// The smallest number whose square is at least `count`.
fn side_for(count: usize) -> usize {
    let root = count.isqrt();
    if root * root < count { root + 1 } else { root }
}

/// Grids of the same columns one above the other, the lowest first and at most one fuller than the highest.
pub(super) fn solid_box(count: usize, unit_m: f64, layers: Option<u16>) -> Places {
    let wanted = layers.map_or_else(|| (count as f64).cbrt().round() as usize, usize::from);
    let layers = wanted.clamp(1, count.max(1));
    let columns = side_for(count.div_ceil(layers));
    let layer = |at: usize| {
        let members = count / layers + usize::from(at < count % layers);
        let up_m = at as f64 * VERTICAL_FACTOR * unit_m;
        rows(members, columns, unit_m)
            .into_iter()
            .map(move |place| Vector3::new(place.x, place.y, 0.0 - up_m))
    };
    (0..layers).flat_map(layer).collect()
}

/// A Fibonacci lattice on a sphere (González, *Measurement of areas on a sphere using Fibonacci and latitude-longitude lattices*,
/// 2010), as small as its closest two allow, with heights counted for less. Two or three stand level.
pub(super) fn sphere(count: usize, unit_m: f64) -> Places {
    if count < 4 {
        return circle(count, unit_m);
    }
    // The one nearest to the widest circle looks exactly forward: nobody is further in front.
    let foremost = (count - 1) / 2;
    let golden_rad = PI * (3.0 - 5.0_f64.sqrt());
    let place = |i: usize| {
        let up = (2 * i + 1) as f64 / count as f64 - 1.0;
        let (sin, cos) = (golden_rad * (i as f64 - foremost as f64)).sin_cos();
        let wide = (1.0 - up * up).sqrt();
        Vector3::new(wide * cos, wide * sin, 0.0 - up)
    };
    let order = std::iter::once(foremost).chain((0..count).filter(|i| *i != foremost));
    widened(order.map(place).collect(), unit_m)
}

/// A helix about the vertical with a whole number of places per turn, about as high as it is wide. Neighbours are one unit apart
/// (heights counted for less), so are places above each other if the pitch is at least [`VERTICAL_FACTOR`] units: of any other two
/// on neighbouring turns the horizontal distance is that of neighbours at least, and the vertical one not less.
pub(super) fn helix(count: usize, unit_m: f64, pitch_m: f64) -> Places {
    // As high as wide: count · unit = turns · circumference and turns · pitch = 2 · radius.
    let radius_m = (count as f64 * unit_m * pitch_m / (4.0 * PI)).sqrt();
    let fitting = (TAU * radius_m / unit_m).floor().clamp(LEAST_PER_TURN, MOST_PER_TURN);
    let rise_m = pitch_m / fitting;
    let chord2_m2 = unit_m * unit_m - (rise_m / VERTICAL_FACTOR).powi(2);
    // However steep it is, it stays a helix and does not become a pole.
    let chord_m = chord2_m2.max(0.25 * unit_m * unit_m).sqrt();
    let step_rad = TAU / fitting;
    let radius_m = radius_for(step_rad, chord_m);
    let place = |i: usize| {
        let turned = on_circle(i as f64 * step_rad, radius_m);
        Vector3::new(turned.x, turned.y, 0.0 - i as f64 * rise_m)
    };
    (0..count).map(place).collect()
}

/// Fewer places per turn look like a zigzag…
const LEAST_PER_TURN: f64 = 6.0;
/// …and more than there can be vehicles need not be told apart.
const MOST_PER_TURN: f64 = 1e6;

/// The same places with the closest two one unit apart, heights counted for less.
fn widened(places: Places, unit_m: f64) -> Places {
    let flat: Vec<_> = places.iter().map(|place| flattened(*place)).collect();
    let Some(pair) = closest_pair(&flat) else {
        return places.iter().map(|_| Vector3::zeros()).collect();
    };
    places
        .into_iter()
        .map(|place| place * (unit_m / pair.distance_m))
        .collect()
}
