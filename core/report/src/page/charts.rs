//! The charts, in the order in which a person asks.
//!
//! Must never do: show two units in one chart.

use super::Page;
use super::chart::{Chart, Level, Line, Piece};
use super::duration;
use crate::curve::{Curve, Sample};
use crate::facts::{LimitFrom, VehicleFacts};
use maud::{Markup, html as markup};

/// With more vehicles a legend under each chart is no help.
const LEGEND: usize = 16;

/// Which curve of a vehicle.
type Which = fn(&VehicleFacts) -> &Curve;

/// What is particular to a chart.
struct Plan {
    title: &'static str,
    unit: &'static str,
    scale: f64,
    which: Which,
    reach: [f64; 2],
    most: f64,
    levels: Vec<Level>,
    words: String,
}

impl Page<'_> {
    pub(super) fn charts(&self) -> Markup {
        markup! {
            section.charts {
                h2 { "Over time" }
                p.quiet {
                    "Time of day in " (self.clock.zone()) ". Numbered lines are what went wrong."
                    @if !self.report.charts.formations_s.is_empty() { " Shaded: a formation was flown." }
                }
                (self.distances())
                @for plan in self.plans() { (self.vehicles_chart(plan)) }
            }
        }
    }

    #[expect(
        clippy::too_many_lines,
        reason = "one line for each chart, which the formatter spreads"
    )]
    fn plans(&self) -> Vec<Plan> {
        let facts = &self.report.charts;
        let level = |value: Option<f64>, scale: f64, words: &str| {
            let step = |value: f64| LimitFrom {
                t_s: 0.0,
                value: value * scale,
            };
            let steps: Vec<LimitFrom> = value.into_iter().map(step).collect();
            let words = words.to_owned();
            if steps.is_empty() {
                Vec::new()
            } else {
                vec![Level { words, steps }]
            }
        };
        let plan = |title, unit, scale, which: Which, reach, levels, words: String| Plan {
            title,
            unit,
            scale,
            which,
            reach,
            most: if unit == "%" { 100.0 } else { f64::INFINITY },
            levels,
            words,
        };
        let reserve = level(facts.reserve, 100.0, "reserve after landing");
        let error = level(facts.tracking_limit_m, 1.0, "failsafe");
        let rate = level(Some(2.0), 1.0, "PX4 leaves OFFBOARD");
        vec![
            plan(
                "Formation error",
                "m",
                1.0,
                |of| &of.curves.tracking_error_m,
                [0.0, 1.0],
                error,
                self.worst_error(),
            ),
            plan(
                "Height",
                "m",
                1.0,
                |of| &of.curves.height_m,
                [0.0, 1.0],
                Vec::new(),
                self.highest(),
            ),
            plan(
                "Ground speed",
                "m/s",
                1.0,
                |of| &of.curves.speed_m_s,
                [0.0, 1.0],
                Vec::new(),
                self.fastest(),
            ),
            plan(
                "Battery",
                "%",
                100.0,
                |of| &of.curves.battery,
                [0.0, 100.0],
                reserve,
                self.emptiest(),
            ),
            plan(
                "Link loss",
                "%",
                100.0,
                |of| &of.curves.loss,
                [0.0, 5.0],
                Vec::new(),
                self.worst_loss(),
            ),
            plan(
                "Link round trip",
                "ms",
                1e3,
                |of| &of.curves.round_trip_s,
                [0.0, 20.0],
                Vec::new(),
                self.slowest(),
            ),
            plan(
                "Setpoints sent",
                "Hz",
                1.0,
                |of| &of.curves.setpoint_rate_hz,
                [0.0, 5.0],
                rate,
                self.gaps(),
            ),
        ]
    }

    fn vehicles_chart(&self, plan: Plan) -> Markup {
        let lines: Vec<Line<'_>> = self
            .report
            .vehicles
            .iter()
            .map(|vehicle| Line {
                curve: (plan.which)(vehicle),
                colour: self.colours.of_vehicle(vehicle.id),
                scale: plan.scale,
            })
            .filter(|line| !line.curve.pieces.is_empty())
            .collect();
        let measured = !lines.is_empty();
        let bands = if plan.unit == "Hz" {
            self.gap_bands()
        } else {
            Vec::new()
        };
        let chart = Chart {
            says: format!("{}: {}", plan.title, plan.words),
            lines,
            levels: plan.levels,
            bands,
            reach: plan.reach,
            most: plan.most,
            ..self.empty(plan.unit)
        };
        self.figure(plan.title, &plan.words, measured.then_some(chart), true)
    }

    fn empty(&self, unit: &'static str) -> Chart<'_> {
        Chart {
            unit,
            says: String::new(),
            lines: Vec::new(),
            levels: Vec::new(),
            bands: Vec::new(),
            shaded_s: &self.report.charts.formations_s,
            reach: [0.0, 1.0],
            most: f64::INFINITY,
            dots: Vec::new(),
            findings: &self.report.findings,
            duration_s: self.report.about.duration_s,
            clock: &self.clock,
        }
    }

    fn figure(&self, title: &str, words: &str, chart: Option<Chart<'_>>, legend: bool) -> Markup {
        markup! {
            figure {
                figcaption { strong { (title) } " " span { (words) } }
                @if let Some(chart) = chart {
                    (chart.draw())
                    @if legend && self.report.vehicles.len() <= LEGEND { (self.legend()) }
                } @else {
                    p.none { "Not recorded." }
                }
            }
        }
    }

    pub(super) fn legend(&self) -> Markup {
        markup! {
            p.legend {
                @for vehicle in &self.report.vehicles {
                    span.sign { i style={ "background:" (self.colours.of_vehicle(vehicle.id)) } {} (vehicle.label()) }
                }
            }
        }
    }

    /// The smallest distance between any two, with the two as a band under it.
    fn distances(&self) -> Markup {
        let facts = &self.report.charts;
        let lowest = facts.distance_m.lowest();
        let words = lowest.map_or_else(String::new, |least| {
            let pair = least
                .pair
                .map_or_else(String::new, |[a, b]| format!(" between {a} and {b}"));
            let limit = facts.distance_limit_m.iter().rfind(|limit| limit.t_s <= least.t_s);
            let limit = limit.map_or_else(String::new, |limit| format!("; limit {:.2} m", limit.value));
            format!(
                "smallest {:.2} m{pair} at {}{limit}",
                least.value,
                self.clock.time(least.t_s)
            )
        });
        let most = facts
            .distance_limit_m
            .iter()
            .map(|limit| limit.value)
            .fold(0.0, f64::max);
        // What counts is how near they come: of what is far apart only the beginning is shown.
        let high = facts.distance_m.highest().map_or(0.0, |sample| sample.value);
        let near = (lowest.map_or(0.0, |sample| sample.value).max(most) * 6.0).max(5.0);
        let chart = lowest.map(|least| Chart {
            says: format!("Smallest distance between any two vehicles: {words}"),
            lines: vec![Line {
                curve: &facts.distance_m,
                colour: "#12171a",
                scale: 1.0,
            }],
            levels: vec![Level {
                words: "smallest permitted".into(),
                steps: facts.distance_limit_m.clone(),
            }],
            bands: vec![self.pair_band()],
            most: high.min(near),
            dots: vec![Sample { ..*least }],
            ..self.empty("m")
        });
        let chart = self.figure("Smallest distance between any two", &words, chart, false);
        markup! {
            (chart)
            @if lowest.is_some() {
                p.under { "The band under the curve shows which two are nearest, in their colours." }
            }
        }
    }

    fn pair_band(&self) -> Vec<Piece<'_>> {
        let mut pieces: Vec<([skein_domain::VehicleId; 2], Piece<'_>)> = Vec::new();
        for sample in self.report.charts.distance_m.samples() {
            let Some(pair) = sample.pair else { continue };
            match pieces.last_mut() {
                Some((last, piece)) if *last == pair => piece.until_s = sample.t_s,
                last => {
                    if let Some((_, piece)) = last
                        && sample.t_s - piece.until_s < 3.0
                    {
                        piece.until_s = sample.t_s;
                    }
                    let colours = pair.map(|id| self.colours.of_vehicle(id));
                    pieces.push((
                        pair,
                        Piece {
                            from_s: sample.t_s,
                            until_s: sample.t_s,
                            colours,
                        },
                    ));
                }
            }
        }
        pieces.into_iter().map(|(_, piece)| piece).collect()
    }

    /// A band for each vehicle with gaps between its recorded setpoints.
    fn gap_bands(&self) -> Vec<Vec<Piece<'_>>> {
        let with = self
            .report
            .vehicles
            .iter()
            .filter(|vehicle| vehicle.gaps.count > 0)
            .take(LEGEND);
        let band = |vehicle: &VehicleFacts| {
            let colour = self.colours.of_vehicle(vehicle.id);
            let piece = |gap: &crate::facts::Gap| Piece {
                from_s: gap.t_s,
                until_s: gap.t_s + gap.length_s,
                colours: [colour; 2],
            };
            vehicle.gaps.some.iter().map(piece).collect()
        };
        with.map(band).collect()
    }
}

/// The sentences beside the titles.
impl Page<'_> {
    fn extreme(&self, of: fn(&VehicleFacts) -> Option<crate::facts::Extreme>) -> Option<(&VehicleFacts, f64, String)> {
        let all = self
            .report
            .vehicles
            .iter()
            .filter_map(|vehicle| Some((vehicle, of(vehicle)?)));
        let (vehicle, extreme) = all.max_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
        Some((vehicle, extreme.value, self.clock.time(extreme.t_s)))
    }

    fn worst_error(&self) -> String {
        let told = self.extreme(|of| of.largest_error_m);
        told.map_or_else(String::new, |(vehicle, metres, at)| {
            format!(
                "distance from where its task wants each; largest {metres:.1} m, vehicle {} at {at}",
                vehicle.id
            )
        })
    }

    fn highest(&self) -> String {
        let told = self.extreme(|of| of.highest_m);
        told.map_or_else(String::new, |(vehicle, metres, at)| {
            format!(
                "above the swarm’s origin; highest {metres:.1} m, vehicle {} at {at}",
                vehicle.id
            )
        })
    }

    fn fastest(&self) -> String {
        let told = self.extreme(|of| of.fastest_m_s);
        told.map_or_else(String::new, |(vehicle, speed, at)| {
            format!("largest {speed:.1} m/s, vehicle {} at {at}", vehicle.id)
        })
    }

    fn emptiest(&self) -> String {
        let all = self
            .report
            .vehicles
            .iter()
            .filter_map(|vehicle| Some((vehicle, vehicle.battery?.last)));
        let least = all.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or_else(String::new, |(vehicle, left)| {
            format!("least left {:.0} %, vehicle {}", left * 100.0, vehicle.id)
        })
    }

    fn worst_loss(&self) -> String {
        let told = self.extreme(|of| of.link.loss);
        told.map_or_else(String::new, |(vehicle, loss, at)| {
            format!(
                "frames lost on the way here; worst {:.1} %, vehicle {} at {at}",
                loss * 100.0,
                vehicle.id
            )
        })
    }

    fn slowest(&self) -> String {
        let told = self.extreme(|of| of.link.round_trip_s);
        told.map_or_else(String::new, |(vehicle, s, at)| {
            format!("worst {:.0} ms, vehicle {} at {at}", s * 1e3, vehicle.id)
        })
    }

    fn gaps(&self) -> String {
        let count: u64 = self.report.vehicles.iter().map(|vehicle| vehicle.gaps.count).sum();
        let longest = self.report.vehicles.iter().filter_map(|vehicle| vehicle.gaps.longest);
        match longest.max_by(|a, b| a.length_s.total_cmp(&b.length_s)) {
            None => "no gap between recorded setpoints in OFFBOARD".into(),
            Some(longest) => {
                let at = self.clock.time(longest.t_s);
                let gaps = if count == 1 {
                    "1 gap".to_owned()
                } else {
                    format!("{count} gaps")
                };
                format!(
                    "{gaps} between recorded setpoints in OFFBOARD, the longest {} at {at}",
                    duration(longest.length_s)
                )
            }
        }
    }
}
