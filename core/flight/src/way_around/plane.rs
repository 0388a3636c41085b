//! The shortest way in the plane between two places, for the walls that stand at the heights it is flown at. It is looked for about
//! the zones in the way only: a shortest way for some of the zones that is clear of the others too is the shortest for all.

use super::corners::{Point, about};
use super::profile::Band;
use super::{MAX_PLACES, Task};
use pathfinding::prelude::astar;
use std::collections::BTreeSet;

/// Lengths are counted in micrometres, since the search wants whole numbers.
const UNITS_PER_M: f64 = 1e6;
/// What rounding may take from a clearance, in metres.
const ROUNDING_M: f64 = 1e-6;

/// There are too many places to be looked at.
pub(super) struct GaveUp;

/// A wall at these heights, and its zone.
struct Obstacle {
    ends: [Point; 2],
    zone: usize,
}

/// The shortest way, start and goal included, if there is one.
pub(super) fn shortest(task: &Task, band: &Band) -> Result<Option<Vec<Point>>, GaveUp> {
    let grown_m = task.clearance.vertical_m - ROUNDING_M;
    let all: Vec<Obstacle> = task
        .fences
        .walls()
        .iter()
        .filter(|wall| wall.floor_m - grown_m <= band.high_m && wall.ceiling_m + grown_m >= band.low_m)
        .map(|wall| Obstacle {
            ends: wall.ends_m,
            zone: wall.zone,
        })
        .collect();
    let mut met: BTreeSet<usize> = BTreeSet::new();
    loop {
        let (walls, others): (Vec<&Obstacle>, Vec<&Obstacle>) = all.iter().partition(|wall| met.contains(&wall.zone));
        let search = Search::new(task, &met, walls)?;
        let Some(path) = search.run() else { return Ok(None) };
        let mut found: BTreeSet<usize> = BTreeSet::new();
        for (leg, pair) in path.windows(2).enumerate() {
            let &[a, b] = pair else { continue };
            let share = leg_share(task, leg == 0, leg + 2 == path.len());
            let line = Leg::new(a, b, task.clearance.horizontal_m * share);
            found.extend(others.iter().filter(|wall| line.meets(wall.ends)).map(|wall| wall.zone));
        }
        if found.is_empty() {
            return Ok(Some(path));
        }
        met.extend(found);
    }
}

fn leg_share(task: &Task, from_start: bool, to_goal: bool) -> f64 {
    let start = if from_start { task.start_share } else { 1.0 };
    let goal = if to_goal { task.goal_share } else { 1.0 };
    start.min(goal)
}

struct Search<'a> {
    task: &'a Task<'a>,
    walls: Vec<&'a Obstacle>,
    /// Start, goal, and the places about corners.
    places: Vec<Point>,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task<'a>, zones: &BTreeSet<usize>, walls: Vec<&'a Obstacle>) -> Result<Self, GaveUp> {
        let clearance_m = task.clearance.horizontal_m;
        let mut places = vec![
            [task.start.north_m, task.start.east_m],
            [task.goal.north_m, task.goal.east_m],
        ];
        for zone in zones {
            let of_zone: Vec<[Point; 2]> = walls.iter().filter(|w| w.zone == *zone).map(|w| w.ends).collect();
            let clear = |place: &Point| {
                let stand = Leg::new(*place, *place, clearance_m);
                !walls.iter().any(|wall| stand.meets(wall.ends))
            };
            places.extend(about(&of_zone, clearance_m).into_iter().filter(clear));
            if places.len() > MAX_PLACES {
                return Err(GaveUp);
            }
        }
        Ok(Self { task, walls, places })
    }

    fn run(&self) -> Option<Vec<Point>> {
        let goal = self.places.get(1).copied()?;
        let remaining = |from: &usize| self.places.get(*from).map_or(0, |p| units(*p, goal));
        let (path, _) = astar(&0, |from| self.legs_from(*from), remaining, |place| *place == 1)?;
        path.iter().map(|index| self.places.get(*index).copied()).collect()
    }

    fn legs_from(&self, from: usize) -> Vec<(usize, u64)> {
        let Some(&a) = self.places.get(from) else {
            return Vec::new();
        };
        let leg = |(to, b): (usize, &Point)| {
            if to == from || to == 0 {
                return None;
            }
            let share = leg_share(self.task, from == 0, to == 1);
            let line = Leg::new(a, *b, self.task.clearance.horizontal_m * share);
            let clear = !self.walls.iter().any(|wall| line.meets(wall.ends));
            clear.then(|| (to, units(a, *b)))
        };
        self.places.iter().enumerate().filter_map(leg).collect()
    }
}

fn units(a: Point, b: Point) -> u64 {
    // Rounded down, so that the straight distance never overestimates; a negative or odd number becomes zero.
    ((a[0] - b[0]).hypot(a[1] - b[1]) * UNITS_PER_M).floor() as u64
}

/// A straight leg that must keep a distance.
struct Leg {
    from: Point,
    direction: Point,
    length_m: f64,
    distance_m: f64,
}

impl Leg {
    fn new(from: Point, to: Point, distance_m: f64) -> Self {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length_m = way[0].hypot(way[1]);
        let direction = if length_m > 0.0 {
            [way[0] / length_m, way[1] / length_m]
        } else {
            [1.0, 0.0]
        };
        Self {
            from,
            direction,
            length_m,
            distance_m: (distance_m - ROUNDING_M).max(0.0),
        }
    }

    /// A place as how far along the leg and how far beside it.
    fn seen(&self, p: Point) -> Point {
        let to = [p[0] - self.from[0], p[1] - self.from[1]];
        let [u, v] = self.direction;
        [to[0] * u + to[1] * v, to[1] * u - to[0] * v]
    }

    /// Whether a wall comes nearer than the distance.
    fn meets(&self, wall: [Point; 2]) -> bool {
        let [a, b] = wall.map(|end| self.seen(end));
        let d = self.distance_m;
        // Beside, behind or beyond: by far the most.
        if a[1].min(b[1]) >= d || a[1].max(b[1]) <= -d || a[0].max(b[0]) <= -d || a[0].min(b[0]) >= self.length_m + d {
            return false;
        }
        if crosses(a, b, self.length_m) {
            return true;
        }
        let to_leg = |p: Point| (p[0] - p[0].clamp(0.0, self.length_m)).hypot(p[1]);
        let to_wall = |p: Point| distance_m([a, b], p);
        let least_m = to_leg(a)
            .min(to_leg(b))
            .min(to_wall([0.0, 0.0]))
            .min(to_wall([self.length_m, 0.0]));
        least_m < d
    }
}

/// Whether a wall, seen from a leg, goes through it: not only up to it.
fn crosses(a: Point, b: Point, length_m: f64) -> bool {
    if a[1] * b[1] >= 0.0 {
        return false;
    }
    let along_m = a[0] + (b[0] - a[0]) * (a[1] / (a[1] - b[1]));
    ROUNDING_M < along_m && along_m < length_m - ROUNDING_M
}

fn distance_m(wall: [Point; 2], p: Point) -> f64 {
    let [a, b] = wall;
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length2 = along[0] * along[0] + along[1] * along[1];
    let share = if length2 > 0.0 {
        ((to[0] * along[0] + to[1] * along[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (to[0] - along[0] * share).hypot(to[1] - along[1] * share)
}
