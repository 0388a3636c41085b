//! What is told of the flight while it goes on: events and actions, the last one first.

use super::flight::{DRIFTS, at};
use skein_domain::exchange::{CommandProgress, Severity};
use skein_domain::{
    CommandId, FailsafeEvent, FailsafeEventKind, FlightMode, FlightState, Reaction, Refusal, Trigger, VehicleId,
};
use skein_recording::Audit;
use skein_view::{ActorStatus, EventKind, EventRecord};

fn event(t_s: f64, vehicle: u16, severity: Severity, kind: EventKind, text: &str) -> EventRecord {
    EventRecord {
        seq: (t_s * 10.0) as u64,
        time: at(t_s),
        node: None,
        vehicle: (vehicle > 0).then_some(VehicleId(vehicle)),
        severity,
        kind,
        text: text.into(),
    }
}

fn command(t_s: f64, id: u64, vehicle: u16, name: &str, progress: CommandProgress) -> EventRecord {
    let text = format!("{name}: {progress:?}");
    let kind = EventKind::Command {
        id: CommandId(id),
        command: name.into(),
        progress,
    };
    event(t_s, vehicle, Severity::Info, kind, &text)
}

fn failsafe(t_s: f64, kind: FailsafeEventKind, reaction: Reaction, error_m: f64) -> EventRecord {
    let step = FailsafeEvent {
        kind,
        trigger: Trigger::TrackingError,
        value: error_m,
        limit: 5.0,
        unit: "m".into(),
        since: at(t_s - 1.0),
        at: at(t_s),
        reaction,
        report_only: None,
        reason: format!("{error_m:.1} m from where its setpoint wants it, limit 5.0 m"),
    };
    let severity = if reaction == Reaction::Warn {
        Severity::Warning
    } else {
        Severity::Critical
    };
    event(
        t_s,
        DRIFTS.0,
        severity,
        EventKind::Failsafe { event: step },
        "Habicht: tracking error",
    )
}

#[expect(clippy::too_many_lines, reason = "one event after the other")]
pub fn events() -> Vec<EventRecord> {
    let restarts = |status, t_s: f64, severity| {
        let kind = EventKind::Supervision {
            actor: "payload-1-gimbal".into(),
            status,
        };
        event(
            t_s,
            1,
            severity,
            kind,
            "plugin of payload gimbal ended: it did not answer within 50 ms",
        )
    };
    let outside = || Refusal::OutsideFence {
        detail: "12.0 m into \"mast\"".into(),
    };
    let mut events: Vec<EventRecord> = (1..=4)
        .flat_map(|v| {
            let id = u64::from(v);
            let state = EventKind::FlightState {
                state: FlightState::Holding,
            };
            [
                command(1.0, id, v, "take_off", CommandProgress::Executing),
                command(8.2, id, v, "take_off", CommandProgress::Done),
                event(8.2, v, Severity::Info, state, "holding"),
            ]
        })
        .collect();
    events.extend([
        event(
            9.0,
            0,
            Severity::Info,
            EventKind::Formation,
            "wedge of 4 behind vehicle 1",
        ),
        command(19.0, 9, 2, "go_to", CommandProgress::Refused { refusal: outside() }),
        command(21.0, 10, 2, "go_to", CommandProgress::Refused { refusal: outside() }),
        restarts(ActorStatus::Restarting, 25.0, Severity::Warning),
        restarts(ActorStatus::Running, 25.8, Severity::Info),
        failsafe(33.0, FailsafeEventKind::Raised, Reaction::Warn, 5.2),
        failsafe(34.6, FailsafeEventKind::Escalated, Reaction::Hold, 7.6),
        failsafe(34.6, FailsafeEventKind::Ordered, Reaction::Hold, 7.6),
        failsafe(35.4, FailsafeEventKind::Effective, Reaction::Hold, 8.0),
        failsafe(40.2, FailsafeEventKind::Cleared, Reaction::Hold, 2.4),
        failsafe(41.0, FailsafeEventKind::TakenUp, Reaction::Hold, 2.0),
        event(
            34.0,
            4,
            Severity::Warning,
            EventKind::Avoidance,
            "Habicht: cannot keep its distance from vehicle 3, 2.4 m away",
        ),
        event(
            34.8,
            4,
            Severity::Warning,
            EventKind::Avoidance,
            "Habicht: cannot keep its distance from vehicle 3, 1.6 m away",
        ),
        event(
            45.5,
            2,
            Severity::Warning,
            EventKind::LinkLost,
            "Bussard is not heard any more",
        ),
        event(
            47.2,
            2,
            Severity::Info,
            EventKind::LinkRegained,
            "Bussard is heard again",
        ),
        taken_over(50.0),
    ]);
    events.sort_by_key(|event| std::cmp::Reverse(event.time));
    events
}

fn taken_over(t_s: f64) -> EventRecord {
    let kind = EventKind::TakenOver {
        failsafe: false,
        from: FlightMode::Offboard,
        to: FlightMode::Position,
    };
    event(t_s, 3, Severity::Warning, kind, "Falke was taken over by its pilot")
}

pub fn actions() -> Vec<Audit> {
    let action = |t_s: f64, who: &str, what: &str, with: &str, outcome: &str| Audit {
        time: at(t_s),
        who: who.into(),
        over: "api".into(),
        what: what.into(),
        with: with.into(),
        outcome: outcome.into(),
    };
    let mut actions = vec![
        action(
            0.9,
            "Ada",
            "POST /api/v1/commands",
            r#"{"command":"take_off","height_m":20}"#,
            "202",
        ),
        action(
            8.9,
            "Ada",
            "POST /api/v1/formations",
            r#"{"shape":"wedge","spacing_m":6}"#,
            "200",
        ),
        action(
            19.0,
            "",
            "POST /api/v1/vehicles/2/commands",
            r#"{"command":"go_to"}"#,
            "409 outside the fence",
        ),
        action(
            41.0,
            "Ada",
            "POST /api/v1/vehicles/4/commands",
            r#"{"command":"rejoin"}"#,
            "202",
        ),
        action(
            44.0,
            "Grace <grace@example.org>",
            "POST /api/v1/commands",
            r#"{"command":"land"}"#,
            "202",
        ),
    ];
    actions.sort_by_key(|action| std::cmp::Reverse(action.time));
    actions
}
