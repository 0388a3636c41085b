//! What went wrong, one line each.
//!
//! Must never do: hide one because there are many.

use super::Page;
use super::chart::mark_class;
use crate::facts::{Finding, FindingKind};
use maud::{Markup, html as markup};

impl Page<'_> {
    pub(super) fn findings(&self) -> Markup {
        let findings = &self.report.findings;
        markup! {
            section {
                h2 { "What went wrong" }
                @if findings.is_empty() {
                    p.none { "Nothing: no failsafe, no refusal, no loss of link, no takeover, no restart, no distance under the limit." }
                } @else {
                    p.quiet { "In order of time; the same again is one line with a count. The numbers stand on the map and in the charts." }
                    div.scroll {
                        table.findings {
                            thead { tr { th { "" } th { "Time" } th { "Vehicle" } th { "What" } th { "What was done" } } }
                            tbody { @for found in findings { (self.finding(found)) } }
                        }
                    }
                    @if self.report.findings_left_out > 0 {
                        p.quiet { (self.report.findings_left_out) " more of other kinds did not fit in." }
                    }
                }
            }
        }
    }

    fn finding(&self, found: &Finding) -> Markup {
        markup! {
            tr {
                td { span.(mark_class(found.severity)) { (found.number) } }
                td.time {
                    (self.clock.time(found.t_s))
                    @if found.count > 1 {
                        br; span.quiet { "to " (self.clock.time(found.last_s)) }
                    }
                }
                td { @if let Some(vehicle) = found.vehicle { (self.sign(vehicle)) } @else { span.quiet { "–" } } }
                td {
                    span.kind { (kind(found.kind)) }
                    (found.what)
                    @if found.count > 1 { " " span.count { "×" (found.count) } }
                }
                td.done {
                    @if found.done.is_empty() { span.quiet { "–" } }
                    @for (at, step) in found.done.iter().enumerate() {
                        @if at > 0 { br; }
                        @if step.t_s > found.t_s + 0.5 { span.quiet { (self.clock.time(step.t_s)) " " } }
                        (step.text)
                    }
                }
            }
        }
    }
}

fn kind(of: FindingKind) -> &'static str {
    match of {
        FindingKind::Failsafe => "failsafe",
        FindingKind::TooClose => "too close",
        FindingKind::Avoidance => "avoidance",
        FindingKind::EmergencyStop => "emergency stop",
        FindingKind::LinkLoss => "link",
        FindingKind::Takeover => "takeover",
        FindingKind::Restart => "restart",
        FindingKind::Refusal => "refusal",
        FindingKind::Setpoints => "setpoints",
        FindingKind::Warning => "warning",
    }
}
