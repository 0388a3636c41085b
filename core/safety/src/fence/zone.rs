//! One zone as a volume in the swarm's frame, and what it says of places and ways.

use super::plane::{distance_to_edge_m, edges, even_odd, nearest_on_edge, on_edge, touches_at};
use super::{Excess, Fence, ON_EDGE_M};
use skein_domain::{BreachAction, PositionNed, ZoneKind};

/// A part of a straight way: from which share of it to which, both 0..=1.
pub(super) type Share = [f64; 2];

/// A zone in the swarm's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    /// Name shown to people.
    pub name: String,
    /// To be stayed in or kept out of.
    pub kind: ZoneKind,
    /// What becomes of a vehicle that is where it must not be.
    pub action: BreachAction,
    /// The volume itself.
    pub volume: Fence,
}

impl Zone {
    /// How far inside an exclusion a place is: the least way out, part by part. All zero outside and on the boundary.
    pub(super) fn intrusion(&self, position: &PositionNed) -> Excess {
        let (volume, height_m) = (&self.volume, -position.down_m);
        let [to_floor_m, to_ceiling_m] = [height_m - volume.floor_m, volume.ceiling_m - height_m];
        if !(to_floor_m > ON_EDGE_M && to_ceiling_m > ON_EDGE_M) {
            return Excess::default();
        }
        let depth_m = volume.depth_m([position.north_m, position.east_m]);
        if depth_m <= ON_EDGE_M {
            return Excess::default();
        }
        let mut excess = Excess::default();
        if depth_m <= to_floor_m && depth_m <= to_ceiling_m {
            excess.outside_m = depth_m;
        } else if to_ceiling_m <= to_floor_m {
            excess.below_m = to_ceiling_m;
        } else {
            excess.above_m = to_floor_m;
        }
        excess
    }

    /// Whether a straight way goes through the inside of the volume (an exclusion's boundary may be flown along).
    pub(super) fn is_crossed(&self, from: &PositionNed, to: &PositionNed) -> bool {
        let length_m = from.distance_m(to);
        let parts = self.volume.shares_within(from, to);
        parts.iter().any(|[start, end]| (end - start) * length_m > ON_EDGE_M)
    }
}

impl Fence {
    /// Whether the box about a horizontal way reaches the box about the polygon.
    fn box_touches(&self, a: [f64; 2], b: [f64; 2], near_m: f64) -> bool {
        [0, 1].into_iter().all(|axis| {
            let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            low <= self.north_east[axis] + near_m && high >= self.south_west[axis] - near_m
        })
    }

    /// How far a place is inside the polygon; zero outside.
    pub(super) fn depth_m(&self, p: [f64; 2]) -> f64 {
        if !self.box_touches(p, p, 0.0) || !even_odd(&self.vertices, p) {
            return 0.0;
        }
        edges(&self.vertices)
            .map(|e| distance_to_edge_m(e, p))
            .fold(f64::INFINITY, f64::min)
    }

    /// The place on the outline that is nearest to another.
    pub(super) fn nearest_on_outline(&self, p: [f64; 2]) -> Option<[f64; 2]> {
        let off_m = |q: &[f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]);
        edges(&self.vertices)
            .map(|edge| nearest_on_edge(edge, p))
            .min_by(|a, b| off_m(a).total_cmp(&off_m(b)))
    }

    /// The parts of a straight way in the closed volume.
    pub(super) fn shares_inside(&self, from: &PositionNed, to: &PositionNed) -> Vec<Share> {
        let inside = |p| self.outside_m(p) <= 0.0;
        self.shares(from, to, ON_EDGE_M, inside)
    }

    /// The parts of a straight way in the volume without its boundary.
    pub(super) fn shares_within(&self, from: &PositionNed, to: &PositionNed) -> Vec<Share> {
        let within = |p| even_odd(&self.vertices, p) && !edges(&self.vertices).any(|edge| on_edge(edge, p, ON_EDGE_M));
        self.shares(from, to, -ON_EDGE_M, within)
    }

    fn shares(
        &self,
        from: &PositionNed,
        to: &PositionNed,
        grown_m: f64,
        holds: impl Fn([f64; 2]) -> bool,
    ) -> Vec<Share> {
        let (a, b) = ([from.north_m, from.east_m], [to.north_m, to.east_m]);
        let band = self.share_in_band(-from.down_m, -to.down_m, grown_m);
        let Some([first, last]) = band.filter(|_| self.box_touches(a, b, ON_EDGE_M)) else {
            return Vec::new();
        };
        let mut cuts: Vec<f64> = edges(&self.vertices)
            .flat_map(|e| touches_at(a, b, e))
            .filter(|share| *share > first && *share < last)
            .collect();
        cuts.extend([first, last]);
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2)
            .filter_map(|pair| {
                let part: Share = [*pair.first()?, *pair.get(1)?];
                let middle = 0.5 * (part[0] + part[1]);
                holds([a[0] + (b[0] - a[0]) * middle, a[1] + (b[1] - a[1]) * middle]).then_some(part)
            })
            .collect()
    }

    /// The part of a way between two heights in the band, which is made larger by `grown_m` on both sides.
    pub(super) fn share_in_band(&self, from_m: f64, to_m: f64, grown_m: f64) -> Option<Share> {
        share_between(from_m, to_m, self.floor_m - grown_m, self.ceiling_m + grown_m)
    }
}

/// Which part of the way from one height to another lies between a low and a high one.
pub(super) fn share_between(from_m: f64, to_m: f64, low_m: f64, high_m: f64) -> Option<Share> {
    let rise_m = to_m - from_m;
    if rise_m == 0.0 {
        return (low_m <= from_m && from_m <= high_m).then_some([0.0, 1.0]);
    }
    let (at_low, at_high) = ((low_m - from_m) / rise_m, (high_m - from_m) / rise_m);
    let (start, end) = (at_low.min(at_high).max(0.0), at_low.max(at_high).min(1.0));
    (start <= end).then_some([start, end])
}
