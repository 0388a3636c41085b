//! The tables: each vehicle, who commanded what, every event.
//!
//! Must never do: put a figure into a cell without its unit.

use super::Page;
use super::{duration, length};
use crate::facts::{ActionFacts, CommandFacts, EndState, VehicleFacts};
use maud::{Markup, html as markup};
use skein_domain::exchange::Severity;

impl Page<'_> {
    pub(super) fn vehicles(&self) -> Markup {
        markup! {
            section {
                h2 { "Each vehicle" }
                div.scroll {
                    table.figures-table {
                        thead {
                            tr {
                                th { "Vehicle" } th.n { "In the air" } th.n { "Flown" } th.n { "Highest" } th.n { "Fastest" } th.n { "Nearest other" }
                                th.n { "Formation error" } th.n { "Battery used" } th.n { "Worst loss" } th.n { "Setpoints refused" }
                                th.n { "Events" } th { "At the end" }
                            }
                        }
                        tbody { @for vehicle in &self.report.vehicles { (self.row(vehicle)) } }
                    }
                }
            }
        }
    }

    fn row(&self, of: &VehicleFacts) -> Markup {
        let [all, warnings, critical] = of.events;
        let some = |figure: Option<String>| figure.unwrap_or_else(|| "–".into());
        let limits = &self.report.charts.distance_limit_m;
        let near = of.nearest.map(|near| {
            let limit = limits.iter().rfind(|limit| limit.t_s <= near.t_s);
            (near, limit.is_some_and(|limit| near.distance_m < limit.value))
        });
        let far = of
            .largest_error_m
            .zip(self.report.charts.tracking_limit_m)
            .is_some_and(|(error, limit)| error.value > limit);
        markup! {
            tr {
                th scope="row" { span.sign { i style={ "background:" (self.colours.of_vehicle(of.id)) } {} (of.label()) } br; span.quiet { (of.plugin) } }
                td.n { (if of.flight_s > 0.0 { duration(of.flight_s) } else { "–".into() }) }
                td.n { (length(of.flown_m)) }
                td.n { (some(of.highest_m.map(|most| format!("{:.1} m", most.value)))) }
                td.n { (some(of.fastest_m_s.map(|most| format!("{:.1} m/s", most.value)))) }
                td.n.bad[near.is_some_and(|(_, under)| under)] {
                    @if let Some((near, _)) = near {
                        (format!("{:.2} m", near.distance_m)) br; span.quiet { "to " (near.other) ", " (self.clock.time(near.t_s)) }
                    } @else { "–" }
                }
                td.n.bad[far] {
                    @if let Some(most) = of.largest_error_m {
                        (format!("{:.1} m", most.value)) br; span.quiet { (self.clock.time(most.t_s)) }
                    } @else { "–" }
                }
                td.n {
                    @if let Some(battery) = of.battery {
                        (format!("{:.0} %", (battery.first - battery.last) * 100.0)) br; span.quiet { (format!("{:.0} % left", battery.last * 100.0)) }
                    } @else { "–" }
                }
                td.n { (some(of.link.loss.map(|most| format!("{:.1} %", most.value * 100.0)))) }
                td.n { @if of.setpoints == 0 { "–" } @else { (of.setpoints_refused) span.quiet { " of " (of.setpoints) } } }
                td.n { (all) @if warnings + critical > 0 { br; span.quiet { (count((warnings + critical) as usize, "warning")) } } }
                td.bad[of.end == EndState::Lost] { (end(of.end)) }
            }
        }
    }

    pub(super) fn actions(&self) -> Markup {
        let actions = &self.report.actions;
        markup! {
            section {
                h2 { "Who commanded what" }
                @if let Some(broken) = &self.report.audit_broken {
                    p.whole.broken { "The audit was changed after it was written: " (broken) "." }
                }
                @if actions.is_empty() { p.none { "No action was recorded." } } @else {
                    p.quiet {
                        (count(actions.len(), "action")) " of operators and programs."
                        @if self.report.audit_broken.is_none() { " Their chain of hashes is unbroken." }
                    }
                    div.scroll {
                        table {
                            thead { tr { th { "Time" } th { "Who" } th { "What" } th { "Outcome" } } }
                            tbody { @for action in actions { (self.action(action)) } }
                        }
                    }
                }
            }
        }
    }

    fn action(&self, of: &ActionFacts) -> Markup {
        markup! {
            tr {
                td.time { (self.clock.time(of.t_ms as f64 * 1e-3)) }
                td { @if of.who.is_empty() { span.quiet { "not said" } } @else { (of.who) } @if !of.over.is_empty() { br; span.quiet { (of.over) } } }
                td { (of.what) @if !of.with.is_empty() { br; code.body { (of.with) } } }
                td { (of.outcome) }
            }
        }
    }

    pub(super) fn commands(&self) -> Markup {
        let commands = &self.report.commands;
        markup! {
            section {
                details open[commands.len() <= 40] {
                    summary { h2 { "Commands and what became of them" } span.quiet { (count(commands.len(), "command")) } }
                    @if commands.is_empty() { p.none { "No command was recorded." } } @else {
                        div.scroll {
                            table {
                                thead { tr { th { "Time" } th { "Vehicle" } th { "Command" } th { "How it went on" } } }
                                tbody { @for command in commands { (self.command(command)) } }
                            }
                        }
                    }
                }
            }
        }
    }

    fn command(&self, of: &CommandFacts) -> Markup {
        markup! {
            tr {
                td.time { (self.clock.time(of.t_s)) }
                td { @if let Some(vehicle) = of.vehicle { (self.sign(vehicle)) } }
                td { (of.command) span.quiet { " #" (of.id) } }
                td.bad[of.refused] {
                    @for (at, step) in of.progress.iter().enumerate() {
                        @if at > 0 { ", " }
                        (step.text)
                        @if step.t_s > of.t_s + 0.05 { span.quiet { " after " (format!("{:.1} s", step.t_s - of.t_s)) } }
                    }
                }
            }
        }
    }

    pub(super) fn events(&self) -> Markup {
        let events = &self.report.events;
        markup! {
            section {
                details {
                    summary { h2 { "Every event" } span.quiet { (count(events.len(), "event")) } }
                    @if self.report.left_out > 0 {
                        p.quiet { (self.report.left_out) " more actions, commands and events did not fit in; the recording has them." }
                    }
                    div.scroll {
                        table {
                            thead { tr { th { "Time" } th { "Vehicle" } th { "" } th { "Event" } } }
                            tbody {
                                @for event in events {
                                    tr {
                                        td.time { (self.clock.time(event.t_s)) }
                                        td { @if let Some(vehicle) = event.vehicle { (self.sign(vehicle)) } }
                                        td { (severity(event.severity)) }
                                        td { (event.text) @if let Some(node) = event.node { span.quiet { " (node " (node) ")" } } }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn count(of: usize, what: &str) -> String {
    if of == 1 {
        format!("1 {what}")
    } else {
        format!("{of} {what}s")
    }
}

fn end(of: EndState) -> &'static str {
    match of {
        EndState::NeverFlew => "never flew",
        EndState::OnGround => "on the ground",
        EndState::InAir => "in the air",
        EndState::Lost => "lost",
    }
}

fn severity(of: Severity) -> Markup {
    let (class, word) = match of {
        Severity::Info => ("quiet", "info"),
        Severity::Advisory => ("advisory", "advisory"),
        Severity::Warning => ("word-warning", "warning"),
        Severity::Critical => ("word-critical", "critical"),
    };
    markup! { span.(class) { (word) } }
}
