//! Payloads at run time: commanded, attached, detached, their frames; and what is tracked.

use super::super::NodeHandle;
use super::not_running;
use crate::fleet::FleetMessage;
use ractor::rpc::CallResult;
use skein_config::PayloadRule;
use skein_domain::payload::{FIRST_FUSED_TRACK, Track};
use skein_domain::{CommandId, Refusal, VehicleId};
use skein_plugin_host::Frame;
use skein_state::{Asker, PayloadMessage};
use skein_view::CommandReceipt;
use std::sync::Arc;
use std::time::Duration;

/// Longest wait for a payload's answer: its plugin may have to be started for it.
const ANSWER_WITHIN: Duration = Duration::from_secs(3);

impl NodeHandle {
    /// Gives a command to a payload; it has to fit the command schema of the payload's plugin.
    pub async fn command_payload(
        &self,
        vehicle: VehicleId,
        payload: &str,
        command: &serde_json::Value,
    ) -> CommandReceipt {
        let id = self.shared.next_command_id();
        let refusal = match self.ask_payload(id, vehicle, payload, command).await {
            Ok(receipt) => return receipt,
            Err(refusal) => Some(refusal),
        };
        CommandReceipt { vehicle, id, refusal }
    }

    async fn ask_payload(
        &self,
        id: CommandId,
        vehicle: VehicleId,
        payload: &str,
        command: &serde_json::Value,
    ) -> Result<CommandReceipt, Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        let actor = record.known_payload(payload)?.actor.get();
        let actor = actor.ok_or_else(|| not_running(vehicle, Some(payload)))?;
        let command_json = command.to_string();
        let message = |reply| PayloadMessage::Command {
            id,
            command_json,
            asker: Asker::Operator(reply),
        };
        match actor.call(message, Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(receipt)) => Ok(receipt),
            Ok(CallResult::Timeout) => Err(Refusal::timed_out(
                format!("payload {payload} of vehicle {vehicle}"),
                ANSWER_WITHIN.as_secs_f64(),
            )),
            _ => Err(not_running(vehicle, Some(payload))),
        }
    }

    /// Puts a payload on a vehicle.
    ///
    /// # Errors
    /// When there is no such vehicle, or the rule cannot be.
    pub async fn attach_payload(&self, vehicle: VehicleId, rule: PayloadRule) -> Result<(), Refusal> {
        self.ask_fleet(|reply| FleetMessage::Attach(vehicle, Box::new(rule), reply))
            .await
    }

    /// Takes a payload off a vehicle.
    ///
    /// # Errors
    /// When there is no such vehicle or payload.
    pub async fn detach_payload(&self, vehicle: VehicleId, payload: String) -> Result<(), Refusal> {
        self.ask_fleet(|reply| FleetMessage::Detach(vehicle, payload, reply))
            .await
    }

    async fn ask_fleet(
        &self,
        message: impl FnOnce(ractor::RpcReplyPort<Result<(), Refusal>>) -> FleetMessage,
    ) -> Result<(), Refusal> {
        let gone = || Refusal::not_running("the fleet");
        let fleet = self.parts.fleet.load_full().ok_or_else(gone)?;
        match fleet.call(message, Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(answer)) => answer,
            _ => Err(gone()),
        }
    }

    /// The last frame of a payload; none if it has given none yet.
    ///
    /// # Errors
    /// When there is no such vehicle or payload.
    pub fn payload_frame(&self, vehicle: VehicleId, payload: &str) -> Result<Option<Arc<Frame>>, Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        Ok(record.known_payload(payload)?.frame())
    }

    /// Replaces what is tracked. Models and payloads are told with their next batch.
    ///
    /// # Errors
    /// When a number is not finite, one track is there twice, or has the number of one that the swarm makes itself.
    pub fn set_tracks(&self, tracks: Vec<Track>) -> Result<(), Refusal> {
        let mut seen = std::collections::BTreeSet::new();
        for track in &tracks {
            if !track.position.is_finite() || !track.velocity.is_finite() {
                return Err(Refusal::invalid(format!("track {} is not finite", track.track)));
            }
            if track.track >= FIRST_FUSED_TRACK {
                return Err(Refusal::invalid(format!(
                    "track {}: numbers from {FIRST_FUSED_TRACK} up are those of tracks that the swarm makes itself",
                    track.track
                )));
            }
            if !seen.insert(track.track) {
                return Err(Refusal::invalid(format!("track {} is there twice", track.track)));
            }
        }
        self.shared.observed.tell_tracks(tracks);
        Ok(())
    }
}
