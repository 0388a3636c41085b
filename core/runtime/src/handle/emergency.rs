//! The emergency stop: motors off at once, in flight too. It is guarded by two steps, and goes around actors and plugins straight to the
//! links: what must work when nothing else does waits for nobody.
//!
//! Must never do: happen by one call. Must never be asked for by a plugin.

use super::{NodeHandle, Targets};
use serde::{Deserialize, Serialize};
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime, Refusal, VehicleId};
use skein_state::asks::{Answer, Ask};
use skein_state::emergency::EMERGENCY_REQUEST;
use skein_view::{CommandReceipt, EventKind};
use std::collections::BTreeMap;
use std::time::Duration;

/// How long the stop stays unlocked, in seconds.
const UNLOCKED_S: f64 = 10.0;
/// Longest wait for another node's receipts.
const ELSEWHERE_WITHIN: Duration = Duration::from_secs(3);
/// The key of the second step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct EmergencyKey {
    /// To be given with the stop itself. Good for any number of vehicles until its time is over.
    pub key: String,
    /// For how long it is good, in seconds.
    pub valid_s: f64,
}

impl NodeHandle {
    /// The first step: unlocks the stop for some seconds.
    pub fn unlock_emergency_stop(&self) -> EmergencyKey {
        let now = self.now();
        // No secret: it only shows that somebody took the first step just now.
        let key = format!("{:08x}", now.0.wrapping_mul(0x9E37_79B9) & 0xFFFF_FFFF);
        let until = now.plus_seconds(UNLOCKED_S);
        self.shared().operators.unlock_emergency_stop(key.clone(), until);
        let text = format!("emergency stop unlocked for {UNLOCKED_S:.0} s");
        self.shared()
            .events
            .record(now, None, Severity::Warning, EventKind::EmergencyStop, text);
        EmergencyKey {
            key,
            valid_s: UNLOCKED_S,
        }
    }

    /// The second step: stops the motors of these vehicles now. They fall. A receipt says whether it was sent; whether the motors stopped
    /// is told as an event, after 1 s too if it is not known by then.
    ///
    /// # Errors
    /// Without the key of a first step that is not too long ago. Each vehicle answers for itself otherwise.
    pub async fn emergency_stop(&self, key: &str, targets: &Targets) -> Result<Vec<CommandReceipt>, Refusal> {
        let now = self.now();
        if !self.shared().operators.is_emergency_key(key, now) {
            return Err(Refusal::not_permitted(format!(
                "emergency stop without the key of an unlocking in the last {UNLOCKED_S:.0} s"
            )));
        }
        let ids = match targets {
            Targets::All => self.shared().vehicle_ids(),
            Targets::Vehicles(ids) => ids.clone(),
        };
        let mut elsewhere: BTreeMap<NodeId, Vec<VehicleId>> = BTreeMap::new();
        for id in &ids {
            if let Some(node) = self.shared().host(*id) {
                elsewhere.entry(node).or_default().push(*id);
            }
        }
        let here: Vec<VehicleId> = ids.into_iter().filter(|id| self.shared().host(*id).is_none()).collect();
        // Those that can be reached without asking first.
        let mut receipts = self.stop_motors_here(&here);
        let asked: Vec<_> = elsewhere
            .into_iter()
            .map(|(node, ids)| {
                let handle = self.clone();
                tokio::spawn(async move { handle.stop_motors_elsewhere(node, ids).await })
            })
            .collect();
        for answer in asked {
            receipts.extend(answer.await.unwrap_or_default());
        }
        Ok(receipts)
    }

    /// Stops the motors of this node's own vehicles.
    pub(crate) fn stop_motors_here(&self, ids: &[VehicleId]) -> Vec<CommandReceipt> {
        let now = self.now();
        ids.iter().map(|id| self.stop_motors(*id, now)).collect()
    }

    async fn stop_motors_elsewhere(&self, node: NodeId, ids: Vec<VehicleId>) -> Vec<CommandReceipt> {
        match self.ask(node, Ask::EmergencyStop(ids.clone()), ELSEWHERE_WITHIN).await {
            Ok(Answer::Receipts(receipts)) => receipts,
            Ok(_) => Vec::new(),
            Err(refusal) => {
                let refused = |vehicle| CommandReceipt {
                    vehicle,
                    id: self.shared().next_command_id(),
                    refusal: Some(refusal.clone()),
                };
                ids.into_iter().map(refused).collect()
            }
        }
    }

    fn stop_motors(&self, vehicle: VehicleId, now: NodeTime) -> CommandReceipt {
        let id = self.shared().next_command_id();
        let Some(record) = self.shared().vehicles.record(vehicle) else {
            let refusal = Some(Refusal::UnknownVehicle { vehicle });
            return CommandReceipt { vehicle, id, refusal };
        };
        record.set_stopped(true);
        // Also to a vehicle that is not heard: it may hear.
        let refusal = record.link().stop_motors(now, EMERGENCY_REQUEST).err();
        self.shared().vehicles.withdraw(&record);
        let text = match &refusal {
            None => format!("{}: EMERGENCY STOP sent", record.name),
            Some(refusal) => format!("{}: EMERGENCY STOP: {refusal}", record.name),
        };
        self.shared()
            .events
            .record(now, Some(vehicle), Severity::Critical, EventKind::EmergencyStop, text);
        CommandReceipt { vehicle, id, refusal }
    }
}
