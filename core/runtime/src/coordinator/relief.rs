//! Relief, and coming back: a member that will soon have to return for its charge is sent home before it becomes urgent, and the others close up.
//!
//! Must never do: keep a vehicle in the formation that has to return; its failsafe policy sends it home by itself then.

use super::CoordinatorState;
use skein_coordination::Formation;
use skein_coordination::ways;
use skein_domain::exchange::Severity;
use skein_domain::{EnergyLevel, VehicleCommand};
use skein_state::VehicleMessage;
use skein_state::asks::{Ask, Order};
use skein_view::EventKind;
use skein_view::PeerSnapshot;

impl CoordinatorState {
    /// Takes those back whose failsafe policy held them and whose trouble is over.
    pub(super) fn take_back(&mut self, peers: &PeerSnapshot) {
        for entry in peers.entries.iter().filter(|e| e.may_rejoin) {
            if self.shared.vehicles.call_back(&[entry.id]) && !self.joins.contains(&entry.id) {
                self.joins.push(entry.id);
            }
        }
    }

    /// Sends members home whose charge comes to an end.
    pub(super) fn relieve(&self, formation: &Formation, peers: &PeerSnapshot) {
        let now = self.shared.now();
        for id in &formation.members {
            let energy = peers.entry(*id).and_then(|e| e.energy);
            let Some(energy) = energy.filter(|e| e.level == EnergyLevel::ReplanSoon) else {
                continue;
            };
            if !self.shared.vehicles.leave_out(*id) {
                continue;
            }
            let text = format!(
                "vehicle {id}: relieved, it must return within {:.0} s for its charge of {:.0} %",
                energy.return_in_s,
                energy.remaining * 100.0
            );
            self.shared
                .events
                .record(now, Some(*id), Severity::Advisory, EventKind::Formation, text);
            let command = VehicleCommand::Return;
            let legs = ways::legs(self.shared.gate().fences(), &self.shared.peers(), *id, &command).unwrap_or_default();
            if let Some(node) = self.shared.host(*id) {
                let order = Order {
                    vehicle: *id,
                    command,
                    legs,
                    delay_s: 0.0,
                    by_operator: false,
                    traceparent: None,
                };
                self.ask_elsewhere(node, Ask::Orders(vec![order]));
                continue;
            }
            let message = VehicleMessage::Command {
                id: self.shared.next_command_id(),
                command,
                legs,
                not_before: now,
                reply: None,
            };
            // Without its actor it goes on as it is; its failsafe policy is looked at by the next incarnation.
            if let Some(actor) = self.shared.vehicles.record(*id).and_then(|record| record.actor.get()) {
                let _ = actor.cast(message);
            }
        }
    }
}
