//! Carries out what a payload's plugin wants. Its messages to the vehicle's system pass the gate, and nothing else of it gets near a
//! link.

use super::PayloadState;
use crate::arming::own_items;
use skein_domain::exchange::{CommandProgress, Effect, Severity};
use skein_domain::payload::MavlinkMessage;
use skein_domain::{CommandId, Refusal};
use skein_plugin_host::Frame;
use skein_state::Report;
use skein_view::EventKind;
use std::sync::Arc;

/// A refusal of the same kind is told again after so long, in seconds.
const REFUSAL_REPEAT_S: f64 = 10.0;

impl PayloadState {
    /// Carries out the effects in order, and takes the frames.
    pub(super) fn carry_out(&mut self, effects: Vec<Effect>, frames: Vec<Arc<Frame>>) {
        for effect in effects {
            match effect {
                Effect::Mavlink(message) => self.send(&message),
                Effect::Transmit { bytes } => {
                    if self.transport.as_ref().is_none_or(|transport| !transport.send(bytes)) {
                        tracing::debug!(payload = %self.record.life.label, "a packet for the device was dropped");
                    }
                }
                Effect::Report { state_json } => self.report(&state_json),
                Effect::Occurrence { event_json } => self.occurrence(&event_json),
                Effect::CommandProgress { id, progress } => self.progress(id, progress),
                Effect::Notice { severity, text } => {
                    let text = format!("{}: {text}", self.record.life.label);
                    self.record(severity, EventKind::Notice, text);
                }
                // No manifest of a payload that names one of these is taken.
                Effect::Setpoint(_)
                | Effect::StopStream
                | Effect::Autopilot { .. }
                | Effect::State { .. }
                | Effect::Anchor(_)
                | Effect::TrackingError { .. }
                | Effect::RouteFinished
                | Effect::PayloadCommand { .. }
                | Effect::Frame(_)
                | Effect::Capability(_)
                | Effect::Limits(_) => {}
                Effect::Preflight(items) => {
                    self.record.change_state().preflight = own_items(&self.record.life.plugin().manifest().name, items);
                }
            }
        }
        let now = self.shared.now();
        for frame in frames {
            self.record.show_frame(now, frame);
        }
    }

    fn send(&mut self, message: &MavlinkMessage) {
        let now = self.shared.now();
        let sent = self
            .shared
            .gate()
            .payload_message(self.record.kind, self.vehicle.system_id, message)
            .and_then(|()| self.vehicle.link().send_payload(now, message));
        let Err(refusal) = sent else { return };
        if matches!(refusal, Refusal::LinkLost { .. }) {
            return; // Told by the vehicle itself.
        }
        let repeated = self
            .told_refusal
            .is_some_and(|(code, told)| code == refusal.code() && now.seconds_since(told) < REFUSAL_REPEAT_S);
        if !repeated {
            self.told_refusal = Some((refusal.code(), now));
            let text = format!(
                "{}: message {} refused: {refusal}",
                self.record.life.label, message.message_id
            );
            self.record(Severity::Warning, EventKind::Refused { refusal }, text);
        }
    }

    fn report(&self, state_json: &str) {
        let mut published = self.record.change_state();
        if published.report.as_ref().is_some_and(|r| r.json.as_ref() == state_json) {
            return;
        }
        // The host has held it against the plugin's schema, so that it parses.
        if let Ok(value) = serde_json::from_str(state_json) {
            published.report = Some(Report {
                json: Arc::from(state_json),
                value: Arc::new(value),
            });
            published.revision += 1;
        }
    }

    fn occurrence(&self, event_json: &str) {
        let Ok(event) = serde_json::from_str::<serde_json::Value>(event_json) else {
            return;
        };
        let text = format!("{}: {event}", self.record.life.label);
        let payload = Some(self.record.name.clone());
        self.record(Severity::Info, EventKind::Occurrence { payload, event }, text);
    }

    pub(super) fn progress(&mut self, id: CommandId, progress: CommandProgress) {
        if let CommandProgress::Refused { refusal } = &progress {
            self.refusal = Some((id, refusal.clone()));
        }
        let name = match progress {
            CommandProgress::Executing => self.commands.get(&id).cloned(),
            CommandProgress::Done | CommandProgress::Refused { .. } => self.commands.remove(&id),
        };
        let Some(name) = name else { return };
        let label = &self.record.life.label;
        let (severity, text) = match &progress {
            CommandProgress::Executing => (Severity::Info, format!("{label}: {name} taken up")),
            CommandProgress::Done => (Severity::Info, format!("{label}: {name} done")),
            CommandProgress::Refused {
                refusal: Refusal::Superseded,
            } => (Severity::Info, format!("{label}: {name} replaced by a newer command")),
            CommandProgress::Refused { refusal } => (Severity::Warning, format!("{label}: {name} refused: {refusal}")),
        };
        let kind = EventKind::Command {
            id,
            command: name,
            progress,
        };
        self.record(severity, kind, text);
    }

    fn record(&self, severity: Severity, kind: EventKind, text: String) {
        self.shared
            .events
            .record(self.shared.now(), Some(self.vehicle.id), severity, kind, text);
    }
}
