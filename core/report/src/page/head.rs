//! The head of the page: when, where, who, how long, the verdict, and whether the recording is whole.
//!
//! Must never do: let a recording that is not whole look like one that is.

use super::{Page, duration};
use crate::facts::{EndState, Wholeness};
use maud::{Markup, html as markup};
use skein_domain::exchange::Severity;

impl Page<'_> {
    pub(super) fn head(&self) -> Markup {
        let worst = self.report.findings.iter().map(|found| found.severity).max();
        let lost = self.report.vehicles.iter().any(|vehicle| vehicle.end == EndState::Lost);
        let tone = match worst {
            Some(Severity::Critical) => "critical",
            _ if lost => "critical",
            Some(_) => "warning",
            None => "fine",
        };
        markup! {
            header {
                p.over { "Flight report" }
                h1 { (self.clock.date_time(0.0)) }
                p.verdict.(tone) { (self.report.verdict.join(" ")) }
                (self.figures())
                (self.wholeness())
            }
        }
    }

    fn figures(&self) -> Markup {
        let about = &self.report.about;
        let flew = self
            .report
            .vehicles
            .iter()
            .filter(|vehicle| vehicle.end != EndState::NeverFlew)
            .count();
        let all = self.report.vehicles.len();
        markup! {
            dl.figures {
                div { dt { "Length" } dd { (duration(about.duration_s)) } }
                div {
                    dt { "Vehicles" }
                    dd {
                        (flew) @if flew != all { " of " (all) } " flew"
                        @if about.simulated > 0 { ", " @if about.simulated == all { "simulated" } @else { (about.simulated) " simulated" } }
                    }
                }
                @if let Some(origin) = about.origin {
                    div {
                        dt { "Where" }
                        dd { (format!("{:.5}, {:.5}", origin.latitude_deg, origin.longitude_deg))
                            span.quiet { (format!(" {:.0} m AMSL", origin.altitude_amsl_m)) } }
                    }
                }
                @if !about.swarm.is_empty() { div { dt { "Swarm" } dd { (about.swarm) } } }
                div {
                    dt { "Recorded by" }
                    dd { (about.node_name) @if let Some(node) = about.node { span.quiet { " node " (node) } } }
                }
                div { dt { "Version" } dd { (about.version) } }
            }
        }
    }

    fn wholeness(&self) -> Markup {
        let about = &self.report.about;
        let size = match about.bytes {
            bytes if bytes >= 1_000_000 => format!("{:.1} MB", bytes as f64 * 1e-6),
            bytes => format!("{:.0} kB", (bytes as f64 * 1e-3).max(1.0)),
        };
        markup! {
            @if about.whole.is_whole() {
                p.whole { "The recording is whole: " code { (about.file) } ", " (size) "." }
            } @else {
                div.whole.broken {
                    strong { (not_whole(&about.whole)) } " " code { (about.file) } ", " (size) "."
                    ul { @for why in reasons(&about.whole) { li { (why) } } }
                }
            }
            @if let Some(set_s) = about.clock_set_s {
                p.whole.broken {
                    "The computer’s clock was set by " (format!("{set_s:.1} s")) " during the recording. \
                    Times on this page go on from the clock at the beginning."
                }
            }
        }
    }
}

fn not_whole(whole: &Wholeness) -> &'static str {
    if whole.finished {
        "The recording has holes: what happened in them is not in this report."
    } else {
        "The recording is cut off: what happened after its end is not in this report."
    }
}

fn reasons(whole: &Wholeness) -> Vec<String> {
    let times = |count: u64| {
        if count > 1 {
            format!(" ({count} times)")
        } else {
            String::new()
        }
    };
    let mut reasons: Vec<String> = whole
        .damage
        .iter()
        .map(|(why, count)| format!("{why}{}", times(*count)))
        .collect();
    if whole.unreadable > 0 {
        reasons.push(format!("{} messages could not be understood", whole.unreadable));
    }
    if whole.dropped > 0 {
        reasons.push(format!(
            "the recorder dropped {} messages: the disk did not take them",
            whole.dropped
        ));
    }
    reasons
}
