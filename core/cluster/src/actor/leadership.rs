//! The leadership on this node: when to take it, hand it over, and what everybody here is told of it.
//!
//! Must never do: take it from a holder that is heard, unless somebody asks.

use super::SwarmState;
use super::inbound::of_nodes;
use super::messages::NodeMessage;
use super::outbound::roles;
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime, Refusal, Task, VehicleTask};
use skein_failover::{ClaimError, LeaderState, Term, Turn};
use skein_state::cluster::report::{WITHDRAWN, origin_of};
use skein_state::cluster::share::Role;
use skein_state::{LeadershipTurn, SharedState, Taken};
use skein_view::{LeaderStateKind, NodeRole, NodeSnapshot, SwarmSnapshot, TermSnapshot, WaySnapshot};

/// A node not heard for so long is told of as gone, in seconds.
const GONE_S: f64 = 3.0;
/// Time between two offers of the leadership, in seconds.
const OFFER_S: f64 = 0.5;

impl SwarmState {
    /// Whether it is this node's turn, and what follows.
    pub(super) fn decide(&mut self, now: NodeTime) {
        self.leadership.set_priority(self.priority());
        let turn = self.monitor.turn(now, &self.leadership);
        if self.turn.replace(turn) != Some(turn) {
            self.shared.tape.take(|| {
                Taken::Leadership(Box::new(LeadershipTurn {
                    at: now,
                    monitor: self.monitor.clone(),
                    leadership: self.leadership.clone(),
                    turn,
                }))
            });
        }
        match turn {
            Turn::Claim => {
                let missed = self.leadership.obeyed().map(|term| term.holder.node);
                if self.leadership.claim().is_ok() {
                    self.lost_leader = missed.filter(|node| *node != self.leadership.node());
                }
            }
            // Without a number left everything stays as it is, fenced apart.
            Turn::Renew => drop(self.leadership.renew()),
            Turn::HandOver(to) => self.offer(now, to),
            Turn::Held | Turn::Wait | Turn::Alone | Turn::Minority => {}
        }
        // In whatever way it changed: what was heard since the last look may have done it too.
        let before = std::mem::replace(&mut self.noted, self.leadership.acting());
        if self.noted != before {
            self.leadership_changed(before);
        }
    }

    /// How suited this node is: as configured, unless all of its vehicles say that they cannot host a coordinator.
    fn priority(&self) -> Option<u8> {
        let records = self.shared.vehicles.records();
        let told: Vec<bool> = records
            .iter()
            .filter_map(|record| record.state().capability.map(|c| c.capable))
            .collect();
        let able = told.is_empty() || told.contains(&true);
        self.shared.config.swarm.coordinator_priority.filter(|_| able)
    }

    fn offer(&mut self, now: NodeTime, to: NodeId) {
        if now < self.told.next_offer {
            return;
        }
        self.told.next_offer = now.plus_seconds(OFFER_S);
        if let Some(offer) = self.leadership.hand_over(to) {
            self.post(now, to, &NodeMessage::Handover(offer));
        }
    }

    /// Takes the leadership, because somebody asks for it.
    ///
    /// # Errors
    /// When this node cannot coordinate.
    pub(super) fn take_leadership(&mut self) -> Result<(), Refusal> {
        match self.leadership.claim() {
            Ok(_) => {
                self.lost_leader = None;
                Ok(())
            }
            Err(ClaimError::HoldsAlready { .. }) => Ok(()),
            Err(error) => Err(Refusal::NotPermitted {
                detail: error.to_string(),
            }),
        }
    }

    /// This node has taken the leadership, or lost it.
    fn leadership_changed(&mut self, before: Option<Term>) {
        let Some(swarm) = &self.shared.swarm else { return };
        let remote: Vec<_> = {
            let vehicles = swarm.vehicles();
            let withdrawn = |v: &skein_state::cluster::share::RemoteVehicle| v.report.has(WITHDRAWN);
            vehicles.values().map(|v| (v.report.id, withdrawn(v))).collect()
        };
        let acting = self.leadership.acting();
        // Of others' vehicles only the coordinator keeps count here.
        let told = remote.into_iter().map(|(id, is)| (id, is && acting.is_some()));
        self.shared.vehicles.mirror_withdrawals(told);
        match (before, acting) {
            (None, Some(term)) => {
                tracing::info!(term = term.number, "coordinates");
                self.record(
                    Severity::Advisory,
                    format!("this node coordinates, in term {}", term.number),
                );
            }
            (Some(_), None) => {
                let by = self.leadership.obeyed().map_or(0, |term| term.holder.node.0);
                self.record(Severity::Advisory, format!("node {by} coordinates from now on"));
            }
            _ => {}
        }
    }

    /// Puts in the shared state what everybody here has to know of the swarm.
    pub(super) fn publish(&mut self, now: NodeTime) {
        self.notice_gone(now);
        let present = self.monitor.present(now).count();
        self.had_company |= present > 0;
        let leader_state = self.monitor.leader_state(now, &self.leadership, &self.unled);
        let silent_s = self.monitor.silent_s(now);
        let Some(swarm) = &self.shared.swarm else { return };
        let before = swarm.role();
        let acting = self.leadership.acting();
        let role = Role {
            node: self.leadership.node(),
            acting,
            acting_since: acting.and(before.acting_since.or(Some(now))),
            lost_leader: self.lost_leader,
            leader_state,
            coordinator_seen: match self.leadership.acting() {
                Some(_) => None,
                None => silent_s.map(|s| now.plus_seconds(-s)),
            },
            cut_off: present == 0 && self.had_company,
            observer: before.observer,
        };
        if role.acting.is_some() && before.acting.is_none() {
            // What it decides comes a moment later: until then nobody is to think that there is no coordinator.
            self.shared.coordination.see_coordinator(self.shared.now());
        }
        if role != before {
            swarm.obey(role);
            if role.cut_off && !before.cut_off && role.acting.is_none() {
                hold_here(&self.shared);
                self.record(Severity::Warning, "this node hears no other one: its vehicles hold");
            }
            if role.coordinator() != before.coordinator() && role.acting.is_none() {
                let who = role
                    .coordinator()
                    .map_or_else(|| "nobody".to_owned(), |node| format!("node {node}"));
                self.record(Severity::Info, format!("this node obeys {who}"));
            }
        }
        if now >= self.told.next_picture {
            self.told.next_picture = now.plus_seconds(0.2);
            let picture = self.picture(&role, now);
            if let Some(swarm) = &self.shared.swarm {
                swarm.show(picture);
            }
        }
    }

    fn notice_gone(&mut self, now: NodeTime) {
        let gone: Vec<NodeId> = self
            .nodes
            .iter_mut()
            .filter(|(_, known)| !known.told_gone && now.seconds_since(known.heard) > GONE_S)
            .map(|(node, known)| {
                known.told_gone = true;
                *node
            })
            .collect();
        for node in gone {
            self.record(Severity::Warning, format!("node {node} is not heard any more"));
        }
        let back: Vec<NodeId> = self
            .nodes
            .iter_mut()
            .filter(|(_, known)| known.told_gone && now.seconds_since(known.heard) < 0.5)
            .map(|(node, known)| {
                known.told_gone = false;
                *node
            })
            .collect();
        for node in back {
            self.record(Severity::Info, format!("node {node} is heard again"));
        }
    }

    fn picture(&self, role: &Role, now: NodeTime) -> SwarmSnapshot {
        let (leader_state, silent_s) = match role.leader_state {
            LeaderState::Nobody => (LeaderStateKind::Nobody, None),
            LeaderState::Led { .. } => (LeaderStateKind::Led, None),
            LeaderState::Awaiting { silent_s, .. } => (LeaderStateKind::Awaiting, Some(silent_s)),
            LeaderState::Unled { silent_s, .. } => (LeaderStateKind::Unled, Some(silent_s)),
        };
        let refused = self.bus.refused();
        let config = &self.shared.config;
        SwarmSnapshot {
            swarm: config.swarm.id.clone().unwrap_or_default(),
            node: role.node,
            name: config.node.name.clone(),
            roles: roles(&self.shared),
            leader_state,
            term: self.leadership.obeyed().map(told),
            silent_s,
            acting: role.acting.is_some(),
            cut_off: role.cut_off,
            nodes: self.nodes.keys().map(|node| self.node(*node, now)).collect(),
            sent_bytes_per_s: self.bus.sent().rate_bytes_per_s(now),
            limit_bytes_per_s: self.bus.rates().all_bytes_per_s,
            strangers: refused.strangers + refused.malformed,
            replayed: refused.replayed,
            transport_fault: self.transport_fault.clone(),
            ways: self.ways_now(now),
        }
    }

    fn ways_now(&self, now: NodeTime) -> Vec<WaySnapshot> {
        let Some((names, ways)) = &self.ways else {
            return Vec::new();
        };
        let shown = |(name, way): (&String, skein_bus::redundant::Way)| WaySnapshot {
            name: name.clone(),
            up: way.up,
            fault: way.down_because,
            sent_bytes_per_s: way.sent.rate_bytes_per_s(now),
            received_bytes_per_s: way.received.rate_bytes_per_s(now),
            heard_s: way.last_came.map(|at| now.seconds_since(at)),
        };
        names.iter().zip(ways.now()).map(shown).collect()
    }

    fn node(&self, node: NodeId, now: NodeTime) -> NodeSnapshot {
        let link = self.bus.links().find(|(id, _)| *id == node).map(|(_, link)| link);
        let vehicles = self
            .shared
            .swarm
            .as_ref()
            .map(|swarm| of_nodes(&swarm.vehicles(), node));
        let known = self.nodes.get(&node);
        let frame = origin_of(self.shared.frame());
        let card = known.map(|known| known.card.clone()).unwrap_or_default();
        NodeSnapshot {
            node,
            roles: NodeRole::from_bits(card.roles),
            heard_s: known.map_or(f64::MAX, |known| now.seconds_since(known.heard)),
            obeys: known.and_then(|known| known.obeys).map(told),
            vehicles: vehicles.unwrap_or_default(),
            other_frame: frame.is_some() && card.origin.is_some() && card.origin != frame,
            name: card.name,
            version: card.version,
            round_trip_s: link.map(|link| link.round_trip_s),
            clock_offset_s: link.map(|link| link.offset_s),
            clock_error_s: link.map(|link| link.offset_error_s),
            clock_fault: known.is_some_and(|known| known.clock_fault),
            received_bytes_per_s: self.bus.received().get(&node).map_or(0.0, |t| t.rate_bytes_per_s(now)),
            loss: link.and_then(|link| link.loss),
        }
    }
}

/// Nobody is heard: whatever the others do now, they expect those that they do not hear to stop. Trajectories go on: they were proven for
/// all who fly them, over time.
fn hold_here(shared: &SharedState) {
    let mut intent = shared.coordination.intent().as_ref().clone();
    // Coordinators publish even versions: the next one outranks this.
    let version = intent.version | 1;
    for record in shared.vehicles.records() {
        if let Some(task) = intent.tasks.get_mut(&record.id)
            && matches!(task.task, Task::Lead { .. } | Task::Follow { .. } | Task::Keep(_))
        {
            *task = VehicleTask {
                version,
                task: Task::Hold,
            };
        }
    }
    shared.coordination.publish(intent);
}

fn told(term: Term) -> TermSnapshot {
    TermSnapshot {
        number: term.number,
        coordinator: term.holder.node,
    }
}
