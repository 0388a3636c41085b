//! Going on with what was flown before a restart: the formation is planned anew from where its members are, as one that was interrupted, and
//! what operators had commanded is commanded again.
//!
//! Must never do: bring anybody into a formation who is not under the swarm's control, or whom an operator has commanded since.

use super::NodeHandle;
use skein_coordination::{Interrupted, available};
use skein_domain::exchange::Severity;
use skein_domain::{VehicleCommand, VehicleId};
use skein_state::SharedState;
use skein_view::EventKind;
use std::collections::BTreeSet;

/// Who can be flown now.
pub fn under_control(shared: &SharedState) -> BTreeSet<VehicleId> {
    available(&shared.peers()).into_iter().collect()
}

/// Says what became of the vehicles.
pub fn tell(shared: &SharedState, taken: &BTreeSet<VehicleId>, then: &str) {
    let now = shared.now();
    let left = shared.resume.left();
    for one in &left {
        let text = format!("vehicle {} is not taken back: {}", one.vehicle, one.why);
        let events = &shared.events;
        events.record(now, Some(one.vehicle), Severity::Warning, EventKind::Notice, text);
    }
    let text = format!(
        "this node ended in flight and has started again: {} of {} vehicles taken back; {then}",
        taken.len(),
        taken.len() + left.len()
    );
    shared
        .events
        .record(now, None, Severity::Critical, EventKind::Notice, text);
}

/// Goes on; whether there was anything to go on with.
pub async fn fly_on(handle: &NodeHandle) -> bool {
    let shared = handle.shared();
    let taken = shared.resume.taken();
    let Some(flown) = shared.resume.end() else { return false };
    if let Some(formation) = flown.formation {
        let withdrawn = shared.vehicles.withdrawn();
        let mut who = under_control(shared);
        who.retain(|id| !withdrawn.contains(id));
        let mut coordination = shared.coordination.change();
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

#[cfg(test)]
mod tests {
    //! A formation is flown on by those who are there.

    use super::*;
    use skein_domain::{FormationRequest, Shape};

    #[test]
    fn a_formation_is_flown_on_by_those_who_are_there() {
        let mut request = FormationRequest::new(Shape::Wedge, 5.0);
        request.leader = Some(VehicleId(1));
        request.members = Some(vec![VehicleId(1), VehicleId(2), VehicleId(3)]);
        let all = Interrupted {
            missing: request.members.clone().expect("was set"),
            request,
            route: None,
        };
        let left = of(all.clone(), &[VehicleId(2), VehicleId(3), VehicleId(9)].into()).expect("two are");
        assert_eq!(left.missing, [VehicleId(2), VehicleId(3)]);
        assert_eq!(left.request.members, Some(vec![VehicleId(2), VehicleId(3)]));
        assert_eq!(left.request.leader, None, "another one leads");
        assert_eq!(of(all, &BTreeSet::new()), None);
    }
}
