//! Who belongs to a formation: members that have left it, vehicles that fly along without belonging, newcomers from the ground, a leader
//! that has to be replaced.
//!
//! Must never do: decide what becomes of them.

use crate::formation::{Formation, available};
use crate::state::Coordination;
use skein_domain::{FlightState, NodeTime, VehicleId};
use skein_view::PeerSnapshot;
use std::collections::BTreeSet;

/// A member that has not taken up its task after so long, in seconds, has left the formation.
const TAKE_UP_S: f64 = 1.5;

/// What a formation's members are judged by.
#[derive(Debug, Clone, Copy)]
pub struct Judging<'a> {
    /// Everyone in this period.
    pub peers: &'a PeerSnapshot,
    /// Who was taken out by an operator.
    pub withdrawn: &'a BTreeSet<VehicleId>,
    /// A leader not heard for so long is replaced, in seconds.
    pub leader_lost_after_s: f64,
    /// How long the formation's leader has not been heard, in seconds, without the time in which this computer stood still.
    pub leader_silence_s: f64,
    /// Now.
    pub now: NodeTime,
}

/// A formation whose members are others now, or that is not in the shape that was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Changed {
    /// Who is to be in it from now on.
    pub members: Vec<VehicleId>,
    /// Who has left.
    pub gone: Vec<VehicleId>,
    /// Who has come, or comes along.
    pub joins: Vec<VehicleId>,
}

impl Judging<'_> {
    /// Whether the leader has to be replaced at once: not heard, or not under the swarm's control any more.
    #[must_use]
    pub fn lost_leader(&self, formation: &Formation) -> Option<VehicleId> {
        let leader = formation.leader?;
        let fit = self.peers.entry(leader).is_some_and(|entry| {
            let heard = entry.link.connected && !self.leader_is_silent();
            heard && !entry.under_order && entry.flight_state.is_available_in_air()
        });
        (!fit).then_some(leader)
    }

    fn leader_is_silent(&self) -> bool {
        self.leader_silence_s > self.leader_lost_after_s
    }

    /// Whether a member cannot be counted on any more.
    #[must_use]
    pub fn has_left(&self, formation: &Formation, id: VehicleId) -> bool {
        let Some(entry) = self.peers.entry(id) else { return true };
        if self.withdrawn.contains(&id) {
            return true;
        }
        let leads = formation.leader == Some(id);
        if !entry.link.connected || entry.under_order || (leads && self.leader_is_silent()) {
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
        !entry.flight_state.is_available_in_air() || self.now.seconds_since(formation.decided) > TAKE_UP_S
    }

    /// Vehicles that fly in the formation without belonging to it: taken out for a command that they then refused.
    #[must_use]
    pub fn strays(&self, formation: &Formation) -> Vec<VehicleId> {
        let flies_along = |state| matches!(state, FlightState::Following | FlightState::Leading);
        let entries = self
            .peers
            .entries
            .iter()
            .filter(|e| flies_along(e.flight_state) && !e.under_order);
        let stray = |id: &VehicleId| !formation.members.contains(id) && !self.withdrawn.contains(id);
        entries.map(|e| e.id).filter(stray).collect()
    }

    /// Who is to be in the formation from now on, if that is not who is in it, or if it is to be laid out anew anyway. `waiting` are
    /// newcomers that wait for a place.
    #[must_use]
    pub fn changed(&self, formation: &Formation, waiting: &[VehicleId], reshape: bool) -> Option<Changed> {
        let ids = formation.members.iter().copied();
        let gone: Vec<VehicleId> = ids.filter(|id| self.has_left(formation, *id)).collect();
        // Who is not heard any more is no newcomer: it would be planned for, and left out, in every review.
        let present = available(self.peers);
        let mut joins: Vec<VehicleId> = waiting.to_vec();
        joins.extend(self.strays(formation));
        joins.retain(|id| present.contains(id) && !self.withdrawn.contains(id));
        if gone.is_empty() && joins.is_empty() && !reshape {
            return None;
        }
        let ids = formation.members.iter().copied();
        let mut members: Vec<VehicleId> = ids.filter(|id| !gone.contains(id)).collect();
        members.extend(joins.iter().filter(|id| !formation.members.contains(id)));
        members.retain(|id| present.contains(id) && !self.withdrawn.contains(id));
        Some(Changed { members, gone, joins })
    }
}

impl Coordination {
    /// Vehicles that have just come up from the ground. To be asked every review: it remembers who was seen taking off.
    pub fn newcomers(&mut self, peers: &PeerSnapshot) -> Vec<VehicleId> {
        let mut newcomers = Vec::new();
        for entry in &peers.entries {
            let was = self.taking_off.contains(&entry.id);
            match entry.flight_state {
                FlightState::TakingOff if !was => self.taking_off.push(entry.id),
                FlightState::TakingOff => {}
                FlightState::Holding if was => {
                    self.taking_off.retain(|id| *id != entry.id);
                    newcomers.push(entry.id);
                }
                _ if was => self.taking_off.retain(|id| *id != entry.id),
                _ => {}
            }
        }
        newcomers
    }
}
