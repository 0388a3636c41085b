//! The coordinator as one of several in a swarm: it decides only while its node leads, goes on from what its predecessor
//! told, and reaches vehicles that other nodes fly.
//!
//! Must never do: publish anything while its node does not lead.

use super::{CoordinatorMessage, CoordinatorState, Purpose, is_settled, list};
use ractor::ActorRef;
use skein_coordination::{self as coordination, Formation, Interrupted};
use skein_domain::exchange::Severity;
use skein_domain::{FormationRequest, Intent, NodeId, NodeTime, PositionNed, Task, VehicleId};
use skein_state::asking;
use skein_state::asks::Ask;
use skein_state::cluster::report::CLOCK_FAULT;
use skein_state::cluster::share::first_version;
use skein_view::PeerSnapshot;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

/// A vehicle that leaves within so many seconds of a start of its node does so for that: it is in the failsafe that the loss of setpoints
/// brought about, and comes back when its node has taken it back.
const JUST_STARTED_S: f64 = 5.0;

/// A node that does not answer what the coordinator asks of it is not waited for longer.
const ASKED_WITHIN: Duration = Duration::from_secs(5);
/// Clocks that may be farther apart than this start nothing together, in seconds.
const CLOCK_ERROR_S: f64 = 0.05;
/// So long after a succession it is looked once more who else is missed, in seconds: longer than anybody is silent by chance.
const LOOK_AGAIN_S: f64 = 0.7;
/// Who was last heard so much sooner than a succession, at most, went together with the former holder, in seconds.
const TOGETHER_S: f64 = 3.0;
/// Somebody missed for so long counts as gone when the leadership is taken, in seconds. Time in which this computer stood still does not count.
const MISSING_S: f64 = 0.4;

/// The holder that this node succeeded because it was missed, until it is clear who else is.
pub(super) struct LostLeader {
    missed: NodeId,
    since: NodeTime,
    /// Of the formation at that time.
    members: Vec<VehicleId>,
}

impl CoordinatorState {
    /// Whether its node holds the leadership. One that has just taken it goes on from what is in the shared state.
    pub(super) fn is_leading(&mut self) -> bool {
        let Some(swarm) = &self.shared.swarm else { return true };
        let role = swarm.role();
        let newly_cut_off = role.cut_off && !std::mem::replace(&mut self.cut_off, role.cut_off);
        if role.acting == self.term {
            if newly_cut_off && self.term.is_some() {
                self.interrupt_if_cut_off();
            }
            self.look_again();
            return self.term.is_some();
        }
        let had_none = self.term.is_none();
        self.term = role.acting;
        // Plans that are being made are for a state of things that another one may have changed.
        self.generation += 1;
        self.flights_version += 1;
        self.regrouping = false;
        if self.term.is_none() {
            self.lost_leader = None;
            return false;
        }
        self.joins.clear();
        self.settled = is_settled(&self.shared.coordination.read(), self.shared.now());
        // Two may have claimed one term at once, and the one who keeps the leadership renews it: whom it succeeded is missed all the same.
        if let Some(missed) = role.lost_leader.filter(|_| had_none) {
            let since = self.shared.now();
            let formation = self.shared.coordination.read().formation.clone();
            let members = formation.map(|formation| formation.members).unwrap_or_default();
            self.interrupt_if_apart(&members, &[missed]);
            self.lost_leader = Some(LostLeader { missed, since, members });
            // Nobody closes up before it is clear who is missed.
            self.not_before = self.not_before.max(since.plus_seconds(LOOK_AGAIN_S));
        }
        self.publish();
        true
    }

    /// Some time after a succession it is clear who else went silent together with the former holder, also nodes without vehicles.
    fn look_again(&mut self) {
        let now = self.shared.now();
        let due = |lost_leader: &mut LostLeader| now.seconds_since(lost_leader.since) >= LOOK_AGAIN_S;
        let Some(LostLeader { missed, since, members }) = self.lost_leader.take_if(due) else {
            return;
        };
        let Some(swarm) = &self.shared.swarm else { return };
        // As old as the picture is, which is made anew several times a second.
        let longest_s = now.seconds_since(since) + TOGETHER_S;
        let overrun = self.shared.overrun();
        let silence_s = |heard_s: f64| overrun.silence_s(now.plus_seconds(-heard_s), now);
        let mut gone: Vec<NodeId> = (swarm.picture().nodes.iter())
            .filter(|node| silence_s(node.heard_s) > LOOK_AGAIN_S && node.heard_s < longest_s)
            .map(|node| node.node)
            .collect();
        drop(overrun);
        gone.push(missed);
        self.interrupt_if_apart(&members, &gone);
    }

    /// Who was told to hold stays told until it has taken that up: the next intent may be the first that reaches it.
    pub(super) fn with_holds(&self, mut intent: Intent, before: &Intent, withdrawn: &BTreeSet<VehicleId>) -> Intent {
        for (id, told) in &before.tasks {
            let waits = told.task == Task::Hold && self.taken(*id) < told.version && !withdrawn.contains(id);
            if waits && !intent.tasks.contains_key(id) {
                intent.tasks.insert(*id, told.clone());
            }
        }
        intent
    }

    /// Version of the task that a vehicle has taken up last.
    fn taken(&self, id: VehicleId) -> u64 {
        if let Some(record) = self.shared.vehicles.record(id) {
            return record.state().task_version;
        }
        let swarm = self.shared.swarm.as_ref();
        let taken = swarm.and_then(|swarm| Some(swarm.vehicles().get(&id)?.report.task_version));
        taken.unwrap_or(0)
    }

    /// The intent with a version that outranks everything of former terms, and tasks that outrank what their vehicles have taken up of those.
    pub(super) fn outranking(&self, mut intent: Intent) -> Intent {
        let Some(term) = self.term else { return intent };
        intent.version = intent.version.max(first_version(term) + 2);
        for (id, task) in &mut intent.tasks {
            let taken = self.taken(*id);
            // It flies a task of a predecessor that was not heard of here.
            if taken > task.version {
                task.version = intent.version;
            }
        }
        intent
    }

    /// A holder that is missed together with another node has not failed: the swarm has come apart. The others may go on
    /// unseen; who would fly on here with what is left of the formation could meet them. Everyone here holds until they are back, which is
    /// what the others expect of those that they do not hear.
    fn interrupt_if_apart(&mut self, members: &[VehicleId], gone: &[NodeId]) {
        let Some(mut formation) = self.shared.coordination.read().formation.clone() else {
            return;
        };
        // Who led has been succeeded since, and is to be back like the others.
        formation.members = members.to_vec();
        let missing = self.missing(members);
        let hosts = missing.iter().filter_map(|id| self.shared.host(*id));
        let nodes: BTreeSet<NodeId> = hosts.chain(gone.iter().copied()).collect();
        if nodes.len() < 2 || missing.is_empty() {
            return;
        }
        let text = format!(
            "the swarm has come apart: vehicles {} and nodes {} are not heard; the others hold until they are back",
            list(&missing),
            list(&nodes.iter().copied().collect::<Vec<_>>())
        );
        self.interrupt(&formation, missing, text);
    }

    /// The holder itself hears nobody any more, and flies vehicles of a formation with others'. To those its computer has failed: they
    /// have a new coordinator and fly on, unseen from here, so that what is flown here must stop.
    fn interrupt_if_cut_off(&mut self) {
        let Some(formation) = self.shared.coordination.read().formation.clone() else {
            return;
        };
        let elsewhere = |id: &&VehicleId| self.shared.host(**id).is_some();
        let (others, own): (Vec<_>, Vec<_>) = formation.members.iter().partition(elsewhere);
        if others.is_empty() || own.is_empty() {
            return;
        }
        let text = format!(
            "this node coordinates and hears no other one: {} hold until {} are back",
            list(&own),
            list(&others)
        );
        self.interrupt(&formation, others, text);
    }

    /// Ends a formation until those who are missing are back; see [`Self::resume`].
    fn interrupt(&mut self, formation: &Formation, missing: Vec<VehicleId>, text: String) {
        let named = formation.request.members.is_some();
        let request = FormationRequest {
            members: named.then(|| formation.members.clone()),
            leader: None,
            ..formation.request.clone()
        };
        {
            let mut coordination = self.shared.coordination.change();
            coordination.interrupted = Some(Interrupted {
                request,
                route: coordination
                    .route
                    .as_ref()
                    .filter(|r| !r.finished)
                    .and_then(|r| r.remaining()),
                missing,
            });
        }
        self.dissolve();
        self.record(Severity::Critical, text);
    }

    fn missing(&self, members: &[VehicleId]) -> Vec<VehicleId> {
        let (peers, now) = (self.shared.peers(), self.shared.now());
        let overrun = self.shared.overrun();
        let heard = |id: &VehicleId| {
            let entry = peers.entry(*id);
            entry.is_some_and(|e| e.link.connected && overrun.silence_s(e.link.last_heard, now) < MISSING_S)
        };
        members.iter().copied().filter(|id| !heard(id)).collect()
    }

    /// Whether members of two other nodes or more are not heard: so many computers do not fail at once.
    pub(super) fn is_apart(&self, formation: &Formation) -> bool {
        let missing = self.missing(&formation.members);
        let nodes: BTreeSet<NodeId> = missing.iter().filter_map(|id| self.shared.host(*id)).collect();
        nodes.len() > 1
    }

    /// Part of the swarm is not heard, and holds. Those who are left keep their places: to close up they would have to pass the others unseen.
    pub(super) fn thin_out(&mut self, formation: &Formation, gone: &[VehicleId]) {
        if gone.is_empty() {
            return;
        }
        let stays = |id: &VehicleId| !gone.contains(id);
        let mut next = formation.clone();
        next.members.retain(stays);
        next.slots.retain(|id, _| stays(id));
        next.keeping.retain(|id, _| stays(id));
        next.view_blocked.clear();
        if let Some(named) = &mut next.request.members {
            named.retain(stays);
        }
        let text = format!(
            "the swarm has come apart: {} are not heard; the others keep their places",
            list(gone)
        );
        self.fly(next, Severity::Critical, text);
    }

    /// Notes who leaves because nothing is heard of it, or because its node has just started again.
    pub(super) fn note_unheard(&self, peers: &PeerSnapshot, gone: &[VehicleId]) {
        let Some(swarm) = &self.shared.swarm else { return };
        let now = self.shared.now();
        let silent = |id: VehicleId| peers.entry(id).is_none_or(|e| !e.link.connected);
        let has_started = |node: NodeId| {
            let starts = swarm.starts();
            starts
                .get(&node)
                .is_some_and(|at| now.seconds_since(*at) < JUST_STARTED_S)
        };
        let unheard = gone.iter().copied().filter(|id| {
            let node = self.shared.host(*id);
            node.is_some_and(|node| silent(*id) || has_started(node))
        });
        let unheard: Vec<VehicleId> = unheard.collect();
        self.shared.coordination.change().unheard.extend(unheard);
    }

    /// A leader is passed over before its link counts as lost. One that was only silent for a moment is taken back when it is heard; one
    /// that a pilot, its own failsafe or a reaction took out is not.
    pub(super) fn note_passed_over(&self, peers: &PeerSnapshot, leader: VehicleId) {
        let only_silent = peers
            .entry(leader)
            .is_some_and(|entry| !entry.under_order && entry.flight_state.is_available_in_air());
        if only_silent {
            self.shared.coordination.change().unheard.insert(leader);
        }
    }

    /// Takes those back who had left only because nothing was heard of them, and who can be flown again.
    pub(super) fn take_back_heard(&mut self, peers: &PeerSnapshot) {
        let able = coordination::available(peers);
        let unheard: Vec<VehicleId> = self.shared.coordination.read().unheard.iter().copied().collect();
        let missing = self.missing(&unheard);
        for id in unheard
            .into_iter()
            .filter(|id| able.contains(id) && !missing.contains(id))
        {
            self.shared.coordination.change().unheard.remove(&id);
            if !self.joins.contains(&id) {
                self.joins.push(id);
            }
        }
    }

    /// A formation that was interrupted is flown again once those who were missing are back and can.
    pub(super) fn resume(&mut self, myself: &ActorRef<CoordinatorMessage>, peers: &PeerSnapshot) {
        let interrupted = self.shared.coordination.read().interrupted.clone();
        let Some(interrupted) = interrupted else { return };
        if self.regrouping || self.shared.now() < self.not_before {
            return;
        }
        let available = coordination::available(peers);
        // A link counts as connected for a while after the last word.
        let back = self.missing(&interrupted.missing).is_empty();
        if !back || !interrupted.missing.iter().all(|id| available.contains(id)) {
            return;
        }
        let text = "everybody is back: the formation is flown again".to_owned();
        let mut request = interrupted.request;
        let named = request.members.is_some();
        // Whom an operator has taken out stays out.
        let withdrawn = self.shared.vehicles.withdrawn();
        let others = || {
            coordination::available(&self.without_flights(peers))
                .into_iter()
                .filter(|id| !withdrawn.contains(id))
                .collect()
        };
        request.members.get_or_insert_with(others);
        self.begin_plan(myself, request, Purpose::Regroup { text, named }, 0);
    }

    /// An interrupted formation is about to fly again, with what was left of its route.
    pub(super) fn take_route_back(&mut self) {
        let mut coordination = self.shared.coordination.change();
        if let Some(interrupted) = coordination.interrupted.take()
            && coordination.route.is_none()
        {
            coordination.route = interrupted.route.map(|route| coordination::ActiveRoute {
                route,
                next: 0,
                finished: false,
            });
        }
    }

    /// The version of the task whose route a vehicle has flown to the end.
    pub(super) fn route_finished(&self, vehicle: VehicleId) -> Option<u64> {
        if let Some(record) = self.shared.vehicles.record(vehicle) {
            return record.state().route_finished;
        }
        let vehicles = self.shared.swarm.as_ref()?.vehicles();
        vehicles.get(&vehicle)?.report.route_finished
    }

    /// Whether the leader has flown its present route to the end.
    pub(super) fn has_finished_route(&self, leader: VehicleId) -> bool {
        let intent = self.shared.coordination.intent();
        let task = intent.tasks.get(&leader).map(|task| task.version);
        let finished = self.route_finished(leader);
        // Of this node's own vehicles what was told of a former route is forgotten when a new one is set.
        finished.is_some_and(|version| self.shared.host(leader).is_none() || task.is_some_and(|task| version >= task))
    }

    /// Where the vehicles of other nodes hold, and whose clocks are too far off to start with the others.
    pub(super) fn others_flights(
        &self,
        held: &mut BTreeMap<VehicleId, PositionNed>,
        clock_faults: &mut BTreeSet<VehicleId>,
    ) {
        let Some(swarm) = &self.shared.swarm else { return };
        let picture = swarm.picture();
        let doubtful: Vec<NodeId> = picture
            .nodes
            .iter()
            .filter(|node| node.clock_fault || node.clock_error_s.is_none_or(|error_s| error_s > CLOCK_ERROR_S))
            .map(|node| node.node)
            .collect();
        for (id, remote) in swarm.vehicles().iter() {
            if let Some(place) = remote.report.held() {
                held.insert(*id, place);
            }
            if remote.report.has(CLOCK_FAULT) || doubtful.contains(&remote.node) {
                clock_faults.insert(*id);
            }
        }
    }

    /// Asks another node, and does not wait for its answer: what becomes of it is seen in its vehicles' states.
    pub(super) fn ask_elsewhere(&self, node: NodeId, ask: Ask) {
        let actor = self.shared.swarm.as_ref().and_then(|swarm| swarm.actor());
        let (message, answered) = asking(node, ask, ASKED_WITHIN);
        if let Some(actor) = actor
            && actor.cast(message).is_ok()
        {
            let shared: Arc<_> = self.shared.clone();
            tokio::spawn(async move {
                if let Ok(Err(refusal)) = answered.await {
                    let kind = skein_view::EventKind::Swarm;
                    let text = format!("node {node} did not do what the coordinator asked: {refusal}");
                    shared.events.record(shared.now(), None, Severity::Warning, kind, text);
                }
            });
        }
    }
}
