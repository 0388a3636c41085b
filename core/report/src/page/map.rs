//! The map of all ways over the ground: north is up, a metre is as long to the east as to the north.
//!
//! Must never do: stretch one axis, or leave out which way is north.

use super::Page;
use super::axes::round_step;
use super::chart::{mark_class, r};
use crate::facts::{VehicleFacts, ZoneFacts};
use maud::{Markup, html as markup};
use skein_domain::ZoneKind;
use std::fmt::Write as _;

/// The drawing in its own units; its height follows the flight within these bounds.
const WIDTH: f64 = 900.0;
const HEIGHTS: [f64; 2] = [320.0, 640.0];
const MARGIN: f64 = 34.0;
/// The least that is shown, in metres.
const LEAST_M: f64 = 20.0;
/// Fences are shown whole unless they are so many times as large as the flight.
const FENCES_TIMES: f64 = 3.0;

/// A part of the ground: south, west, north, east in metres.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

/// From metres north and east to the drawing.
struct View {
    centre: [f64; 2],
    per_m: f64,
    height: f64,
}

impl Bounds {
    fn of(points_m: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let none = Self {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        };
        let all = points_m.fold(none, |of, [north, east]| Self {
            low: [of.low[0].min(north), of.low[1].min(east)],
            high: [of.high[0].max(north), of.high[1].max(east)],
        });
        all.low
            .iter()
            .chain(&all.high)
            .all(|metres| metres.is_finite())
            .then_some(all)
    }

    fn size(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    fn with(self, other: Self) -> Self {
        let corners = [self.low, self.high, other.low, other.high];
        Self::of(corners.into_iter()).unwrap_or(self)
    }
}

impl View {
    fn of(bounds: Bounds) -> Self {
        let [north_m, east_m] = bounds.size().map(|metres| metres.max(LEAST_M));
        let per_m = ((WIDTH - 2.0 * MARGIN) / east_m).min((HEIGHTS[1] - 2.0 * MARGIN) / north_m);
        Self {
            centre: [0, 1].map(|axis| (bounds.low[axis] + bounds.high[axis]) / 2.0),
            per_m,
            height: (north_m * per_m + 2.0 * MARGIN).clamp(HEIGHTS[0], HEIGHTS[1]),
        }
    }

    fn at(&self, [north_m, east_m]: [f64; 2]) -> [f64; 2] {
        let x = WIDTH / 2.0 + (east_m - self.centre[1]) * self.per_m;
        let y = self.height / 2.0 - (north_m - self.centre[0]) * self.per_m;
        [r(x), r(y)]
    }

    fn path(&self, points_m: &[[f64; 2]]) -> String {
        let mut path = String::new();
        for (at, point_m) in points_m.iter().enumerate() {
            let [x, y] = self.at(*point_m);
            let letter = if at == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{letter}{x} {y}");
        }
        path
    }
}

impl Page<'_> {
    pub(super) fn map(&self) -> Markup {
        let vehicles = &self.report.vehicles;
        let ways = vehicles
            .iter()
            .flat_map(|vehicle| vehicle.way_m.iter().copied().chain(vehicle.home_m));
        let fences = self
            .report
            .map
            .zones
            .iter()
            .flat_map(|zone| zone.corners_m.iter().copied());
        let (flown, fences) = (Bounds::of(ways), Bounds::of(fences));
        let shown = match (flown, fences) {
            (Some(flown), Some(fences)) => {
                let both = flown.with(fences);
                let fits = |axis: usize| both.size()[axis] <= FENCES_TIMES * flown.size()[axis].max(LEAST_M * 2.0);
                Some(if fits(0) && fits(1) { both } else { flown })
            }
            (flown, _) => flown,
        };
        markup! {
            section {
                h2 { "Where they flew" }
                @match shown {
                    None => p.none { "No position was recorded." },
                    Some(bounds) => {
                        (self.drawing(&View::of(bounds)))
                        (self.legend())
                        (self.keys())
                    }
                }
            }
        }
    }

    fn drawing(&self, view: &View) -> Markup {
        let vehicles = &self.report.vehicles;
        markup! {
            svg.map viewBox={ "0 0 " (WIDTH) " " (r(view.height)) } role="img" aria-label="Map of all ways over the ground, north up" {
                defs {
                    pattern id="hatch" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)" {
                        line x1="0" x2="0" y1="0" y2="8" {}
                    }
                }
                rect.ground width=(WIDTH) height=(r(view.height)) {}
                (grid(view))
                @for zone in &self.report.map.zones { (fence(view, zone)) }
                @for vehicle in vehicles { (self.home(view, vehicle)) }
                @for vehicle in vehicles {
                    path.curve d=(view.path(&vehicle.way_m)) stroke=(self.colours.of_vehicle(vehicle.id)) {}
                }
                @for vehicle in vehicles { (self.ends(view, vehicle)) }
                (self.places(view))
                (north(view))
                (scale(view))
            }
        }
    }

    fn home(&self, view: &View, vehicle: &VehicleFacts) -> Markup {
        let home = vehicle.home_m.map(|home_m| view.at(home_m));
        markup! {
            @if let Some([x, y]) = home {
                path.home d=(format!("M{} {y}h12M{x} {}v12", x - 6.0, y - 6.0)) stroke=(self.colours.of_vehicle(vehicle.id)) {}
            }
        }
    }

    fn ends(&self, view: &View, vehicle: &VehicleFacts) -> Markup {
        let colour = self.colours.of_vehicle(vehicle.id);
        let (first, last) = (vehicle.way_m.first(), vehicle.way_m.last());
        markup! {
            @if let (Some(first), Some(last)) = (first, last) {
                @let ([x0, y0], [x1, y1]) = (view.at(*first), view.at(*last));
                circle.begin cx=(x0) cy=(y0) r="4.5" stroke=(colour) {}
                rect.end x=(x1 - 4.0) y=(y1 - 4.0) width="8" height="8" fill=(colour) {}
                text.words x=(x1 + 8.0) y=(y1 + 4.0) fill=(colour) { (vehicle.id) }
            }
        }
    }

    /// Where something went wrong. Numbers that would lie upon each other stand in a row.
    fn places(&self, view: &View) -> Markup {
        let mut taken: Vec<[f64; 2]> = Vec::new();
        let placed: Vec<_> = self
            .report
            .findings
            .iter()
            .filter_map(|found| {
                let place = found.place?;
                let there = view.at([place.north_m, place.east_m]);
                let mut at = [there[0] + 13.0, there[1] - 13.0];
                while taken
                    .iter()
                    .any(|other| (other[0] - at[0]).hypot(other[1] - at[1]) < 16.0)
                    && at[0] < WIDTH - 10.0
                {
                    at[0] += 17.0;
                }
                taken.push(at);
                Some((found, there, at))
            })
            .collect();
        markup! {
            @for (found, [x0, y0], [x, y]) in placed {
                g class=(mark_class(found.severity)) {
                    line x1=(x0) y1=(y0) x2=(r(x)) y2=(r(y)) {}
                    circle.spot cx=(x0) cy=(y0) r="2.5" {}
                    circle cx=(r(x)) cy=(r(y)) r="8" {}
                    text x=(r(x)) y=(r(y + 3.8)) text-anchor="middle" { (found.number) }
                }
            }
        }
    }

    fn keys(&self) -> Markup {
        let map = &self.report.map;
        markup! {
            p.under {
                "○ in the air from here, ■ until here, + launch place."
                @if !map.zones.is_empty() { " Dashed: fence to stay in; hatched: fence to keep out of." }
                @if map.fence_changes == 1 { " The fences were changed once; these are the last ones." }
                @if map.fence_changes > 1 { " The fences were changed " (map.fence_changes) " times; these are the last ones." }
            }
        }
    }
}

/// Metres that are round, and about an eighth of the map.
fn grid_m(view: &View) -> f64 {
    round_step(WIDTH / view.per_m / 10.0)
}

fn grid(view: &View) -> Markup {
    let step_m = grid_m(view);
    let lines = |centre_m: f64, size: f64| {
        let half_m = size / view.per_m / 2.0;
        let (first, last) = (
            ((centre_m - half_m) / step_m).ceil() as i64,
            ((centre_m + half_m) / step_m).floor() as i64,
        );
        (first..=last).map(move |n| n as f64 * step_m)
    };
    markup! {
        @for east_m in lines(view.centre[1], WIDTH) {
            @let [x, _] = view.at([0.0, east_m]);
            line.grid x1=(x) x2=(x) y1="0" y2=(r(view.height)) {}
        }
        @for north_m in lines(view.centre[0], view.height) {
            @let [_, y] = view.at([north_m, 0.0]);
            line.grid x1="0" x2=(WIDTH) y1=(y) y2=(y) {}
        }
    }
}

fn fence(view: &View, zone: &ZoneFacts) -> Markup {
    let inside = zone.kind == ZoneKind::Inclusion;
    let highest = zone.corners_m.iter().copied().max_by(|a, b| a[0].total_cmp(&b[0]));
    let [x, y] = highest.map_or([0.0; 2], |corner_m| view.at(corner_m));
    let heights = match zone.heights_m {
        [None, None] => String::new(),
        [None, Some(top)] => format!(" to {top:.0} m"),
        [Some(floor), None] => format!(" from {floor:.0} m"),
        [Some(floor), Some(top)] => format!(" {floor:.0}–{top:.0} m"),
    };
    markup! {
        path class=(if inside { "fence" } else { "fence out" }) d={ (view.path(&zone.corners_m)) "Z" } {}
        text.fence-name x=(x.clamp(6.0, WIDTH - 120.0)) y=((y + 14.0).clamp(14.0, view.height - 6.0)) { (zone.name) (heights) }
    }
}

fn north(_: &View) -> Markup {
    markup! {
        g.north {
            path d="M24 14l8 22l-8 -5l-8 5z" {}
            text x="24" y="50" text-anchor="middle" { "N" }
        }
    }
}

fn scale(view: &View) -> Markup {
    let metres = grid_m(view);
    let (end, y) = (WIDTH - 18.0, view.height - 16.0);
    let begin = end - metres * view.per_m;
    markup! {
        g.scale {
            path d=(format!("M{} {}v5H{end}v-5", r(begin), r(y - 5.0))) {}
            text x=(r((begin + end) / 2.0)) y=(r(y - 6.0)) text-anchor="middle" { (super::length(metres)) }
        }
    }
}
