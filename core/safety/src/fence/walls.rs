//! The boundary of what is allowed as upright rectangles: outlines of exclusions, and those parts of outlines of inclusions that
//! lie in no other inclusion.

use super::plane::{edges, signed_area, touches_at};
use super::zone::Zone;
use super::{Fence, ON_EDGE_M};
use nalgebra::Vector3;
use skein_domain::ZoneKind;

/// How far beyond an edge is looked whether another inclusion goes on there.
const BEYOND_M: f64 = 10.0 * ON_EDGE_M;

/// An upright rectangle over a straight line on the ground. Who looks from its first end to its second has what is allowed on the
/// side on which a turn from north to east goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Its ends as `[north_m, east_m]`.
    pub ends_m: [[f64; 2]; 2],
    /// Height of its lower edge in metres.
    pub floor_m: f64,
    /// Height of its upper edge in metres.
    pub ceiling_m: f64,
    /// The zone it belongs to, as its place in the list of zones.
    pub zone: usize,
}

impl Wall {
    /// The horizontal direction out of what is allowed, of length one.
    #[must_use]
    pub fn outwards(&self) -> Vector3<f64> {
        let [a, b] = self.ends_m;
        let out = Vector3::new(b[1] - a[1], a[0] - b[0], 0.0);
        out.try_normalize(0.0).unwrap_or_else(Vector3::x)
    }
}

/// The walls of all zones.
pub(super) fn of(zones: &[Zone]) -> Vec<Wall> {
    let mut walls = Vec::new();
    for (index, zone) in zones.iter().enumerate() {
        let volume = &zone.volume;
        // Corners turn from north to east about what they enclose if the area is above zero.
        let free_inside = zone.kind == ZoneKind::Inclusion;
        let turned = (signed_area(&volume.vertices) > 0.0) != free_inside;
        let others: Vec<&Fence> = zones
            .iter()
            .enumerate()
            .filter(|(i, other)| free_inside && *i != index && other.kind == ZoneKind::Inclusion)
            .map(|(_, other)| &other.volume)
            .collect();
        let mut of_zone: Vec<Wall> = Vec::new();
        for [a, b] in edges(&volume.vertices) {
            let wall = Wall {
                ends_m: if turned { [b, a] } else { [a, b] },
                floor_m: volume.floor_m,
                ceiling_m: volume.ceiling_m,
                zone: index,
            };
            if others.is_empty() {
                of_zone.push(wall);
            } else {
                of_zone.extend(uncovered(&wall, &others));
            }
        }
        if turned {
            of_zone.reverse();
        }
        walls.extend(of_zone);
    }
    walls
}

/// The parts of a wall behind which no other inclusion goes on.
fn uncovered(wall: &Wall, others: &[&Fence]) -> Vec<Wall> {
    let [a, b] = wall.ends_m;
    let along = [b[0] - a[0], b[1] - a[1]];
    let length_m = along[0].hypot(along[1]);
    let at = |share: f64| [a[0] + along[0] * share, a[1] + along[1] * share];
    let mut cuts: Vec<f64> = others
        .iter()
        .flat_map(|other| edges(&other.vertices))
        .flat_map(|edge| touches_at(a, b, edge))
        .collect();
    cuts.extend([0.0, 1.0]);
    cuts.sort_by(f64::total_cmp);
    let mut parts = Vec::new();
    for pair in cuts.windows(2) {
        let &[start, end] = pair else { continue };
        if (end - start) * length_m <= ON_EDGE_M {
            continue;
        }
        let middle = at(0.5 * (start + end));
        let beyond = [
            middle[0] + along[1] / length_m * BEYOND_M,
            middle[1] - along[0] / length_m * BEYOND_M,
        ];
        let mut bands: Vec<[f64; 2]> = others
            .iter()
            .filter(|other| other.outside_m(beyond) <= 0.0)
            .map(|other| [other.floor_m, other.ceiling_m])
            .collect();
        bands.sort_by(|x, y| x[0].total_cmp(&y[0]));
        let mut floor_m = wall.floor_m;
        bands.push([wall.ceiling_m; 2]);
        for [low_m, high_m] in bands {
            let ceiling_m = low_m.min(wall.ceiling_m);
            if ceiling_m - floor_m > ON_EDGE_M {
                parts.push(Wall {
                    ends_m: [at(start), at(end)],
                    floor_m,
                    ceiling_m,
                    ..*wall
                });
            }
            floor_m = floor_m.max(high_m);
        }
    }
    parts
}
