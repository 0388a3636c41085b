//! What a model wants done, collected over one batch of events.

use crate::frames::FrameMut;
use serde::Serialize;
use skein_domain::exchange::{CommandProgress, Effect, EffectBatch, Severity};
use skein_domain::payload::{CoordinatorCapability, FrameHeader, MavlinkMessage};
use skein_domain::preflight::PreflightItem;
use skein_domain::{
    AnchorReference, AutopilotCommand, CommandId, FlightLimits, FlightState, Refusal, RequestId, Setpoint,
};

/// The effects of one batch, in the order they are to be carried out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects(Vec<Effect>);

/// Most batches have no more effects.
const USUAL_EFFECTS: usize = 3;

impl Effects {
    /// None yet, with room for as many as are usual.
    pub(crate) fn with_room() -> Self {
        Self(Vec::with_capacity(USUAL_EFFECTS))
    }

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

    /// The command has ended: done, or refused.
    pub fn ended(&mut self, id: CommandId, outcome: Result<(), Refusal>) {
        match outcome {
            Ok(()) => self.done(id),
            Err(refusal) => self.refused(id, refusal),
        }
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

    /// Reports the plugin's own state, as its state schema has it. A state that cannot be written as JSON (a map whose keys are no
    /// texts) is left out, with a line in the log.
    pub fn report<S: Serialize>(&mut self, state: &S) {
        match serde_json::to_string(state) {
            Ok(state_json) => self.push(Effect::Report { state_json }),
            Err(error) => crate::log::error!("the state cannot be written as JSON: {error}"),
        }
    }

    /// Tells of something that happened, as the plugin's event schema has it.
    pub fn occurrence<E: Serialize>(&mut self, event: &E) {
        match serde_json::to_string(event) {
            Ok(event_json) => self.push(Effect::Occurrence { event_json }),
            Err(error) => crate::log::error!("the event cannot be written as JSON: {error}"),
        }
    }

    /// Sends a MAVLink message to the vehicle's payload components.
    pub fn mavlink(&mut self, message_id: u32, payload: Vec<u8>) {
        self.push(Effect::Mavlink(MavlinkMessage {
            message_id,
            payload,
            ..MavlinkMessage::default()
        }));
    }

    /// Sends bytes on the payload's own transport.
    pub fn transmit(&mut self, bytes: Vec<u8>) {
        self.push(Effect::Transmit { bytes });
    }

    /// Asks a payload of the same vehicle; the result will carry `request`.
    pub fn payload_command<C: Serialize>(&mut self, request: RequestId, payload: &str, command: &C) {
        match serde_json::to_string(command) {
            Ok(command_json) => self.push(Effect::PayloadCommand {
                request,
                payload: payload.to_owned(),
                command_json,
            }),
            Err(error) => crate::log::error!("the command cannot be written as JSON: {error}"),
        }
    }

    /// Gives a frame away. `id` and `len` of the header are filled in.
    pub fn frame(&mut self, frame: FrameMut, header: FrameHeader) {
        let (id, len) = frame.into_id();
        self.push(Effect::Frame(FrameHeader { id, len, ..header }));
    }

    /// Says whether the vehicle can host the coordinator.
    pub fn capability(&mut self, capability: CoordinatorCapability) {
        self.push(Effect::Capability(capability));
    }

    /// Says what the vehicle can do.
    pub fn limits(&mut self, limits: FlightLimits) {
        self.push(Effect::Limits(limits));
    }

    /// Says what has to be looked at before the vehicle is armed; replaces what was said before. Ids begin with the plugin's name and a
    /// slash.
    pub fn preflight(&mut self, items: Vec<PreflightItem>) {
        self.push(Effect::Preflight(items));
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
