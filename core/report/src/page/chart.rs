//! A chart over the time of the recording, drawn as SVG. All have the same axis of time, so that one lies over the other.
//!
//! Must never do: draw a point outside of its frame.

use super::axes::{moments, plain, ticks};
use super::clock::Clock;
use crate::curve::{Curve, Sample};
use crate::facts::{Finding, LimitFrom};
use maud::{Markup, html as markup};
use skein_domain::exchange::Severity;
use std::fmt::Write as _;

/// Width and height in units of the drawing, and the margins.
const WIDTH: f64 = 900.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 22.0;
/// Height of the part with the curves.
const PLOT: f64 = 132.0;
/// Height of a band under it.
const BAND: f64 = 9.0;
/// Numbers of findings stand so far apart, beside their line if need be, and are left out where they would stand too far aside.
const APART: f64 = 17.0;
const ASIDE: f64 = 36.0;

/// One line of a chart.
pub struct Line<'a> {
    pub curve: &'a Curve,
    pub colour: &'a str,
    /// What its values are multiplied by to be in the unit of the chart.
    pub scale: f64,
}

/// A horizontal line.
pub struct Level {
    pub words: String,
    pub steps: Vec<LimitFrom>,
}

/// A piece of a band under the curves.
pub struct Piece<'a> {
    pub from_s: f64,
    pub until_s: f64,
    pub colours: [&'a str; 2],
}

/// A chart.
pub struct Chart<'a> {
    pub unit: &'static str,
    pub says: String,
    pub lines: Vec<Line<'a>>,
    pub levels: Vec<Level>,
    pub bands: Vec<Vec<Piece<'a>>>,
    /// Times that are shaded.
    pub shaded_s: &'a [[f64; 2]],
    /// Values between which the axis reaches at least.
    pub reach: [f64; 2],
    /// No more than this is shown; higher values end at the edge.
    pub most: f64,
    pub dots: Vec<Sample>,
    pub findings: &'a [Finding],
    pub duration_s: f64,
    pub clock: &'a Clock,
}

impl Chart<'_> {
    fn x(&self, t_s: f64) -> f64 {
        let share = (t_s / self.duration_s.max(1e-3)).clamp(0.0, 1.0);
        LEFT + share * (WIDTH - LEFT - RIGHT)
    }

    /// Lowest and highest value that is shown.
    fn range(&self) -> [f64; 2] {
        let values = self
            .lines
            .iter()
            .flat_map(|line| line.curve.samples().map(|sample| sample.value * line.scale));
        let [low, high] = values.fold(self.reach, |[low, high], value| [low.min(value), high.max(value)]);
        let levels = self
            .levels
            .iter()
            .flat_map(|level| level.steps.iter().map(|step| step.value));
        // A limit far beyond everything would flatten the curves.
        let high = levels
            .filter(|level| *level < 4.0 * high.max(1e-9))
            .fold(high, f64::max)
            .min(self.most);
        [low, high + (high - low).max(1e-9) * 0.06]
    }

    pub fn draw(&self) -> Markup {
        let [low, high] = self.range();
        let y = |value: f64| TOP + PLOT - ((value - low) / (high - low)).clamp(0.0, 1.0) * PLOT;
        let height = TOP + PLOT + BOTTOM + BAND * self.bands.len() as f64;
        let foot = height - BOTTOM;
        markup! {
            svg.chart viewBox={ "0 0 " (WIDTH) " " (height) } role="img" aria-label=(self.says) {
                @for [from_s, until_s] in self.shaded_s {
                    rect.shaded x=(r(self.x(*from_s))) y=(TOP) width=(r(self.x(*until_s) - self.x(*from_s))) height=(PLOT) {}
                }
                @for value in ticks(low, high, 4) {
                    line.grid x1=(LEFT) x2=(WIDTH - RIGHT) y1=(r(y(value))) y2=(r(y(value))) {}
                    text.tick x=(LEFT - 6.0) y=(r(y(value) + 4.0)) text-anchor="end" { (plain(value)) }
                }
                text.unit x=(LEFT - 6.0) y=(TOP - 10.0) text-anchor="end" { (self.unit) }
                @for (t_s, words) in moments(self.clock, self.duration_s) {
                    line.grid x1=(r(self.x(t_s))) x2=(r(self.x(t_s))) y1=(TOP) y2=(r(foot)) {}
                    text.tick x=(r(self.x(t_s).min(WIDTH - RIGHT - 12.0))) y=(r(height - 6.0)) text-anchor="middle" { (words) }
                }
                @for level in &self.levels { (self.level(level, &y, low, high)) }
                (self.marks(foot))
                @for line in &self.lines {
                    path.curve d=(self.path(line, &y)) stroke=(line.colour) {}
                }
                @for dot in &self.dots {
                    circle.dot cx=(r(self.x(dot.t_s))) cy=(r(y(dot.value))) r="4" {}
                }
                @for (row, band) in self.bands.iter().enumerate() { (self.band(band, TOP + PLOT + BAND * row as f64)) }
                rect.frame x=(LEFT) y=(TOP) width=(WIDTH - LEFT - RIGHT) height=(PLOT) {}
            }
        }
    }

    fn path(&self, line: &Line<'_>, y: &dyn Fn(f64) -> f64) -> String {
        let mut path = String::new();
        for piece in &line.curve.pieces {
            let mut letter = 'M';
            for sample in piece {
                let _ = write!(
                    path,
                    "{letter}{} {}",
                    r(self.x(sample.t_s)),
                    r(y(sample.value * line.scale))
                );
                letter = 'L';
            }
            // One alone is a point, which the round end of a line shows.
            if piece.len() == 1 {
                path.push_str("h.1");
            }
        }
        path
    }

    fn level(&self, level: &Level, y: &dyn Fn(f64) -> f64, low: f64, high: f64) -> Markup {
        let mut path = String::new();
        for (at, step) in level.steps.iter().enumerate() {
            let until_s = level.steps.get(at + 1).map_or(self.duration_s, |next| next.t_s);
            let letter = if at == 0 { 'M' } else { 'L' };
            let _ = write!(
                path,
                "{letter}{} {}H{}",
                r(self.x(step.t_s)),
                r(y(step.value)),
                r(self.x(until_s))
            );
        }
        let last = level
            .steps
            .last()
            .map(|step| step.value)
            .filter(|value| (low..=high).contains(value));
        markup! {
            @if let Some(value) = last {
                path.level d=(path) {}
                text.words x=(WIDTH - RIGHT - 5.0) y=(r(y(value) - 4.0)) text-anchor="end" { (level.words) }
            }
        }
    }

    /// Where something went wrong, with its number.
    fn marks(&self, foot: f64) -> Markup {
        let mut last = f64::NEG_INFINITY;
        let marks = self.findings.iter().map(|found| {
            let x = self.x(found.t_s);
            let beside = x.max(last + APART);
            let written = beside - x <= ASIDE && beside < WIDTH;
            if written {
                last = beside;
            }
            (x, found, written.then_some(beside))
        });
        let marks: Vec<(f64, &Finding, Option<f64>)> = marks.collect();
        markup! {
            @for (x, found, written) in marks {
                g class=(mark_class(found.severity)) {
                    line x1=(r(x)) x2=(r(x)) y1=(TOP) y2=(r(foot)) {}
                    @if let Some(beside) = written {
                        circle cx=(r(beside)) cy=(TOP - 10.0) r="8" {}
                        text x=(r(beside)) y=(TOP - 6.2) text-anchor="middle" { (found.number) }
                    }
                }
            }
        }
    }

    fn band(&self, pieces: &[Piece<'_>], top: f64) -> Markup {
        let half = (BAND - 1.0) / 2.0;
        markup! {
            @for piece in pieces {
                @for (row, colour) in piece.colours.iter().enumerate() {
                    rect x=(r(self.x(piece.from_s))) y=(r(top + 1.0 + half * row as f64))
                        width=(r((self.x(piece.until_s) - self.x(piece.from_s)).max(0.6))) height=(half) fill=(colour) {}
                }
            }
        }
    }
}

/// How a finding is drawn.
pub fn mark_class(severity: Severity) -> &'static str {
    if severity >= Severity::Critical {
        "mark critical"
    } else {
        "mark warning"
    }
}

/// To a tenth: what an eye can see.
pub fn r(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
