//! Who belongs to the formation: members that have left it, vehicles that fly along without belonging, newcomers from the ground.

use super::CoordinatorState;
use crate::board::{PeerEntry, PeerSnapshot};
use crate::coordination::Formation;
use skein_domain::{FlightState, NodeTime, VehicleId};

/// A member that has not taken up its task after so long, in seconds, has left the formation.
const TAKE_UP_S: f64 = 1.5;

impl CoordinatorState {
    /// Whether the leader has to be replaced at once: not heard, or not in the swarm's hands any more.
    pub(super) fn lost_leader(&self, formation: &Formation, peers: &PeerSnapshot, now: NodeTime) -> Option<VehicleId> {
        let leader = formation.leader?;
        let fit = peers.entry(leader).is_some_and(|entry| {
            entry.link.connected && !self.is_silent(entry, now) && entry.flight_state.is_available_in_air()
        });
        (!fit).then_some(leader)
    }

    fn is_silent(&self, entry: &PeerEntry, now: NodeTime) -> bool {
        now.seconds_since(entry.link.last_heard) > self.board.config.coordinator.leader_lost_after_s
    }

    /// Whether a member cannot be counted on any more.
    pub(super) fn has_left(&self, formation: &Formation, id: VehicleId, peers: &PeerSnapshot, now: NodeTime) -> bool {
        let Some(entry) = peers.entry(id) else { return true };
        if self.board.withdrawn.lock().contains(&id) {
            return true;
        }
        let leads = formation.leader == Some(id);
        if !entry.link.connected || (leads && self.is_silent(entry, now)) {
            return true;
        }
        let wanted = if leads {
            FlightState::Leading
        } else {
            FlightState::Following
        };
        if entry.flight_state == wanted {
            return false;
        }
        // Holding may mean that the task has not been taken up yet; anything not available in the air is gone at once.
        !entry.flight_state.is_available_in_air() || now.seconds_since(formation.decided) > TAKE_UP_S
    }

    /// Vehicles that fly in the formation without belonging to it: taken out for a command that they then refused.
    pub(super) fn strays(&self, formation: &Formation, peers: &PeerSnapshot) -> Vec<VehicleId> {
        let withdrawn = self.board.withdrawn.lock();
        let flies_along = |state| matches!(state, FlightState::Following | FlightState::Leading);
        let entries = peers.entries.iter().filter(|e| flies_along(e.flight_state));
        let stray = |id: &VehicleId| !formation.members.contains(id) && !withdrawn.contains(id);
        entries.map(|e| e.id).filter(stray).collect()
    }

    /// Vehicles that have just come up from the ground.
    pub(super) fn newcomers(&self, peers: &PeerSnapshot) -> Vec<VehicleId> {
        let mut coordination = self.board.coordination.lock();
        let mut newcomers = Vec::new();
        for entry in &peers.entries {
            let was = coordination.taking_off.contains(&entry.id);
            match entry.flight_state {
                FlightState::TakingOff if !was => coordination.taking_off.push(entry.id),
                FlightState::TakingOff => {}
                FlightState::Holding if was => {
                    coordination.taking_off.retain(|id| *id != entry.id);
                    newcomers.push(entry.id);
                }
                _ if was => coordination.taking_off.retain(|id| *id != entry.id),
                _ => {}
            }
        }
        newcomers
    }
}
