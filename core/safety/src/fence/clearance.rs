//! Ways that keep a distance from the boundary: for planning, where being inside by a millimetre is not enough.

use super::ON_EDGE_M;
use super::fences::Fences;
use super::plane::edges_distance_m;
use super::zone::{Zone, share_between};
use skein_domain::{PositionNed, Refusal, ZoneKind};

/// How far to keep from boundaries: beside walls, and over or under whatever has a top or a bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// From walls, in metres.
    pub horizontal_m: f64,
    /// From floors and ceilings, in metres.
    pub vertical_m: f64,
}

impl Clearance {
    /// Both scaled.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            horizontal_m: self.horizontal_m * factor,
            vertical_m: self.vertical_m * factor,
        }
    }
}

impl Fences {
    /// Whether the straight way between two places is inside and keeps the clearance: at each of its heights that is within
    /// `vertical_m` of a wall's band it is at least `horizontal_m` away from that wall, it is not less than `vertical_m` over or under an
    /// exclusion, and it stays inside when it is raised or lowered by `vertical_m`.
    ///
    /// # Errors
    /// As [`Fences::contains`]; the zone that is too near is named.
    pub fn keeps_clearance(&self, from: &PositionNed, to: &PositionNed, clearance: &Clearance) -> Result<(), Refusal> {
        self.contains_way(from, to)?;
        for shift_m in [clearance.vertical_m, -clearance.vertical_m] {
            let shifted = |p: &PositionNed| PositionNed {
                down_m: p.down_m - shift_m,
                ..*p
            };
            if shift_m != 0.0 && !self.stays_in_inclusions(&shifted(from), &shifted(to)) {
                return Err(Refusal::OutsideFence {
                    detail: format!(
                        "less than {:.1} m under a ceiling or over a floor",
                        clearance.vertical_m
                    ),
                });
            }
        }
        self.too_near(from, to, clearance)
            .map_or(Ok(()), |zone| Err(nearer_than(zone, clearance)))
    }

    /// The first zone in the list of walls that a way comes too near to, its inclusions' floors and ceilings left aside.
    #[must_use]
    pub fn too_near(&self, from: &PositionNed, to: &PositionNed, clearance: &Clearance) -> Option<&Zone> {
        let (a, b) = ([from.north_m, from.east_m], [to.north_m, to.east_m]);
        let (h0, h1) = (-from.down_m, -to.down_m);
        let at = |share: f64| [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share];
        let grown_m = clearance.vertical_m - ON_EDGE_M;
        let least_m = clearance.horizontal_m - ON_EDGE_M;
        let over_or_under = self.of_kind(ZoneKind::Exclusion).find(|zone| {
            let volume = &zone.volume;
            let part = volume.share_in_band(h0, h1, grown_m);
            part.is_some_and(|[start, _]| volume.depth_m(at(start)) > ON_EDGE_M)
        });
        if over_or_under.is_some() {
            return over_or_under;
        }
        let wall = self.walls.iter().find(|wall| {
            let part = share_between(h0, h1, wall.floor_m - grown_m, wall.ceiling_m + grown_m);
            part.is_some_and(|[start, end]| {
                let way = [at(start), at(end)];
                boxes_near(way, wall.ends_m, least_m) && edges_distance_m(way, wall.ends_m) < least_m
            })
        });
        wall.and_then(|wall| self.zones.get(wall.zone))
    }
}

fn boxes_near(e: [[f64; 2]; 2], f: [[f64; 2]; 2], near_m: f64) -> bool {
    (0..2).all(|axis| {
        let span = |edge: [[f64; 2]; 2]| {
            let [x, y] = edge.map(|p| p.get(axis).copied().unwrap_or(f64::NAN));
            (x.min(y), x.max(y))
        };
        let ((e_low, e_high), (f_low, f_high)) = (span(e), span(f));
        e_low <= f_high + near_m && f_low <= e_high + near_m
    })
}

fn nearer_than(zone: &Zone, clearance: &Clearance) -> Refusal {
    Refusal::OutsideFence {
        detail: format!(
            "\"{}\": nearer than {:.1} m, or {:.1} m in height",
            zone.name, clearance.horizontal_m, clearance.vertical_m
        ),
    }
}
