//! Parameters of a vehicle's autopilot: what is known of them is read from its link; a write goes through its actor, past the gate.
//!
//! Must never do: write a parameter of a vehicle over which another operator has control authority.

use super::NodeHandle;
use crate::vehicle::parameter_words;
use ractor::rpc::CallResult;
use serde::{Deserialize, Serialize};
use skein_domain::parameter::check_parameter_name;
use skein_domain::{ParameterError, ParameterList, ParameterValue, ReadingAction, Refusal, VehicleId};
use skein_state::{ParameterOrder, VehicleMessage};
use skein_view::EventKind;
use std::time::Duration;

/// Longest wait for a write: what its link takes to read and to write a parameter over a bad line.
const WRITTEN_WITHIN: Duration = Duration::from_secs(7);
/// So much of a console's id is shown where its name is not known.
const SHOWN_OF_ID: usize = 8;

/// A parameter that was written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ParameterReceipt {
    /// Its name.
    pub name: String,
    /// Its value now, as the autopilot says.
    pub value: ParameterValue,
    /// Its value before.
    pub before: Option<ParameterValue>,
}

impl NodeHandle {
    /// What is known of the parameters of one of this node's vehicles and has changed since a revision; 0 for all.
    ///
    /// # Errors
    /// When there is no such vehicle, or its link has no parameters.
    pub fn parameters(&self, vehicle: VehicleId, since: u64) -> Result<ParameterList, Refusal> {
        self.shared.vehicles.known(vehicle)?.link().parameters(since)
    }

    /// Begins to read all parameters of one of this node's vehicles, or ends that.
    ///
    /// # Errors
    /// When there is no such vehicle, it is not heard, or its link has no parameters.
    pub fn read_parameters(&self, vehicle: VehicleId, action: ReadingAction) -> Result<(), Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        record.link().read_parameters(self.now(), action)
    }

    /// Writes a parameter of one of this node's vehicles, from a console, and waits for the autopilot's answer.
    ///
    /// # Errors
    /// When another operator has control authority over it, it is armed, the value does not fit, or the autopilot keeps another one.
    pub async fn write_parameter(
        &self,
        console: Option<&str>,
        vehicle: VehicleId,
        name: &str,
        value: ParameterValue,
    ) -> Result<ParameterReceipt, ParameterError> {
        check_parameter_name(name)?;
        let record = self.shared.vehicles.known(vehicle)?;
        let by = self.called(console, vehicle);
        if let Err(refusal) = self.may_command(console, &[vehicle]) {
            let error = ParameterError::from(refusal);
            let (severity, text) = parameter_words(&record.name, name, &by, None, &Err(error.clone()));
            let kind = EventKind::Parameter { name: name.to_owned() };
            let now = self.now();
            self.shared.events.record(now, Some(vehicle), severity, kind, text);
            return Err(error);
        }
        let not_running = || Refusal::not_running(format!("actor of vehicle {vehicle}"));
        let actor = record.actor.get().ok_or_else(not_running)?;
        let id = self.shared.next_command_id();
        let order = |reply| {
            VehicleMessage::WriteParameter(ParameterOrder {
                id,
                name: name.to_owned(),
                value,
                by,
                reply,
            })
        };
        match actor.call(order, Some(WRITTEN_WITHIN)).await {
            Ok(CallResult::Success(outcome)) => outcome.map(|(before, value)| ParameterReceipt {
                name: name.to_owned(),
                value,
                before,
            }),
            Ok(CallResult::Timeout) => Err(ParameterError::NoAnswer {
                name: name.to_owned(),
                after_s: WRITTEN_WITHIN.as_secs_f64(),
            }),
            _ => Err(not_running().into()),
        }
    }

    /// What a console is called in the event log.
    fn called(&self, console: Option<&str>, vehicle: VehicleId) -> String {
        let Some(id) = console else { return String::new() };
        let table = self.shared.operators.control();
        match table.holder(vehicle).filter(|holder| holder.id == id) {
            Some(holder) => holder.name.clone(),
            None => format!("console {}", id.chars().take(SHOWN_OF_ID).collect::<String>()),
        }
    }
}
