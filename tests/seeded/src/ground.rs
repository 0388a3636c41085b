//! The node's coordinator without its actor: asks the product's decisions in the order and at the times in which the actor does.
//!
//! Must never do: decide by itself who takes part, who leads, or which slot is whose.

use crate::case::Moving;
use crate::case::asks::REFERENCE;
use crate::craft::Craft;
use nalgebra::Vector3;
use skein_config::NodeConfig;
use skein_coordination::{self as coordination, Changed, Coordination, Formation, Judging, PlanInput, PlanLimits};
use skein_coordination::{AnchorKeeper, ReferenceReport, References};
use skein_domain::{AnchorReference, FormationAnchor, FormationRequest, Intent, NodeTime, Refusal, Route, VehicleId};
use skein_safety::Gate;
use skein_view::PeerSnapshot;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Time between a decision and the start of the motion in seconds, as the coordinator's.
const LEAD_TIME_S: f64 = 0.1;
/// After a plan to regroup that failed the next is made so much later, in seconds, as the coordinator's.
const RETRY_S: f64 = 1.0;

/// What moves is told of for so long after it has stopped, in seconds.
const TOLD_AFTER_S: f64 = 5.0;

/// A plan that is being made.
struct Pending {
    ready: NodeTime,
    request: FormationRequest,
    /// The text, if it is to regroup, and whether the members were named.
    regroup: Option<(String, bool)>,
    generation: u64,
    outcome: Result<Formation, Refusal>,
}

/// The ground side.
pub struct Ground {
    pub config: NodeConfig,
    pub gate: Arc<Gate>,
    pub coordination: Coordination,
    pub intent: Intent,
    pub withdrawn: BTreeSet<VehicleId>,
    pub story: Vec<String>,
    /// Every refusal, as operators would read it.
    pub refusals: Vec<String>,
    references: References,
    keeper: AnchorKeeper,
    limits: PlanLimits,
    generation: u64,
    reshape: bool,
    pub keeps_itself: bool,
    settled: bool,
    joins: Vec<VehicleId>,
    not_before: NodeTime,
    pending: Vec<Pending>,
}

impl Ground {
    pub fn new(config: NodeConfig, gate: Gate) -> Self {
        let limits = PlanLimits::new(&config.coordinator, config.safety.max_speed_m_s);
        Self {
            references: References::new(config.safety.max_speed_m_s),
            gate: Arc::new(gate),
            limits,
            config,
            coordination: Coordination::default(),
            intent: Intent::default(),
            withdrawn: BTreeSet::new(),
            story: Vec::new(),
            refusals: Vec::new(),
            keeper: AnchorKeeper::default(),
            generation: 0,
            reshape: false,
            keeps_itself: false,
            settled: false,
            joins: Vec::new(),
            not_before: NodeTime::default(),
            pending: Vec::new(),
        }
    }

    /// The formation's anchor of this period, if it is no vehicle.
    pub fn anchor(&mut self, led: Option<&AnchorReference>, now: NodeTime) -> Option<AnchorReference> {
        let was_held = self.keeper.is_held();
        let fences = self.gate.fences();
        let anchor = self
            .keeper
            .at(self.intent.anchor.as_ref(), led, &self.references, fences, now);
        if self.keeper.is_held() != was_held {
            let text = if was_held {
                "follows the reference again"
            } else {
                "waits at the fence for the reference"
            };
            self.story.push(text.into());
        }
        anchor
    }

    /// What moves is told of, as often as it is, and for some time after it has stopped.
    pub fn see(&mut self, moving: &Moving, now_s: f64, period_s: f64, now: NodeTime) {
        let due = (now_s * moving.rate_hz).floor() > ((now_s - period_s) * moving.rate_hz).floor();
        if !due || now_s > moving.stops_s + TOLD_AFTER_S {
            return;
        }
        let stopped = now_s >= moving.stops_s;
        let velocity = if stopped { Vector3::zeros() } else { moving.velocity };
        let report = ReferenceReport {
            position: (moving.position + moving.velocity * now_s.min(moving.stops_s)).into(),
            velocity: moving.tells_velocity.then(|| velocity.into()),
            heading_rad: None,
        };
        if let Err(refusal) = self.references.tell(REFERENCE, report, now) {
            self.refuse("reference", &refusal);
        }
    }

    pub fn is_planning(&self) -> bool {
        !self.pending.is_empty()
    }

    /// An operator asks for a formation. Planning takes `plan_s`.
    pub fn ask(&mut self, request: FormationRequest, peers: &PeerSnapshot, plan_s: f64, now: NodeTime) {
        if let FormationAnchor::Path { route } = &request.anchor
            && let Err(refusal) = self.gate.route(route)
        {
            self.refuse("formation", &refusal);
            return;
        }
        self.begin_plan(request, None, peers, plan_s, now);
    }

    /// An operator gives the leader a route.
    pub fn route(&mut self, route: Route, crafts: &mut [Craft], peers: &PeerSnapshot, now: NodeTime) {
        let given = self.coordination.set_route(route, peers, &self.limits, &self.gate);
        match given {
            Ok(route) => {
                self.story
                    .push(format!("the leader flies a route at {:.1} m/s", route.speed_m_s));
                for craft in crafts {
                    craft.route_finished = false;
                }
                self.publish(now);
            }
            Err(refusal) => self.refuse("route", &refusal),
        }
    }

    fn refuse(&mut self, what: &str, refusal: &Refusal) {
        let text = format!("{what} refused: {refusal}");
        self.story.push(text.clone());
        self.refusals.push(text);
    }

    fn begin_plan(
        &mut self,
        request: FormationRequest,
        regroup: Option<(String, bool)>,
        peers: &PeerSnapshot,
        plan_s: f64,
        now: NodeTime,
    ) {
        let (route_speed_m_s, under_way) = self.coordination.way(&request);
        let reference = match &request.anchor {
            FormationAnchor::Reference { name } => self.references.anchor(name, now),
            _ => None,
        };
        let input = PlanInput {
            request: request.clone(),
            route_speed_m_s,
            under_way,
            ahead: regroup.is_none().then(|| self.coordination.ahead(&request)).flatten(),
            reference,
            before: self.coordination.formation.clone(),
            limits: self.limits.clone(),
            gate: Arc::clone(&self.gate),
            start: now.plus_seconds(LEAD_TIME_S),
        };
        self.pending.push(Pending {
            ready: now.plus_seconds(plan_s),
            request,
            regroup,
            generation: self.generation,
            outcome: coordination::plan(&input, peers),
        });
    }

    /// Plans that are ready are flown, unless the formation has changed meanwhile.
    pub fn take_plans(&mut self, crafts: &mut [Craft], peers: &PeerSnapshot, now: NodeTime) {
        let (ready, waiting): (Vec<Pending>, Vec<Pending>) = std::mem::take(&mut self.pending)
            .into_iter()
            .partition(|p| p.ready <= now);
        self.pending = waiting;
        for planned in ready {
            if planned.generation != self.generation {
                match planned.regroup {
                    None => self.begin_plan(planned.request, None, peers, 0.02, now),
                    Some(_) => self.reshape = true,
                }
                continue;
            }
            let start = now.plus_seconds(LEAD_TIME_S);
            match (planned.outcome.map(|f| f.beginning(start)), planned.regroup) {
                (Ok(formation), None) => {
                    self.withdrawn.retain(|id| !formation.members.contains(id));
                    let text = told(&formation);
                    self.fly(formation, text, crafts, now);
                }
                (Ok(mut formation), Some((text, named))) => {
                    if !named {
                        formation.request.members = None;
                    }
                    self.reshape = false;
                    self.joins.retain(|id| !formation.members.contains(id));
                    let text = format!("{text}: {}", told(&formation));
                    self.fly(formation, text, crafts, now);
                }
                (Err(refusal), None) => self.refuse("formation", &refusal),
                (Err(refusal), Some((text, _))) => {
                    self.joins.clear();
                    self.not_before = now.plus_seconds(RETRY_S);
                    self.refuse(&text, &refusal);
                }
            }
        }
    }

    fn fly(&mut self, formation: Formation, text: String, crafts: &mut [Craft], now: NodeTime) {
        let leader = formation.leader;
        let leader_changed = self.coordination.take_up(formation);
        self.generation += 1;
        if leader_changed {
            for craft in crafts.iter_mut().filter(|c| Some(c.id) != leader) {
                craft.entry.anchor = None;
            }
        }
        self.publish(now);
        self.story.push(text);
    }

    fn publish(&mut self, now: NodeTime) {
        self.keeps_itself = self
            .coordination
            .formation
            .as_ref()
            .is_some_and(|f| f.keeps_itself(now));
        self.settled = self.coordination.formation.as_ref().is_some_and(|f| f.is_settled(now));
        self.intent = coordination::intent(&self.intent, &self.coordination, &self.withdrawn, now);
    }

    /// Every control period.
    pub fn watch(&mut self, crafts: &mut [Craft], peers: &PeerSnapshot, now: NodeTime) {
        let Some(formation) = self.coordination.formation.clone() else {
            return;
        };
        let lost = self.judging(&formation, peers, now).lost_leader(&formation);
        if let Some(lost) = lost {
            let order = self.limits.leader_order.clone();
            if let Some(next) = coordination::succeed(&formation, lost, now, &order, peers) {
                self.reshape = true;
                let text = format!("leader {lost} is lost: {:?} leads", next.leader);
                self.fly(next, text, crafts, now);
                return;
            }
        }
        if formation.is_settled(now) != self.settled {
            self.publish(now);
        }
    }

    fn judging<'a>(&'a self, formation: &Formation, peers: &'a PeerSnapshot, now: NodeTime) -> Judging<'a> {
        let leader = formation.leader.and_then(|leader| peers.entry(leader));
        Judging {
            peers,
            withdrawn: &self.withdrawn,
            leader_lost_after_s: self.config.coordinator.leader_lost_after_s,
            leader_silence_s: leader.map_or(0.0, |leader| now.seconds_since(leader.link.last_heard)),
            now,
        }
    }

    /// Every review.
    pub fn review(&mut self, crafts: &[Craft], peers: &PeerSnapshot, plan_s: f64, now: NodeTime) {
        let finished = |leader| crafts.iter().any(|c| c.id == leader && c.route_finished);
        self.coordination.follow_route(peers, finished);
        let newcomers = self.coordination.newcomers(peers);
        let Some(formation) = self.coordination.formation.clone() else {
            self.joins.clear();
            return;
        };
        if formation.request.members.is_none() {
            self.joins.extend(newcomers);
        }
        if self.pending.iter().any(|p| p.regroup.is_some()) || now < self.not_before {
            return;
        }
        let changed = self
            .judging(&formation, peers, now)
            .changed(&formation, &self.joins, self.reshape);
        let Some(Changed { members, gone, joins }) = changed else {
            return;
        };
        if members.is_empty() {
            self.coordination.formation = None;
            self.coordination.route = None;
            self.generation += 1;
            self.reshape = false;
            self.joins.clear();
            self.publish(now);
            self.story.push("nobody is left: formation dissolved".into());
            return;
        }
        let named = formation.request.members.is_some();
        let request = FormationRequest {
            members: Some(members),
            ..formation.request
        };
        let text = format!("regroups, left {gone:?}, joined {joins:?}");
        self.begin_plan(request, Some((text, named)), peers, plan_s, now);
    }
}

fn told(formation: &Formation) -> String {
    format!(
        "{:?} of {}, leader {:?}: {:.1} s, planned {:.2} m apart at least",
        formation.request.shape,
        formation.members.len(),
        formation.leader,
        formation.settled_at.seconds_since(formation.decided),
        formation.min_distance_m
    )
}
