//! What the boxes of a track say of size, shape and motion.

use super::Light;
use skein_vision::Bounds;

/// How many numbers that are.
pub(super) const NUMBERS: usize = 8;

/// Of boxes at moments that are equally far apart, the oldest first.
pub(super) fn numbers(bounds: &[Bounds], light: Light) -> [f32; NUMBERS] {
    // A pixel of the larger picture is half as large.
    let (pixel, camera) = match light {
        Light::Infrared => (1.0, -0.5),
        Light::Visible => (0.5, 0.5),
    };
    let count = bounds.len().max(1) as f64;
    let mean = |of: &dyn Fn(usize) -> f64| (0..bounds.len()).map(of).sum::<f64>() / count;
    let spread = |of: &dyn Fn(usize) -> f64| {
        let middle = mean(of);
        mean(&|at| (of(at) - middle).powi(2)).sqrt()
    };
    let size = |at: usize| bounds[at].width_px.max(bounds[at].height_px);
    let log_size = |at: usize| (size(at) * pixel).ln();
    let log_aspect = |at: usize| (bounds[at].width_px / bounds[at].height_px).ln();
    let moment = |at: usize| at as f64 - (count - 1.0) / 2.0;
    let squares: f64 = (0..bounds.len()).map(|at| moment(at).powi(2)).sum();
    let (x, y) = (|at: usize| bounds[at].center_x_px, |at: usize| bounds[at].center_y_px);
    // The straight line through the middles, and what is left beside it, both in sizes.
    let slope = |of: &dyn Fn(usize) -> f64| mean(&|at| of(at) * moment(at)) * count / squares;
    let (slope_x, slope_y) = (slope(&x), slope(&y));
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let beside = mean(&|at| {
        let off = (
            x(at) - mean_x - slope_x * moment(at),
            y(at) - mean_y - slope_y * moment(at),
        );
        off.0.powi(2) + off.1.powi(2)
    });
    let mean_size = mean(&size);
    let way = |slope: f64| slope * (count - 1.0) / mean_size;
    let length = way(slope_x).hypot(way(slope_y));
    [
        mean(&log_size) - 3.0,
        2.0 * mean(&log_aspect),
        5.0 * spread(&log_aspect),
        5.0 * spread(&log_size),
        camera,
        (length + 0.1).ln() + 0.5,
        (beside.sqrt() / mean_size + 0.05).ln() + 2.0,
        2.0 * way(slope_x).abs() / (length + 0.1) - 1.0,
    ]
    .map(|number| number as f32)
}
