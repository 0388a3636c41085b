//! Places from which a way bends about a corner: on polygons about the corner, a clearance away from it.

use std::f64::consts::{FRAC_PI_3, FRAC_PI_4, TAU};

/// A place in the plane: north and east in metres.
pub(super) type Point = [f64; 2];

/// Wall ends nearer than this to each other are one corner, in metres.
const SAME_M: f64 = 1e-6;
/// Places are so much further away than the clearance, in metres, that rounding does not bring them within it.
const SPARE_M: f64 = 1e-4;

/// The places about the corners of some walls of one zone, which are in order; what is free lies on the side of each wall to which
/// north turns to east.
pub(super) fn about(walls: &[[Point; 2]], clearance_m: f64) -> Vec<Point> {
    let mut places = Vec::new();
    let from_m = clearance_m + SPARE_M;
    for (index, wall) in walls.iter().enumerate() {
        let corner = wall[1];
        let next = walls
            .get(index + 1)
            .into_iter()
            .chain(walls.iter())
            .find(|next| is_same(next[0], corner));
        match next {
            Some(next) => bend(wall, next, from_m, &mut places),
            None => ring(corner, from_m, &mut places),
        }
        if !walls.iter().any(|previous| is_same(previous[1], wall[0])) {
            ring(wall[0], from_m, &mut places);
        }
    }
    places
}

fn is_same(a: Point, b: Point) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= SAME_M
}

/// About a corner that juts out into what is free: the corners of a polygon that encloses the arc about it.
fn bend(wall: &[Point; 2], next: &[Point; 2], from_m: f64, places: &mut Vec<Point>) {
    let (u, v) = (along(wall), along(next));
    let turn_rad = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
    if turn_rad >= 0.0 || !turn_rad.is_finite() {
        return;
    }
    let count = (-turn_rad / FRAC_PI_3).ceil().clamp(1.0, 3.0);
    let half_rad = 0.5 * turn_rad / count;
    let radius_m = from_m / half_rad.cos();
    let free_rad = u[0].atan2(-u[1]);
    for k in 0..count as u32 {
        let (sin, cos) = (free_rad + half_rad * f64::from(2 * k + 1)).sin_cos();
        places.push([wall[1][0] + radius_m * cos, wall[1][1] + radius_m * sin]);
    }
}

/// About the free end of a wall.
fn ring(end: Point, from_m: f64, places: &mut Vec<Point>) {
    let radius_m = from_m / (0.5 * FRAC_PI_4).cos();
    for k in 0..8 {
        let (sin, cos) = (TAU / 8.0 * f64::from(k)).sin_cos();
        places.push([end[0] + radius_m * cos, end[1] + radius_m * sin]);
    }
}

fn along(wall: &[Point; 2]) -> Point {
    [wall[1][0] - wall[0][0], wall[1][1] - wall[0][1]]
}
