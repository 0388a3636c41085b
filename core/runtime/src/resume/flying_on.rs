//! Going on with what was flown before a restart: the formation is planned anew from where its members are, as one that was interrupted, and
//! what operators had commanded is commanded again.
//!
//! Must never do: bring anybody into a formation who is not in the swarm's hands, or whom an operator has commanded since.

use crate::board::Board;
use crate::coordination::{Interrupted, available};
use crate::handle::NodeHandle;
use crate::snapshot::EventKind;
use skein_domain::exchange::Severity;
use skein_domain::{VehicleCommand, VehicleId};
use std::collections::BTreeSet;

/// Who can be flown now.
pub fn in_hand(board: &Board) -> BTreeSet<VehicleId> {
    available(&board.peers.load()).into_iter().collect()
}

/// Says what became of the vehicles.
pub fn tell(board: &Board, taken: &BTreeSet<VehicleId>, then: &str) {
    let now = board.now();
    let left = board.resume.left();
    for one in &left {
        let text = format!("vehicle {} is not taken back: {}", one.vehicle, one.why);
        let events = &board.events;
        events.record(now, Some(one.vehicle), Severity::Warning, EventKind::Notice, text);
    }
    let text = format!(
        "this node ended in flight and has started again: {} of {} vehicles taken back; {then}",
        taken.len(),
        taken.len() + left.len()
    );
    board
        .events
        .record(now, None, Severity::Critical, EventKind::Notice, text);
}

/// Goes on; whether there was anything to go on with.
pub async fn fly_on(handle: &NodeHandle) -> bool {
    let board = handle.board();
    let taken = board.resume.taken();
    let Some(flown) = board.resume.end() else { return false };
    if let Some(formation) = flown.formation {
        let withdrawn = board.withdrawn.lock().clone();
        let mut who = in_hand(board);
        who.retain(|id| !withdrawn.contains(id));
        let mut coordination = board.coordination.lock();
        if coordination.formation.is_none() && coordination.interrupted.is_none() {
            coordination.interrupted = of(formation, &who);
        }
    }
    let mut commands: Vec<(VehicleCommand, Vec<VehicleId>)> = Vec::new();
    for (id, command) in flown.vehicles {
        // A stick from before is not followed.
        let Some(command) = command.filter(|command| taken.contains(&id) && *command != VehicleCommand::Steer) else {
            continue;
        };
        match commands.iter_mut().find(|(known, _)| *known == command) {
            Some((_, ids)) => ids.push(id),
            None => commands.push((command, vec![id])),
        }
    }
    for (command, ids) in commands {
        // Who refuses has said so in the event log.
        handle.command_again(&ids, command).await;
    }
    true
}

/// The formation for those who are there of it; none if nobody is.
pub fn of(mut formation: Interrupted, who: &BTreeSet<VehicleId>) -> Option<Interrupted> {
    formation.missing.retain(|id| who.contains(id));
    if let Some(named) = &mut formation.request.members {
        named.retain(|id| who.contains(id));
    }
    formation.request.leader = formation.request.leader.filter(|id| who.contains(id));
    (!formation.missing.is_empty()).then_some(formation)
}
