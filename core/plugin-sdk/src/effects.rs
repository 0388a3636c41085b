//! What a model wants done, collected over one batch of events.

use skein_domain::exchange::{CommandProgress, Effect, EffectBatch, Severity};
use skein_domain::{AnchorReference, AutopilotCommand, CommandId, FlightState, Refusal, RequestId, Setpoint};

/// The effects of one batch, in the order they are to be carried out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects(Vec<Effect>);

impl Effects {
    /// Any effect.
    pub fn push(&mut self, effect: Effect) {
        self.0.push(effect);
    }

    /// Streams a setpoint.
    pub fn setpoint(&mut self, setpoint: Setpoint) {
        self.push(Effect::Setpoint(setpoint));
    }

    /// Ends the stream on purpose.
    pub fn stop_stream(&mut self) {
        self.push(Effect::StopStream);
    }

    /// Asks the autopilot; the result will carry `request`.
    pub fn autopilot(&mut self, request: RequestId, command: AutopilotCommand) {
        self.push(Effect::Autopilot { request, command });
    }

    /// The command is being carried out.
    pub fn executing(&mut self, id: CommandId) {
        self.push(Effect::CommandProgress {
            id,
            progress: CommandProgress::Executing,
        });
    }

    /// What the command asked for is the case.
    pub fn done(&mut self, id: CommandId) {
        self.push(Effect::CommandProgress {
            id,
            progress: CommandProgress::Done,
        });
    }

    /// The command is not carried out, or broken off.
    pub fn refused(&mut self, id: CommandId, refusal: Refusal) {
        self.push(Effect::CommandProgress {
            id,
            progress: CommandProgress::Refused { refusal },
        });
    }

    /// The flight state changed.
    pub fn state(&mut self, state: FlightState, detail: impl Into<String>) {
        self.push(Effect::State {
            state,
            detail: detail.into(),
        });
    }

    /// Publishes the anchor that followers use.
    pub fn anchor(&mut self, anchor: AnchorReference) {
        self.push(Effect::Anchor(anchor));
    }

    /// Tells the operator something, in one sentence.
    pub fn notice(&mut self, severity: Severity, text: impl Into<String>) {
        self.push(Effect::Notice {
            severity,
            text: text.into(),
        });
    }

    /// How far the vehicle is from where its task wants it.
    pub fn tracking_error(&mut self, distance_m: f64) {
        self.push(Effect::TrackingError { distance_m });
    }

    /// The leader has come to the end of its route.
    pub fn route_finished(&mut self) {
        self.push(Effect::RouteFinished);
    }

    /// What was collected so far.
    #[must_use]
    pub fn as_slice(&self) -> &[Effect] {
        &self.0
    }

    /// What was collected, taken out.
    #[must_use]
    pub fn take(&mut self) -> Vec<Effect> {
        std::mem::take(&mut self.0)
    }

    /// What was collected, as it crosses.
    #[must_use]
    pub fn into_batch(self) -> EffectBatch {
        EffectBatch { effects: self.0 }
    }
}

impl Extend<Effect> for Effects {
    fn extend<I: IntoIterator<Item = Effect>>(&mut self, effects: I) {
        self.0.extend(effects);
    }
}
