//! At which heights a way is looked for, and how it climbs and descends between them and its ends.

use super::corners::Point;
use super::{Task, WayAround};
use skein_domain::{PositionNed, ZoneKind};

/// Heights nearer than this to each other are one, in metres.
const SAME_HEIGHT_M: f64 = 0.01;
/// Over or under a zone there is so much more than the clearance, in metres.
const SPARE_M: f64 = 1e-3;
/// More heights than this are not tried; those that ask for the least climb are.
const MAX_HEIGHTS: usize = 12;
/// Halvings in the search for where a climb may end.
const HALVINGS: u32 = 7;

/// The heights that a way is flown at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Band {
    /// The lowest.
    pub(super) low_m: f64,
    /// The highest; if above the lowest, the height changes steadily from the start's to the goal's.
    pub(super) high_m: f64,
}

/// The heights to try, those with the shortest way first.
pub(super) fn bands(task: &Task) -> Vec<Band> {
    let (start_m, goal_m) = (-task.start.down_m, -task.goal.down_m);
    let mut heights = vec![start_m, goal_m];
    for zone in task.fences.zones().iter().filter(|z| z.kind == ZoneKind::Exclusion) {
        let spare_m = task.clearance.vertical_m + SPARE_M;
        heights.push(zone.volume.ceiling_m() + spare_m);
        heights.push(zone.volume.floor_m() - spare_m);
    }
    heights.retain(|height| height.is_finite());
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < SAME_HEIGHT_M);
    let mut bands: Vec<Band> = heights
        .into_iter()
        .map(|height_m| Band {
            low_m: height_m,
            high_m: height_m,
        })
        .collect();
    if (start_m - goal_m).abs() >= SAME_HEIGHT_M {
        bands.push(Band {
            low_m: start_m.min(goal_m),
            high_m: start_m.max(goal_m),
        });
    }
    bands.sort_by(|a, b| least_m(task, a).total_cmp(&least_m(task, b)));
    bands.truncate(MAX_HEIGHTS);
    bands
}

/// No way at these heights is shorter.
pub(super) fn least_m(task: &Task, band: &Band) -> f64 {
    let (start_m, goal_m) = (-task.start.down_m, -task.goal.down_m);
    let climbs_m = if band.high_m > band.low_m {
        (start_m - goal_m).abs()
    } else {
        (band.low_m - start_m).abs() + (band.low_m - goal_m).abs()
    };
    task.start.horizontal_distance_m(&task.goal).hypot(climbs_m)
}

/// The way along a path in the plane, if it can be flown at these heights.
pub(super) fn flown(task: &Task, band: &Band, path: &[Point]) -> Option<WayAround> {
    if band.high_m > band.low_m {
        return ramped(task, path);
    }
    let height_m = band.low_m;
    let [a, .., z] = path else { return None };
    let (b, y) = (path.get(1)?, path.get(path.len().checked_sub(2)?)?);
    let mut up = share_of_climb(task, &task.start, (*a, *b), height_m, task.start_share)?;
    let mut down = share_of_climb(task, &task.goal, (*z, *y), height_m, task.goal_share)?;
    if path.len() == 2 && up + down > 1.0 {
        (up, down) = (up / (up + down), down / (up + down));
    }
    let mut places = vec![(task.start, task.start_share)];
    let mut push = |place: PositionNed, share: f64| {
        if places
            .last()
            .is_none_or(|(last, _)| last.distance_m(&place) > SAME_HEIGHT_M)
        {
            places.push((place, share));
        }
    };
    let between = |from: &Point, to: &Point, share: f64| at(lerp(*from, *to, share), height_m);
    push(between(a, b, up), if up < 1.0 { task.start_share } else { 1.0 });
    for corner in path.iter().skip(1).take(path.len().saturating_sub(2)) {
        push(at(*corner, height_m), 1.0);
    }
    push(between(z, y, down), if down < 1.0 { task.goal_share } else { 1.0 });
    places.retain(|(place, _)| place.distance_m(&task.goal) > SAME_HEIGHT_M);
    places.push((task.goal, task.goal_share));
    task.way(&places)
}

/// How far along the first leg of a path (from either end) a climb from its end may go on: as far as it is clear.
fn share_of_climb(task: &Task, end: &PositionNed, leg: (Point, Point), height_m: f64, share: f64) -> Option<f64> {
    if (-end.down_m - height_m).abs() < SAME_HEIGHT_M {
        return Some(0.0);
    }
    let clear = |part: f64| task.is_clear(end, &at(lerp(leg.0, leg.1, part), height_m), share);
    if clear(1.0) {
        return Some(1.0);
    }
    if !clear(0.0) {
        return None;
    }
    let (mut good, mut bad) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if clear(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Some(good)
}

/// Steadily from the height of the start to that of the goal.
fn ramped(task: &Task, path: &[Point]) -> Option<WayAround> {
    let length = |legs: &[Point]| -> f64 {
        let pairs = legs.iter().zip(legs.iter().skip(1));
        pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
    };
    let total_m = length(path);
    let (start_m, goal_m) = (-task.start.down_m, -task.goal.down_m);
    let last = path.len().checked_sub(1)?;
    let place = |(index, corner): (usize, &Point)| {
        if index == 0 {
            return (task.start, task.start_share);
        }
        if index == last {
            return (task.goal, task.goal_share);
        }
        let done = if total_m > 0.0 {
            length(path.get(..=index).unwrap_or_default()) / total_m
        } else {
            1.0
        };
        (at(*corner, start_m + (goal_m - start_m) * done), 1.0)
    };
    let places: Vec<(PositionNed, f64)> = path.iter().enumerate().map(place).collect();
    task.way(&places)
}

fn lerp(a: Point, b: Point, share: f64) -> Point {
    [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]
}

fn at(p: Point, height_m: f64) -> PositionNed {
    PositionNed::new(p[0], p[1], -height_m)
}
