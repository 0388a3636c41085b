//! The sentences that an operator reads.

use super::Health;
use skein_domain::{Alarm, FailsafeEvent, FailsafeEventKind, NodeTime, ReportOnly, Trigger};

/// An event about a trigger.
pub(super) fn event(kind: FailsafeEventKind, alarm: &Alarm, at: NodeTime, health: &Health) -> FailsafeEvent {
    FailsafeEvent {
        kind,
        trigger: alarm.trigger,
        value: alarm.value,
        limit: alarm.limit,
        unit: alarm.unit.clone(),
        since: alarm.since,
        at,
        reaction: alarm.reaction,
        report_only: alarm.report_only,
        reason: reason(kind, alarm, health),
    }
}

fn reason(kind: FailsafeEventKind, alarm: &Alarm, health: &Health) -> String {
    let what = title(alarm.trigger);
    let mut text = match (alarm.trigger, &health.breach, &health.energy) {
        (Trigger::FenceBreach, Some(breach), _) => format!("{what} \"{}\" by {:.1} m", breach.zone, breach.outside_m),
        (Trigger::Energy, _, Some(energy)) => format!(
            "{what}: {}, {:.0} % left, {:.0} % over what home and reserve take",
            energy.level,
            energy.remaining * 100.0,
            energy.margin * 100.0
        ),
        _ => {
            let (value, limit, unit) = (alarm.value, alarm.limit, &alarm.unit);
            format!("{what}: {value:.2} {unit}, limit {limit:.2} {unit}")
        }
    };
    if kind == FailsafeEventKind::Cleared {
        return format!("over: {}", title(alarm.trigger));
    }
    text.push_str(match alarm.report_only {
        Some(ReportOnly::OnGround) => " (reported only: on the ground)",
        Some(ReportOnly::PilotInControl) => " (reported only: the pilot flies)",
        Some(ReportOnly::WarnOnly) => " (reported only: as configured)",
        Some(ReportOnly::Overruled) => " (reported only: an operator overruled it)",
        Some(ReportOnly::Landing) => " (reported only: it lands)",
        None => "",
    });
    text
}

/// A trigger in words.
pub(super) fn title(trigger: Trigger) -> &'static str {
    match trigger {
        Trigger::LinkLoss => "not heard",
        Trigger::GnssLoss => "no satellite fix",
        Trigger::GnssDisagreement => "sources of the position disagree",
        Trigger::TrackingError => "away from where it should be",
        Trigger::StaleEstimate => "position is old",
        Trigger::ClockFault => "clocks jumped or drift",
        Trigger::FenceBreach => "outside of the fence",
        Trigger::CoordinatorLoss => "no coordinator",
        Trigger::OperatorDeadMan => "no sign of life of an operator",
        Trigger::Energy => "charge",
    }
}
