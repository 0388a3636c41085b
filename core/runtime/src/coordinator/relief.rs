//! Relief, and coming back: a member that will soon have to return for its charge is sent home before it becomes urgent, and the others close up.
//!
//! Must never do: keep a vehicle in the formation that has to return; its ladder sends it home by itself then.

use super::CoordinatorState;
use crate::board::PeerSnapshot;
use crate::coordination::Formation;
use crate::snapshot::EventKind;
use crate::vehicle::VehicleMessage;
use crate::ways;
use skein_domain::exchange::Severity;
use skein_domain::{EnergyLevel, VehicleCommand};

impl CoordinatorState {
    /// Takes those back whose ladder held them and whose trouble is over.
    pub(super) fn take_back(&mut self, peers: &PeerSnapshot) {
        for entry in peers.entries.iter().filter(|e| e.may_rejoin) {
            if self.board.withdrawn.lock().remove(&entry.id) && !self.joins.contains(&entry.id) {
                self.joins.push(entry.id);
            }
        }
    }

    /// Sends members home whose charge comes to an end.
    pub(super) fn relieve(&self, formation: &Formation, peers: &PeerSnapshot) {
        let now = self.board.now();
        for id in &formation.members {
            let energy = peers.entry(*id).and_then(|e| e.energy);
            let Some(energy) = energy.filter(|e| e.level == EnergyLevel::ReplanSoon) else {
                continue;
            };
            if !self.board.withdrawn.lock().insert(*id) {
                continue;
            }
            let Some(cell) = self.board.cell(*id) else { continue };
            let text = format!(
                "{}: relieved, it must return within {:.0} s for its charge of {:.0} %",
                cell.name,
                energy.return_in_s,
                energy.remaining * 100.0
            );
            self.board
                .events
                .record(now, Some(*id), Severity::Advisory, EventKind::Formation, text);
            let command = VehicleCommand::Return;
            let message = VehicleMessage::Command {
                id: self.board.next_command_id(),
                command,
                legs: ways::legs(&self.board, *id, &command).unwrap_or_default(),
                not_before: now,
                reply: None,
            };
            // Without its actor it goes on as it is; its ladder is looked at by the next incarnation.
            if let Some(actor) = cell.actor.load_full() {
                let _ = actor.cast(message);
            }
        }
    }
}
