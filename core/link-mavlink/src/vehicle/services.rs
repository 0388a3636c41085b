//! What is asked of a vehicle that moves nothing: messages of payloads, parameters.
//!
//! Must never do: send a command that flies or arms.

use super::parameters::{ParameterMessage, Parameters};
use super::{AUTOPILOT_COMPONENT, VehicleCore};
use skein_domain::payload::MavlinkMessage;
use skein_domain::{CommandId, NodeTime, ParameterError, ParameterValue, ReadingAction, Refusal};

impl VehicleCore {
    /// Its parameters.
    pub fn parameters(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Sends a message of a payload; nobody waits for an answer here.
    ///
    /// # Errors
    /// When another vehicle would take it as well, the link is lost, or it is no message that is known here.
    pub fn send_payload(&mut self, now: NodeTime, message: &MavlinkMessage) -> Result<(), Refusal> {
        match self.refusal(now, false) {
            Some(refusal) => Err(refusal),
            None => self.outbox.push_payload(message.message_id, &message.payload),
        }
    }

    /// Reads a parameter anew, or writes it.
    ///
    /// # Errors
    /// If it can be said at once that it will not work.
    pub fn parameter(
        &mut self,
        now: NodeTime,
        name: &str,
        value: Option<ParameterValue>,
    ) -> Result<(), ParameterError> {
        if let Some(refusal) = self.refusal(now, false) {
            return Err(refusal.into());
        }
        self.parameters.start(now, name, value)?;
        self.send_parameters(now);
        Ok(())
    }

    /// Writes a parameter; the outcome comes as an event of its parameters.
    pub fn write_parameter(&mut self, now: NodeTime, id: CommandId, name: &str, value: ParameterValue) {
        match self.refusal(now, false) {
            Some(refusal) => self.parameters.refuse(id, name, refusal.into()),
            None => {
                self.parameters.write(now, id, name, value);
                self.send_parameters(now);
            }
        }
    }

    /// Begins to read all parameters, or ends that.
    ///
    /// # Errors
    /// When another vehicle would answer as well, or the link is lost.
    pub fn read_parameters(&mut self, now: NodeTime, action: ReadingAction) -> Result<(), Refusal> {
        if let Some(refusal) = self.refusal(now, false).filter(|_| action != ReadingAction::Stop) {
            return Err(refusal);
        }
        self.parameters.read_all(now, action);
        self.send_parameters(now);
        Ok(())
    }

    pub(super) fn send_parameters(&mut self, now: NodeTime) {
        match self.parameters.poll(now, (self.system_id, AUTOPILOT_COMPONENT)) {
            Some(ParameterMessage::List(message)) => self.outbox.push(&message),
            Some(ParameterMessage::Read(message)) => self.outbox.push(&message),
            Some(ParameterMessage::Set(message)) => self.outbox.push(&message),
            None => {}
        }
    }
}
