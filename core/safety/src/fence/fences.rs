//! All zones together: where a vehicle may be, which way it may go, and which zone it breaks.

use super::walls::{self, Wall};
use super::zone::{Share, Zone};
use super::{Excess, Fence};
use skein_domain::{BreachAction, PositionNed, Refusal, ZoneKind};

/// A gap between two inclusions that a way may have, in metres: what rounding makes.
const GAP_M: f64 = 1e-5;
/// At so many places of a way it is looked whether somebody who is outside gets no worse.
const LOOKS: u32 = 8;
/// An exclusion that begins so little above a landing spot keeps vehicles from landing there.
const LANDING_COLUMN_M: f64 = 20.0;

/// The zones of a swarm. Inside is what lies in at least one inclusion (everywhere, if there is none) and in no exclusion. The
/// boundaries of both belong to the inside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fences {
    pub(super) zones: Vec<Zone>,
    pub(super) walls: Vec<Wall>,
}

/// A place where a vehicle must not be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breach<'a> {
    /// The zone that was left, or entered; of several inclusions the nearest.
    pub zone: &'a Zone,
    /// What becomes of the vehicle.
    pub action: BreachAction,
    /// How far it has to go to be where it may: horizontally, down or up.
    pub excess: Excess,
}

impl From<Option<Fence>> for Fences {
    /// One inclusion named "fence", or none; who leaves it holds.
    fn from(fence: Option<Fence>) -> Self {
        let zone = |volume| Zone {
            name: "fence".to_owned(),
            kind: ZoneKind::Inclusion,
            action: BreachAction::Hold,
            volume,
        };
        Self::new(fence.into_iter().map(zone).collect())
    }
}

impl From<Fence> for Fences {
    fn from(fence: Fence) -> Self {
        Some(fence).into()
    }
}

impl Fences {
    /// Of these zones.
    #[must_use]
    pub fn new(zones: Vec<Zone>) -> Self {
        let walls = walls::of(&zones);
        Self { zones, walls }
    }

    /// The zones.
    #[must_use]
    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Whether there is no zone at all, so that everywhere is inside.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.zones.is_empty()
    }

    /// The upright part of the boundary.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    pub(super) fn of_kind(&self, kind: ZoneKind) -> impl Iterator<Item = &Zone> {
        self.zones.iter().filter(move |zone| zone.kind == kind)
    }

    /// Nearest inclusion and how far outside of it the place is, if it is in none though there are some. On the ground floors do
    /// not count.
    pub(super) fn out_of_inclusions(&self, position: &PositionNed, airborne: bool) -> Option<(&Zone, Excess)> {
        let mut nearest: Option<(&Zone, Excess)> = None;
        for zone in self.of_kind(ZoneKind::Inclusion) {
            let excess = zone.volume.excess_standing(position, airborne);
            if excess.is_inside() {
                return None;
            }
            if nearest.is_none_or(|(_, so_far)| excess.distance_m() < so_far.distance_m()) {
                nearest = Some((zone, excess));
            }
        }
        nearest
    }

    /// Every zone that is broken at a place: the nearest inclusion, if it is in none, and all exclusions it is in.
    pub fn breaches(&self, position: &PositionNed) -> impl Iterator<Item = Breach<'_>> {
        let left = self.out_of_inclusions(position, true);
        let place = *position;
        let entered = self.of_kind(ZoneKind::Exclusion).filter_map(move |zone| {
            let excess = zone.intrusion(&place);
            (!excess.is_inside()).then_some((zone, excess))
        });
        left.into_iter().chain(entered).map(|(zone, excess)| Breach {
            zone,
            action: zone.action,
            excess,
        })
    }

    /// The breach that counts at a place: the one with the strongest action, of equal ones the furthest. For vehicles in the air: one
    /// that stands may be under every floor.
    #[must_use]
    pub fn breach(&self, position: &PositionNed) -> Option<Breach<'_>> {
        self.breaches(position).max_by(|a, b| {
            let distances = a.excess.distance_m().total_cmp(&b.excess.distance_m());
            a.action.cmp(&b.action).then(distances)
        })
    }

    /// How far a place is from where it may be, by the zone from which it is furthest; zero inside.
    #[must_use]
    pub fn excess(&self, position: &PositionNed) -> Excess {
        self.breaches(position)
            .map(|breach| breach.excess)
            .max_by(|a, b| a.distance_m().total_cmp(&b.distance_m()))
            .unwrap_or_default()
    }

    /// Whether a place is inside.
    ///
    /// # Errors
    /// [`Refusal::OutsideFence`] that names the zone, or [`Refusal::InvalidValue`] for a place that is not finite.
    pub fn contains(&self, position: &PositionNed) -> Result<(), Refusal> {
        finite(position)?;
        let furthest = self
            .breaches(position)
            .max_by(|a, b| a.excess.distance_m().total_cmp(&b.excess.distance_m()));
        furthest.map_or(Ok(()), |breach| Err(refusal(breach.zone, position, &breach.excess)))
    }

    /// Whether the straight way between two places is inside from end to end, heights included.
    ///
    /// # Errors
    /// As [`Self::contains`].
    pub fn contains_way(&self, from: &PositionNed, to: &PositionNed) -> Result<(), Refusal> {
        self.contains(from)?;
        self.contains(to)?;
        if !self.stays_in_inclusions(from, to) {
            return Err(self.way_refusal(from, to, "leaves", None));
        }
        self.crossed(from, to)
            .map_or(Ok(()), |zone| Err(self.way_refusal(from, to, "crosses", Some(zone))))
    }

    /// The first exclusion in the list that a straight way goes through.
    #[must_use]
    pub fn crossed(&self, from: &PositionNed, to: &PositionNed) -> Option<&Zone> {
        self.of_kind(ZoneKind::Exclusion).find(|zone| zone.is_crossed(from, to))
    }

    /// For two places in inclusions: whether the way between them is too, be it in one or in several.
    pub(super) fn stays_in_inclusions(&self, from: &PositionNed, to: &PositionNed) -> bool {
        let mut parts: Vec<Share> = Vec::new();
        let mut any = false;
        for zone in self.of_kind(ZoneKind::Inclusion) {
            any = true;
            let volume = &zone.volume;
            let ends = volume.convex && volume.excess(from).is_inside() && volume.excess(to).is_inside();
            if ends {
                return true;
            }
            parts.extend(volume.shares_inside(from, to));
        }
        if !any {
            return true;
        }
        let length_m = from.distance_m(to);
        parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut covered = 0.0_f64;
        for [start, end] in parts {
            if (start - covered) * length_m > GAP_M {
                return false;
            }
            covered = covered.max(end);
        }
        (1.0 - covered) * length_m <= GAP_M
    }

    /// Whether a vehicle may be sent straight from where it is to another place. From inside: if the way is inside. Who is outside
    /// of the inclusions, or in an exclusion, may go where that gets no worse, and come back. On the ground floors do not count,
    /// nor what lies between.
    ///
    /// # Errors
    /// As [`Self::contains`].
    pub fn may_move(&self, from: &PositionNed, to: &PositionNed, airborne: bool) -> Result<(), Refusal> {
        finite(from)?;
        finite(to)?;
        match self.out_of_inclusions(from, airborne) {
            None => {
                if let Some((zone, excess)) = self.out_of_inclusions(to, airborne) {
                    return Err(refusal(zone, to, &excess));
                }
                if airborne && !self.stays_in_inclusions(from, to) {
                    return Err(self.way_refusal(from, to, "leaves", None));
                }
            }
            Some((zone, own)) => self.comes_no_further_out(zone, &own, from, to, airborne)?,
        }
        for zone in self.of_kind(ZoneKind::Exclusion) {
            let own_m = zone.intrusion(from).distance_m();
            let deeper = |place: &PositionNed| zone.intrusion(place).distance_m() > own_m;
            if own_m > 0.0 {
                if let Some(place) = places(from, to).find(deeper) {
                    return Err(refusal(zone, &place, &zone.intrusion(&place)));
                }
            } else if deeper(to) {
                return Err(refusal(zone, to, &zone.intrusion(to)));
            } else if airborne && zone.is_crossed(from, to) {
                return Err(self.way_refusal(from, to, "crosses", Some(zone)));
            }
        }
        Ok(())
    }

    fn comes_no_further_out(
        &self,
        zone: &Zone,
        own: &Excess,
        from: &PositionNed,
        to: &PositionNed,
        airborne: bool,
    ) -> Result<(), Refusal> {
        for place in places(from, to) {
            let excess = zone.volume.excess_standing(&place, airborne);
            if !excess.is_no_worse_than(own) && self.out_of_inclusions(&place, airborne).is_some() {
                return Err(refusal(zone, &place, &excess));
            }
        }
        Ok(())
    }

    /// Whether a vehicle may land at a place: within the outline of an inclusion, and not where an exclusion reaches down to it.
    /// Floors and ceilings of inclusions do not count: the ground is wherever it is.
    ///
    /// # Errors
    /// As [`Self::contains`].
    pub fn landing(&self, spot: &PositionNed) -> Result<(), Refusal> {
        finite(spot)?;
        let p = [spot.north_m, spot.east_m];
        let outside = |zone: &Zone| Excess {
            outside_m: zone.volume.outside_m(p),
            ..Excess::default()
        };
        let nearest = self
            .of_kind(ZoneKind::Inclusion)
            .map(|zone| (zone, outside(zone)))
            .min_by(|a, b| a.1.outside_m.total_cmp(&b.1.outside_m));
        if let Some((zone, excess)) = nearest
            && !excess.is_inside()
        {
            return Err(refusal(zone, spot, &excess));
        }
        let ground_m = -spot.down_m;
        let blocked = self.of_kind(ZoneKind::Exclusion).find(|zone| {
            let reaches_down = zone.volume.floor_m <= ground_m + LANDING_COLUMN_M && zone.volume.ceiling_m > ground_m;
            reaches_down && zone.volume.depth_m(p) > super::ON_EDGE_M
        });
        blocked.map_or(Ok(()), |zone| {
            let excess = Excess {
                outside_m: zone.volume.depth_m(p),
                ..Excess::default()
            };
            Err(refusal(zone, spot, &excess))
        })
    }

    fn way_refusal(&self, from: &PositionNed, to: &PositionNed, what: &str, zone: Option<&Zone>) -> Refusal {
        let named = |zone: &Zone| format!("\"{}\"", zone.name);
        let name = zone.map(named).unwrap_or_else(|| {
            let mut inclusions = self.of_kind(ZoneKind::Inclusion);
            match (inclusions.next(), inclusions.next()) {
                (Some(only), None) => named(only),
                _ => "all zones".to_owned(),
            }
        });
        Refusal::OutsideFence {
            detail: format!(
                "the straight way from ({:.1}, {:.1}) to ({:.1}, {:.1}) m {what} {name}",
                from.north_m, from.east_m, to.north_m, to.east_m
            ),
        }
    }
}

/// Places along a straight way, without its start.
fn places(from: &PositionNed, to: &PositionNed) -> impl Iterator<Item = PositionNed> {
    let (a, b) = (from.vector(), to.vector());
    (1..=LOOKS).map(move |k| a.lerp(&b, f64::from(k) / f64::from(LOOKS)).into())
}

fn finite(position: &PositionNed) -> Result<(), Refusal> {
    if position.is_finite() {
        return Ok(());
    }
    Err(Refusal::invalid("position is not finite"))
}

/// The refusal for a place that breaks a zone.
pub(super) fn refusal(zone: &Zone, position: &PositionNed, excess: &Excess) -> Refusal {
    let detail = match zone.kind {
        ZoneKind::Inclusion => match zone.volume.refusal(position, excess) {
            Refusal::OutsideFence { detail } => detail,
            other => return other,
        },
        ZoneKind::Exclusion => format!("{:.1} m inside, where nothing may fly", excess.distance_m()),
    };
    Refusal::OutsideFence {
        detail: format!("\"{}\": {detail}", zone.name),
    }
}

#[cfg(test)]
mod tests;
