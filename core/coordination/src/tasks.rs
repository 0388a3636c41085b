//! The intent that follows from formation, route and trajectories: one task per vehicle, whose version changes only with the task.

use crate::formation::Formation;
use crate::state::Coordination;
use skein_domain::{Intent, NodeTime, Task, VehicleId, VehicleTask};
use std::collections::{BTreeMap, BTreeSet};

/// The intent that follows from formation, route and trajectories. Tasks that do not change keep their version, so that nobody starts anew. Who was
/// withdrawn by an operator gets no task at all: a task of a newer version would outrank the operator's command.
#[must_use]
pub fn intent(before: &Intent, coordination: &Coordination, withdrawn: &BTreeSet<VehicleId>, now: NodeTime) -> Intent {
    // Even ones: a node that is cut off from its swarm puts an odd one in between.
    let version = (before.version | 1) + 1;
    let mut wanted = coordination
        .formation
        .as_ref()
        .map_or_else(BTreeMap::new, |formation| members_tasks(formation, coordination, now));
    for (id, flight) in coordination.flights.iter().filter(|(_, flight)| flight.is_on()) {
        wanted
            .entry(*id)
            .or_insert_with(|| Task::Fly(flight.trajectory.clone()));
    }
    // Who had a place in the formation and has none now is told to hold, once.
    for (id, task) in &before.tasks {
        if task.task != Task::Hold && !withdrawn.contains(id) {
            wanted.entry(*id).or_insert(Task::Hold);
        }
    }
    let tasks = wanted
        .into_iter()
        .filter(|(id, _)| !withdrawn.contains(id))
        .map(|(id, task)| match before.tasks.get(&id) {
            Some(same) if same.task == task => (id, same.clone()),
            _ => (id, VehicleTask { version, task }),
        })
        .collect();
    Intent {
        version,
        leader: coordination.formation.as_ref().and_then(|f| f.leader),
        anchor: coordination.formation.as_ref().and_then(|f| f.anchor_at(now)),
        tasks,
    }
}

/// What the members of a formation do.
fn members_tasks(formation: &Formation, coordination: &Coordination, now: NodeTime) -> BTreeMap<VehicleId, Task> {
    let mut tasks = BTreeMap::new();
    if let Some(leader) = formation.leader {
        let task = Task::Lead {
            route: coordination.route.as_ref().map(|r| r.route.clone()),
            heading: formation.heading_at(now),
        };
        tasks.insert(leader, task);
    }
    let by_neighbours = formation.keeps_itself(now);
    for (id, slot) in &formation.slots {
        let task = match formation.keeping.get(id) {
            Some(keeping) if by_neighbours => Task::Keep(keeping.clone()),
            _ => Task::Follow {
                leader: formation.leader,
                slot: *slot,
            },
        };
        tasks.insert(*id, task);
    }
    tasks
}
