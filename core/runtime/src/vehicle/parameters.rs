//! Writing parameters of the autopilot: each write passes the gate, and each is an event, whatever became of it.
//!
//! Must never do: write one that no operator asked for, or repeat a write.

use super::VehicleState;
use skein_domain::exchange::Severity;
use skein_domain::{CommandId, NodeTime, ParameterError, ParameterEvent, ParameterValue};
use skein_safety::parameter::may_write;
use skein_state::ParameterOrder;
use skein_view::EventKind;
use std::collections::BTreeMap;

/// A write whose outcome its link has not told for so long, in seconds, is not waited for: the link was replaced.
const OUTCOME_WITHIN_S: f64 = 20.0;
/// Most writes that wait.
const OPEN_MAX: usize = 64;

struct Open {
    order: ParameterOrder,
    asked: NodeTime,
}

/// Writes whose outcome is open.
#[derive(Default)]
pub(super) struct Writes {
    open: BTreeMap<CommandId, Open>,
    /// The link was looked at since this incarnation began: an earlier one may have left something.
    looked: bool,
}

impl VehicleState {
    /// Begins a write, or says why it may not be.
    pub(super) fn write_parameter(&mut self, order: ParameterOrder) {
        let now = self.shared.now();
        let link = self.record.link();
        let (telemetry, _) = link.read(now);
        let state = self.record.state().flight_state;
        let permitted = match self.writes.open.len() < OPEN_MAX {
            true => may_write(&order.name, &telemetry, state),
            false => Err(ParameterError::Busy),
        };
        if let Err(error) = permitted {
            self.end_write(order, None, Err(error));
            return;
        }
        link.write_parameter(now, order.id, &order.name, order.value);
        self.writes.open.insert(order.id, Open { order, asked: now });
    }

    /// Says what became of writes.
    pub(super) fn tell_parameters(&mut self) {
        if self.writes.looked && self.writes.open.is_empty() {
            return;
        }
        self.writes.looked = true;
        for event in self.record.link().take_parameter_events() {
            self.tell_parameter(event);
        }
        let now = self.shared.now();
        let forgotten = |open: &Open| now.seconds_since(open.asked) > OUTCOME_WITHIN_S;
        let late = self.writes.open.extract_if(.., |_, open| forgotten(open));
        for (_, Open { order, asked }) in late.collect::<Vec<_>>() {
            let error = ParameterError::NoAnswer {
                name: order.name.clone(),
                after_s: now.seconds_since(asked),
            };
            self.end_write(order, None, Err(error));
        }
    }

    fn tell_parameter(&mut self, event: ParameterEvent) {
        let Some(id) = event.id else { return };
        match self.writes.open.remove(&id) {
            Some(Open { order, .. }) => self.end_write(order, event.before, event.outcome),
            // Asked of an incarnation that has ended: whoever asked was told so.
            None => self.record_write(&event.name, "", event.before, &event.outcome),
        }
    }

    fn end_write(
        &self,
        order: ParameterOrder,
        before: Option<ParameterValue>,
        outcome: Result<ParameterValue, ParameterError>,
    ) {
        self.record_write(&order.name, &order.by, before, &outcome);
        // Whoever asked may have given up waiting; the event log has it.
        let _ = order.reply.send(outcome.map(|now| (before, now)));
    }

    fn record_write(
        &self,
        name: &str,
        by: &str,
        before: Option<ParameterValue>,
        outcome: &Result<ParameterValue, ParameterError>,
    ) {
        let (severity, text) = words(&self.record.name, name, by, before, outcome);
        let kind = EventKind::Parameter { name: name.to_owned() };
        self.record(severity, kind, text);
    }
}

/// What the event log says of a write.
pub(crate) fn words(
    vehicle: &str,
    name: &str,
    by: &str,
    before: Option<ParameterValue>,
    outcome: &Result<ParameterValue, ParameterError>,
) -> (Severity, String) {
    let by = if by.is_empty() {
        String::new()
    } else {
        format!(" by {by}")
    };
    match outcome {
        Ok(now) => {
            let was = before.map_or_else(String::new, |before| format!(", was {before}"));
            let text = format!("{vehicle}: parameter {name} set to {now}{was}{by}");
            (Severity::Advisory, text)
        }
        Err(error) => {
            let text = format!("{vehicle}: parameter {name} not written{by}: {error}");
            (Severity::Warning, text)
        }
    }
}

#[cfg(test)]
mod tests {
    //! What the event log says of a write.

    use super::*;

    #[test]
    fn a_write_is_told_with_what_was_before_who_asked_and_why_not() {
        let (five, six) = (ParameterValue::Integer(5), ParameterValue::Integer(6));
        assert_eq!(
            words("px4-1", "A", "Anna", Some(five), &Ok(six)),
            (
                Severity::Advisory,
                "px4-1: parameter A set to 6, was 5 by Anna".to_owned()
            )
        );
        let armed = Err(ParameterError::Armed { name: "A".into() });
        let (severity, text) = words("px4-1", "A", "", None, &armed);
        assert_eq!(severity, Severity::Warning);
        assert!(
            text.starts_with("px4-1: parameter A not written: A is not written while"),
            "{text}"
        );
    }
}
