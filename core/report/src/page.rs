//! The page: one file of HTML with its style and its drawings in it, for a screen, a tablet and paper.
//!
//! Must never do: need anything that is not in the file, a script least of all; put text into it that is not escaped.

mod axes;
mod chart;
mod charts;
mod clock;
mod colours;
mod findings;
mod head;
mod map;
mod tables;

pub use clock::Clock;

use crate::facts::Report;
use colours::Colours;
use maud::{DOCTYPE, Markup, PreEscaped, html as markup};

const STYLE: &str = include_str!("page/style.css");

/// What all parts of the page need.
struct Page<'a> {
    report: &'a Report,
    clock: Clock,
    colours: Colours,
}

/// The page.
#[must_use]
pub fn html(report: &Report) -> String {
    let page = Page {
        report,
        clock: Clock::of(&report.about),
        colours: Colours::of(report),
    };
    page.document().into_string()
}

impl Page<'_> {
    fn document(&self) -> Markup {
        let about = &self.report.about;
        let title = format!("Flight of {}", self.clock.date_time(0.0));
        markup! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content=(format!("skein {}", env!("CARGO_PKG_VERSION")));
                    title { (title) " · " (about.node_name) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    (self.head())
                    main {
                        (self.findings())
                        (self.map())
                        (self.charts())
                        (self.vehicles())
                        (self.actions())
                        (self.commands())
                        (self.events())
                    }
                    footer {
                        "Made from " code { (about.file) } ". Distances are between vehicles in the air at the same moment; heights are above \
                        the swarm’s origin; a curve shows the lowest and the highest value of each stretch of time."
                    }
                }
            }
        }
    }

    /// A vehicle as a coloured sign with its number.
    fn sign(&self, id: skein_domain::VehicleId) -> Markup {
        let name = self
            .report
            .vehicle(id)
            .map(|vehicle| vehicle.label())
            .unwrap_or_default();
        markup! {
            span.sign title=(name) { i style={ "background:" (self.colours.of_vehicle(id)) } {} (id) }
        }
    }
}

/// A length of time as people say it.
fn duration(seconds: f64) -> String {
    let whole = seconds.round().max(0.0) as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, s) => format!("{h} h {m:02} min {s:02} s"),
    }
}

/// A length as people say it.
fn length(metres: f64) -> String {
    if metres >= 10_000.0 {
        format!("{:.1} km", metres / 1000.0)
    } else {
        format!("{metres:.0} m")
    }
}
