//! A square of the picture around a box, in cells of one size however large the box is.

use skein_vision::{Bounds, Gray};

/// Cells along a side.
pub(super) const CELLS: usize = 32;
/// Side of the window in longer sides of the box.
const SIDES: f64 = 1.2;
/// Grey levels that count as 1, at least.
const LOWEST_CONTRAST: f32 = 6.0;
/// Nothing counts as more.
const HIGHEST: f32 = 1.5;
/// More points than this along a side are not looked at for one cell.
const MOST_FINE: usize = 32;

/// Grey levels, row by row.
pub(super) type Window = Vec<f32>;

/// Pixels before and after a point along an axis, and the share of the one after.
struct Point {
    before: usize,
    after: usize,
    share: f32,
}

/// Points along one axis. The middle of pixel i is at i + 0.5; outside of the picture its outermost pixel goes on.
fn points(low: f64, side: f64, count: usize, length: usize) -> Vec<Point> {
    let inside = |pixel: f64| pixel.clamp(0.0, length.saturating_sub(1) as f64) as usize;
    let points = (0..count).map(|index| {
        let at = low + (index as f64 + 0.5) * (side / count as f64) - 0.5;
        Point {
            before: inside(at.floor()),
            after: inside(at.floor() + 1.0),
            share: (at - at.floor()) as f32,
        }
    });
    points.collect()
}

/// The window around a box: bilinear, and where a cell is larger than a pixel the mean of several points.
pub(super) fn around(picture: &Gray, bounds: &Bounds) -> Window {
    let side = SIDES * bounds.width_px.max(bounds.height_px);
    let fine = ((side / CELLS as f64).ceil() as usize).clamp(1, MOST_FINE);
    let count = CELLS * fine;
    let columns = points(bounds.center_x_px - side / 2.0, side, count, picture.width());
    let rows = points(bounds.center_y_px - side / 2.0, side, count, picture.height());
    let mut cells = vec![0.0; CELLS * CELLS];
    for (index, row) in rows.iter().enumerate() {
        let (upper, lower) = (picture.row(row.before), picture.row(row.after));
        let between = |column: usize| {
            let (above, below) = (f32::from(upper[column]), f32::from(lower[column]));
            above + (below - above) * row.share
        };
        let start = index / fine * CELLS;
        for (index, column) in columns.iter().enumerate() {
            let (left, right) = (between(column.before), between(column.after));
            cells[start + index / fine] += left + (right - left) * column.share;
        }
    }
    let points = (fine * fine) as f32;
    cells.iter_mut().for_each(|cell| *cell /= points);
    cells
}

/// Windows of all moments with the background at 0 and the thing's strongest cell at about 1. The scale is one for all, so that a change of contrast
/// stays.
pub(super) fn normalised(windows: &[&Window]) -> Vec<f32> {
    let mut flat = Vec::with_capacity(windows.len() * CELLS * CELLS);
    let mut peaks = 0.0;
    for window in windows {
        let background = rim_median(window);
        let quarter = CELLS / 4;
        let middle = quarter..CELLS - quarter;
        let inner = middle
            .clone()
            .flat_map(|row| middle.clone().map(move |column| row * CELLS + column));
        peaks += inner.map(|at| (window[at] - background).abs()).fold(0.0, f32::max);
        flat.extend(window.iter().map(|cell| cell - background));
    }
    let scale = (peaks / windows.len().max(1) as f32).max(LOWEST_CONTRAST);
    flat.iter_mut()
        .for_each(|cell| *cell = (*cell / scale).clamp(-HIGHEST, HIGHEST));
    flat
}

/// The lower median of the two outermost rings.
fn rim_median(window: &Window) -> f32 {
    let is_rim = |at: &usize| {
        let inner = 2..CELLS - 2;
        !(inner.contains(&(at / CELLS)) && inner.contains(&(at % CELLS)))
    };
    let mut rim: Vec<f32> = (0..CELLS * CELLS).filter(is_rim).map(|at| window[at]).collect();
    rim.sort_by(f32::total_cmp);
    rim.get((rim.len() - 1) / 2).copied().unwrap_or(0.0)
}
