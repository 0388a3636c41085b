//! Planning beside the actor: with many vehicles a plan takes longer than a control period, and a leader that is lost meanwhile must be
//! replaced at once. What was planned for a formation that has changed since is planned again, or dropped.

use super::{CoordinatorMessage, CoordinatorState, LEAD_TIME_S, list};
use ractor::{ActorRef, RpcReplyPort};
use skein_coordination::{self as coordination, Formation, Placed, PlanInput, PlanLimits};
use skein_domain::exchange::Severity;
use skein_domain::{FormationAnchor, FormationRequest, PositionNed, Refusal, VehicleId};
use skein_state::{MadePlan, Taken};
use skein_view::PeerSnapshot;
use skein_view::{ForeseenWay, FormationForecast, FormationReceipt};
use std::sync::Arc;

/// How often a request is planned anew because the formation changed meanwhile.
const ATTEMPTS: u8 = 5;

/// After a plan to regroup that failed the next is made so much later, in seconds.
const RETRY_S: f64 = 1.0;

/// The same refusal to regroup is told again after so long, in seconds.
const TELL_AGAIN_S: f64 = 30.0;

/// What a plan is for.
pub enum Purpose {
    /// Somebody asked.
    Asked(RpcReplyPort<Result<FormationReceipt, Refusal>>),
    /// Somebody wants to know how it would be.
    Foreseen(RpcReplyPort<Result<FormationForecast, Refusal>>),
    /// Members left or joined.
    Regroup {
        /// What happened.
        text: String,
        /// The members were named by whoever asked for the formation.
        named: bool,
    },
}

/// A plan that was made.
pub struct Planned {
    request: FormationRequest,
    purpose: Purpose,
    /// The state of the formation it was made for.
    generation: u64,
    attempts: u8,
    outcome: Result<(Formation, FormationForecast), Refusal>,
}

impl CoordinatorState {
    /// Begins to plan; the result comes back as a message.
    pub(super) fn begin_plan(
        &mut self,
        myself: &ActorRef<CoordinatorMessage>,
        request: FormationRequest,
        purpose: Purpose,
        attempts: u8,
    ) {
        if matches!(purpose, Purpose::Regroup { .. }) {
            self.regrouping = true;
        }
        let (generation, input) = (self.generation, self.plan_input(request.clone(), &purpose));
        let mut peers = self.shared.peers();
        if request.members.is_none() {
            peers = Arc::new(self.without_flights(&peers));
        }
        let (myself, shared) = (myself.clone(), self.shared.clone());
        let is_recorded = !matches!(purpose, Purpose::Foreseen(_));
        tokio::spawn(async move {
            let planned = tokio::task::spawn_blocking(move || {
                let made = coordination::plan_with_places(&input, &peers);
                if is_recorded {
                    shared.tape.take(|| {
                        Taken::Plan(Box::new(MadePlan {
                            at: shared.now(),
                            outcome: made.clone().map(|(formation, _)| formation),
                            peers: peers.clone(),
                            input,
                        }))
                    });
                }
                let (formation, placed) = made?;
                let forecast = forecast(&formation, &placed, &peers);
                Ok((formation, forecast))
            })
            .await;
            let outcome = planned.unwrap_or_else(|_| Err(Refusal::not_running("the formation planner")));
            // A coordinator that has ended has told the asker by dropping the reply.
            let _ = myself.cast(CoordinatorMessage::Planned(Box::new(Planned {
                request,
                purpose,
                generation,
                attempts,
                outcome,
            })));
        });
    }

    fn plan_input(&self, request: FormationRequest, purpose: &Purpose) -> PlanInput {
        let coordination = self.shared.coordination.read().clone();
        let now = self.shared.now();
        let reference = match &request.anchor {
            FormationAnchor::Reference { name } => self.shared.observed.references.anchor(name, now),
            _ => None,
        };
        let (route_speed_m_s, under_way) = coordination.way(&request);
        // Who joins or leaves does so wherever the route leads: the route was looked at when it was given.
        let ahead = match purpose {
            Purpose::Asked(_) | Purpose::Foreseen(_) => coordination.ahead(&request),
            Purpose::Regroup { .. } => None,
        };
        PlanInput {
            request,
            ahead,
            route_speed_m_s,
            under_way,
            reference,
            before: coordination.formation,
            limits: self.plan_limits(),
            gate: self.shared.gate(),
            start: now.plus_seconds(LEAD_TIME_S),
        }
    }

    pub(super) fn plan_limits(&self) -> PlanLimits {
        let config = &self.shared.config;
        PlanLimits::new(&config.coordinator, config.safety.max_speed_m_s)
    }

    /// A plan is there: it is flown if it still fits.
    pub(super) fn take_plan(&mut self, myself: &ActorRef<CoordinatorMessage>, planned: Planned) {
        let Planned {
            request,
            purpose,
            generation,
            attempts,
            outcome,
        } = planned;
        if matches!(purpose, Purpose::Regroup { .. }) {
            self.regrouping = false;
        }
        if !self.shared.coordinates() {
            // The leadership has passed on meanwhile.
            match purpose {
                Purpose::Asked(reply) => drop(reply.send(Err(Refusal::Superseded))),
                Purpose::Foreseen(reply) => drop(reply.send(Err(Refusal::Superseded))),
                Purpose::Regroup { .. } => {}
            }
            return;
        }
        if let Purpose::Foreseen(reply) = purpose {
            return drop(reply.send(outcome.map(|(_, forecast)| forecast)));
        }
        if generation != self.generation {
            match purpose {
                Purpose::Asked(_) if attempts < ATTEMPTS => self.begin_plan(myself, request, purpose, attempts + 1),
                // Nobody waits for these: the asker is told; a regrouping is looked at again by the next review.
                Purpose::Asked(reply) => drop(reply.send(Err(Refusal::Superseded))),
                Purpose::Regroup { .. } => self.reshape = true,
                Purpose::Foreseen(_) => {}
            }
            return;
        }
        let start = self.shared.now().plus_seconds(LEAD_TIME_S);
        let outcome = outcome.map(|(formation, _)| formation.beginning(start));
        match purpose {
            Purpose::Asked(reply) => drop(reply.send(outcome.map(|formation| self.fly_asked(formation)))),
            Purpose::Regroup { text, named } => self.fly_regrouped(outcome, &text, named),
            Purpose::Foreseen(_) => {}
        }
    }

    fn fly_asked(&mut self, formation: Formation) -> FormationReceipt {
        // The operator calls them back.
        self.shared.vehicles.call_back(&formation.members);
        self.shared.coordination.change().interrupted = None;
        let receipt = receipt(&formation);
        let behind = formation
            .leader
            .map_or_else(|| "about its anchor".to_owned(), |id| format!("behind vehicle {id}"));
        let apart = receipt.planned_min_distance_m;
        let apart = apart.map_or_else(String::new, |apart_m| format!(", {apart_m:.1} m apart at least"));
        let text = format!(
            "formation {:?} of {} {behind}: {:.1} s{apart}",
            formation.request.shape,
            formation.members.len(),
            receipt.duration_s,
        );
        self.fly(formation, Severity::Info, text);
        receipt
    }

    fn fly_regrouped(&mut self, outcome: Result<Formation, Refusal>, text: &str, named: bool) {
        match outcome {
            Ok(mut formation) => {
                if !named {
                    formation.request.members = None;
                }
                self.reshape = false;
                self.take_route_back();
                self.joins.retain(|id| !formation.members.contains(id));
                self.fly(formation, Severity::Advisory, text.to_owned());
            }
            Err(refusal) => {
                self.joins.clear();
                self.not_before = self.shared.now().plus_seconds(RETRY_S);
                let text = format!("{text}; but it cannot: {refusal}");
                let now = self.shared.now();
                let told = self.told_cannot.as_ref();
                if !told.is_some_and(|(what, at)| *what == text && now.seconds_since(*at) < TELL_AGAIN_S) {
                    self.record(Severity::Warning, text.clone());
                    self.told_cannot = Some((text, now));
                }
            }
        }
    }

    /// Plans the formation anew for who is in it now.
    pub(super) fn regroup(
        &mut self,
        myself: &ActorRef<CoordinatorMessage>,
        formation: &Formation,
        changed: coordination::Changed,
    ) {
        let coordination::Changed { members, gone, joins } = changed;
        if members.is_empty() {
            self.dissolve();
            return;
        }
        let named = formation.request.members.is_some();
        let request = FormationRequest {
            members: Some(members),
            ..formation.request.clone()
        };
        let text = format!("formation regroups: left {}, joined {}", list(&gone), list(&joins));
        self.begin_plan(myself, request, Purpose::Regroup { text, named }, 0);
    }
}

fn receipt(formation: &Formation) -> FormationReceipt {
    FormationReceipt {
        leader: formation.leader,
        members: formation.members.clone(),
        duration_s: formation.settled_at.seconds_since(formation.decided),
        planned_min_distance_m: formation.apart_m(),
        max_speed_m_s: formation.max_speed_m_s,
        view_blocked: formation.view_blocked.clone(),
    }
}

fn forecast(formation: &Formation, placed: &Placed, peers: &PeerSnapshot) -> FormationForecast {
    let way = |(vehicle, to): (&VehicleId, &PositionNed)| {
        let from = peers.entry(*vehicle)?.kinematics?.position;
        Some(ForeseenWay {
            vehicle: *vehicle,
            from,
            to: *to,
        })
    };
    FormationForecast {
        receipt: receipt(formation),
        heading_rad: placed.heading_rad,
        ways: formation.members.iter().zip(&placed.places).filter_map(way).collect(),
    }
}
