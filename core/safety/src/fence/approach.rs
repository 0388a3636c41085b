//! How fast a boundary may be approached, so that who brakes in time stops in front of it.

use super::fences::Fences;
use super::plane::{edges, nearest_on_edge};
use super::walls::Wall;
use super::zone::Zone;
use super::{Excess, ON_EDGE_M};
use crate::half_space::HalfSpace;
use nalgebra::Vector3;
use skein_domain::{PositionNed, ZoneKind};

/// Nearer than this to a wall, the direction to it is taken from the wall itself, in metres.
const TOUCHING_M: f64 = 1e-9;
/// Directions whose cosine is above this are one.
const SAME_DIRECTION: f64 = 1.0 - 1e-9;

/// How a vehicle stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// No speed above this is of interest, in metres per second: boundaries that do not limit it are left out.
    pub max_speed_m_s: f64,
    /// How strongly the vehicle brakes, in metres per second squared.
    pub braking_m_s2: f64,
    /// For so long it goes on at its speed before it brakes, in seconds.
    pub reaction_s: f64,
    /// It is to stand so far in front of a boundary, in metres.
    pub margin_m: f64,
}

impl Approach {
    /// The speed from which a vehicle stops within a distance in metres, less the margin: `v·reaction + v²/2b = distance`. Zero without
    /// a usable braking.
    #[must_use]
    pub fn speed_m_s(&self, distance_m: f64) -> f64 {
        let (b, delay_s) = (self.braking_m_s2, self.reaction_s.max(0.0));
        let distance_m = distance_m - self.margin_m.max(0.0);
        if !(b > 0.0 && b.is_finite() && delay_s.is_finite() && distance_m > 0.0) {
            return 0.0;
        }
        let coasted_m_s = b * delay_s;
        // Written so that little is not taken from much.
        let root = (coasted_m_s * coasted_m_s + 2.0 * b * distance_m).sqrt();
        2.0 * b * distance_m / (root + coasted_m_s)
    }

    /// How far a vehicle goes before it stands, in metres.
    #[must_use]
    pub fn stopping_m(&self, speed_m_s: f64) -> f64 {
        let coasted_m = speed_m_s * self.reaction_s.max(0.0);
        if self.braking_m_s2 > 0.0 {
            coasted_m + 0.5 * speed_m_s * speed_m_s / self.braking_m_s2
        } else {
            f64::INFINITY
        }
    }
}

impl Fences {
    /// What the fences ask of a velocity at a place: towards each part of the boundary no more than lets the vehicle stop in front of
    /// it. The velocity along the boundary stays free, so that a filter which keeps these bounds lets a vehicle slide along it. All of
    /// them hold for standing still. Who is outside may come back or stay, and gets no limit that keeps it from coming back.
    ///
    /// A vehicle whose velocity keeps them at all times does not cross the boundary: its distance to every wall then falls no faster
    /// than a deceleration of `braking_m_s2` lets it end at zero. It has to be able to decelerate that much across the wall.
    #[must_use]
    pub fn velocity_limits(&self, position: &PositionNed, approach: &Approach) -> Vec<HalfSpace> {
        let mut limits = Limits {
            approach,
            found: Vec::new(),
        };
        if self.is_empty() {
            return limits.found;
        }
        if !position.is_finite() {
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                limits.push(axis, 0.0);
                limits.push(-axis, 0.0);
            }
            return limits.found;
        }
        let outside = self.out_of_inclusions(position, true);
        if let Some((zone, excess)) = &outside {
            limits.towards_zone(zone, excess, position);
        }
        let entered: Vec<bool> = self
            .zones
            .iter()
            .map(|zone| zone.kind == ZoneKind::Exclusion && limits.out_of_exclusion(zone, position))
            .collect();
        for wall in &self.walls {
            let is_inclusion = self.zones.get(wall.zone).is_some_and(|z| z.kind == ZoneKind::Inclusion);
            let passes = if is_inclusion {
                outside.is_some()
            } else {
                entered.get(wall.zone).copied().unwrap_or(false)
            };
            if !passes {
                limits.wall(wall, position);
            }
        }
        for (zone, entered) in self.zones.iter().zip(entered) {
            match zone.kind {
                ZoneKind::Inclusion if outside.is_none() => self.lid_and_floor(zone, position, &mut limits),
                ZoneKind::Exclusion if !entered => limits.over_or_under(zone, position),
                _ => {}
            }
        }
        limits.found
    }

    /// The ceiling and the floor of an inclusion that a place is in, where no other inclusion goes on behind them.
    fn lid_and_floor(&self, zone: &Zone, position: &PositionNed, limits: &mut Limits) {
        let volume = &zone.volume;
        if !volume.excess(position).is_inside() {
            return;
        }
        let goes_on = |height_m: f64| {
            let place = PositionNed {
                down_m: -height_m,
                ..*position
            };
            let mut inclusions = self.of_kind(ZoneKind::Inclusion);
            inclusions.any(|other| !std::ptr::eq(other, zone) && other.volume.excess(&place).is_inside())
        };
        let height_m = -position.down_m;
        if volume.ceiling_m.is_finite() && !goes_on(volume.ceiling_m + 10.0 * ON_EDGE_M) {
            limits.push(-Vector3::z(), volume.ceiling_m - height_m);
        }
        if volume.floor_m.is_finite() && !goes_on(volume.floor_m - 10.0 * ON_EDGE_M) {
            limits.push(Vector3::z(), height_m - volume.floor_m);
        }
    }
}

struct Limits<'a> {
    approach: &'a Approach,
    found: Vec<HalfSpace>,
}

impl Limits<'_> {
    /// A bound along a direction by the distance to the boundary there.
    fn push(&mut self, normal: Vector3<f64>, distance_m: f64) {
        let limit_m_s = self.approach.speed_m_s(distance_m);
        if limit_m_s >= self.approach.max_speed_m_s {
            return;
        }
        let same = |known: &&mut HalfSpace| known.normal.dot(&normal) > SAME_DIRECTION;
        if let Some(known) = self.found.iter_mut().find(same) {
            known.limit_m_s = known.limit_m_s.min(limit_m_s);
        } else {
            self.found.push(HalfSpace { normal, limit_m_s });
        }
    }

    /// Along the way to a place, given as a vector from here; `otherwise` if it is here.
    fn push_to(&mut self, to_m: Vector3<f64>, otherwise: Vector3<f64>) {
        let distance_m = to_m.norm();
        if distance_m > TOUCHING_M {
            self.push(to_m / distance_m, distance_m);
        } else {
            self.push(otherwise, 0.0);
        }
    }

    fn wall(&mut self, wall: &Wall, position: &PositionNed) {
        let nearest = nearest_on_edge(wall.ends_m, [position.north_m, position.east_m]);
        let height_m = -position.down_m;
        let up_m = height_m.clamp(wall.floor_m, wall.ceiling_m) - height_m;
        let to_m = Vector3::new(nearest[0] - position.north_m, nearest[1] - position.east_m, -up_m);
        self.push_to(to_m, wall.outwards());
    }

    /// Back towards an inclusion that was left: no part of the excess may grow, and no other part of it be begun.
    fn towards_zone(&mut self, zone: &Zone, excess: &Excess, position: &PositionNed) {
        let (volume, p) = (&zone.volume, [position.north_m, position.east_m]);
        let height_m = -position.down_m;
        if excess.outside_m > 0.0 {
            if let Some(nearest) = volume.nearest_on_outline(p) {
                let away = Vector3::new(p[0] - nearest[0], p[1] - nearest[1], 0.0);
                if away.norm() > TOUCHING_M {
                    self.push(away.normalize(), 0.0);
                }
            }
        } else {
            for edge in edges(&volume.vertices) {
                let nearest = nearest_on_edge(edge, p);
                let to_m = Vector3::new(nearest[0] - p[0], nearest[1] - p[1], 0.0);
                if to_m.norm() > TOUCHING_M {
                    self.push(to_m.normalize(), to_m.norm());
                }
            }
        }
        if volume.ceiling_m.is_finite() {
            self.push(-Vector3::z(), (volume.ceiling_m - height_m).max(0.0));
        }
        if volume.floor_m.is_finite() {
            self.push(Vector3::z(), (height_m - volume.floor_m).max(0.0));
        }
    }

    /// Out of an exclusion that a place is in: not deeper. Whether the place is in it at all.
    fn out_of_exclusion(&mut self, zone: &Zone, position: &PositionNed) -> bool {
        let excess = zone.intrusion(position);
        if excess.above_m > 0.0 {
            self.push(-Vector3::z(), 0.0);
        } else if excess.below_m > 0.0 {
            self.push(Vector3::z(), 0.0);
        } else if excess.outside_m > 0.0 {
            let p = [position.north_m, position.east_m];
            if let Some(nearest) = zone.volume.nearest_on_outline(p) {
                let deeper = Vector3::new(p[0] - nearest[0], p[1] - nearest[1], 0.0);
                self.push(deeper.normalize(), 0.0);
            }
        }
        !excess.is_inside()
    }

    /// The upper and the lower side of an exclusion that a place is over or under.
    fn over_or_under(&mut self, zone: &Zone, position: &PositionNed) {
        let (volume, height_m) = (&zone.volume, -position.down_m);
        let over_m = height_m - volume.ceiling_m;
        let under_m = volume.floor_m - height_m;
        if over_m.max(under_m) < -ON_EDGE_M || volume.depth_m([position.north_m, position.east_m]) <= 0.0 {
            return;
        }
        if over_m >= -ON_EDGE_M {
            self.push(Vector3::z(), over_m);
        } else {
            self.push(-Vector3::z(), under_m);
        }
    }
}

#[cfg(test)]
mod tests;
