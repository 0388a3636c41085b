//! The smallest distance between two members over a whole move, exact for straight ways and certified for detours.

use crate::time_law::{bump, bump_slope_between};
use nalgebra::Vector3;

/// How far a certified distance may be under the true one, in metres.
pub(super) const TOLERANCE_M: f64 = 1e-3;

/// Smallest length of `a + s·d` for s in 0..=1.
pub(super) fn straight_m(a: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
    let way2 = d.norm_squared();
    let s = if way2 > 0.0 {
        (-a.dot(d) / way2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + d * s).norm()
}

/// The same without the vertical part: no detour can make the distance smaller than this.
pub(super) fn horizontal_m(a: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
    straight_m(&Vector3::new(a.x, a.y, 0.0), &Vector3::new(d.x, d.y, 0.0))
}

/// Smallest length of `a + s·d` lifted by `lift_m` times the bump, never above the true one and under it by at most
/// [`TOLERANCE_M`]. Distances above `enough_m` need not be told apart: then anything from `enough_m` up is returned.
pub(super) fn lifted_m(a: &Vector3<f64>, d: &Vector3<f64>, lift_m: f64, enough_m: f64) -> f64 {
    if lift_m == 0.0 {
        return straight_m(a, d);
    }
    let distance = |s: f64| {
        let p = a + d * s;
        // The third axis points down.
        Vector3::new(p.x, p.y, p.z - lift_m * bump(s).value).norm()
    };
    let way_m = d.norm();
    let mut best_m = distance(0.0).min(distance(1.0));
    let mut open = Vec::with_capacity(32);
    open.push((0.0, distance(0.0), 1.0, distance(1.0)));
    while let Some((s0, d0, s1, d1)) = open.pop() {
        // Between two points the distance cannot fall faster than the relative motion goes.
        let slope = way_m + lift_m.abs() * bump_slope_between(s0, s1);
        let bound_m = 0.5 * (d0 + d1 - slope * (s1 - s0));
        // The width ends the search also for numbers so large that the bound never gets that close.
        if bound_m >= (best_m - TOLERANCE_M).min(enough_m) || s1 - s0 < MIN_WIDTH {
            continue;
        }
        let middle = 0.5 * (s0 + s1);
        let dm = distance(middle);
        best_m = best_m.min(dm);
        open.push((s0, d0, middle, dm));
        open.push((middle, dm, s1, d1));
    }
    best_m - TOLERANCE_M
}

/// Shares of the way finer than this are not looked into: over a kilometre it is less than a millimetre.
const MIN_WIDTH: f64 = 1e-7;
