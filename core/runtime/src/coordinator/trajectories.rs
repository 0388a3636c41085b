//! Trajectories: planned beside the actor, published as tasks, and seen to until they are over.
//!
//! Must never do: begin one whose start has passed, or that was planned for another state of things than there is.

use super::{CoordinatorMessage, CoordinatorState, LEAD_TIME_S, list};
use ractor::{ActorRef, RpcReplyPort};
use skein_coordination::{self as coordination, Flight, PlannedFlights, TrajectoryInput};
use skein_domain::exchange::Severity;
use skein_domain::{
    FlightState, NodeTime, Refusal, Task, TrajectoryObjection, TrajectoryPlan, TrajectoryRequest, TrajectoryStart,
    Trigger, VehicleId,
};
use skein_state::VehicleMessage;
use skein_state::asks::Ask;
use skein_view::EventKind;
use skein_view::PeerSnapshot;
use std::collections::BTreeMap;

/// How often a request is planned anew because things changed meanwhile.
const ATTEMPTS: u8 = 5;
/// What begins soon begins so many seconds after it was asked for: planning is over by then.
const SOON_S: f64 = 0.6;
/// Nothing begins later than this after it was asked for, in seconds.
const LATEST_S: f64 = 3600.0;
/// A vehicle that does not fly its trajectory so long after the start has left it, in seconds.
const TAKE_UP_S: f64 = 1.5;

/// The answer to a request.
pub type TrajectoryAnswer = Result<TrajectoryPlan, Vec<TrajectoryObjection>>;

/// A request and who waits for its answer.
pub struct TrajectoryAsk {
    /// What is asked for.
    pub request: TrajectoryRequest,
    /// It is flown if it can be; otherwise only planned.
    pub fly: bool,
    /// When it came in.
    pub asked_at: NodeTime,
    /// Where the answer goes.
    pub reply: RpcReplyPort<TrajectoryAnswer>,
}

/// A plan that was made.
pub struct PlannedTrajectories {
    ask: TrajectoryAsk,
    attempts: u8,
    /// State of formation and trajectories it was made for, and when.
    made_for: (u64, u64),
    made_at: NodeTime,
    outcome: Result<PlannedFlights, Vec<TrajectoryObjection>>,
}

fn of_all(refusal: Refusal) -> Vec<TrajectoryObjection> {
    vec![TrajectoryObjection { vehicle: None, refusal }]
}

fn clock(detail: impl Into<String>) -> Vec<TrajectoryObjection> {
    of_all(Refusal::Clock { detail: detail.into() })
}

impl CoordinatorState {
    /// Begins to plan; the result comes back as a message.
    pub(super) fn begin_trajectories(
        &mut self,
        myself: &ActorRef<CoordinatorMessage>,
        ask: TrajectoryAsk,
        attempts: u8,
    ) {
        let input = match self.trajectory_input(&ask) {
            Ok(input) => input,
            Err(objections) => return drop(ask.reply.send(Err(objections))),
        };
        let (made_for, made_at) = ((self.generation, self.flights_version), input.now);
        let peers = self.shared.peers();
        let myself = myself.clone();
        tokio::spawn(async move {
            let planned = tokio::task::spawn_blocking(move || coordination::plan_trajectories(&input, &peers)).await;
            let outcome = planned.unwrap_or_else(|_| Err(of_all(Refusal::not_running("the trajectory planner"))));
            // A coordinator that has ended has told the asker by dropping the reply.
            let _ = myself.cast(CoordinatorMessage::TrajectoriesPlanned(Box::new(PlannedTrajectories {
                ask,
                attempts,
                made_for,
                made_at,
                outcome,
            })));
        });
    }

    fn trajectory_input(&self, ask: &TrajectoryAsk) -> Result<TrajectoryInput, Vec<TrajectoryObjection>> {
        let now = self.shared.now();
        let start = match ask.request.start {
            TrajectoryStart::Soon => now.plus_seconds(SOON_S),
            TrajectoryStart::In { in_s } => ask.asked_at.plus_seconds(in_s),
            TrajectoryStart::At { time } => time,
        };
        let ahead_s = start.seconds_since(now);
        if ahead_s < LEAD_TIME_S {
            return Err(clock(format!(
                "the start is {ahead_s:.2} s from now: at least {LEAD_TIME_S} s are needed until all know of it"
            )));
        }
        if ahead_s > LATEST_S {
            return Err(clock(format!(
                "the start is {ahead_s:.0} s from now: at most {LATEST_S:.0} s are possible"
            )));
        }
        let frame = self.shared.frame().ok_or_else(|| of_all(Refusal::NoSwarmFrame))?;
        let coordination = self.shared.coordination.read().clone();
        let (mut held, mut clock_faults) = (BTreeMap::new(), std::collections::BTreeSet::new());
        for record in self.shared.vehicles.records() {
            let published = record.state();
            let holds = published.flight_state == FlightState::Holding;
            if let Some(place) = published.setpoint.and_then(|s| s.position).filter(|_| holds) {
                held.insert(record.id, place);
            }
            let alarms = published.failsafe.iter().flat_map(|failsafe| &failsafe.alarms);
            if alarms.into_iter().any(|alarm| alarm.trigger == Trigger::ClockFault) {
                clock_faults.insert(record.id);
            }
        }
        self.others_flights(&mut held, &mut clock_faults);
        Ok(TrajectoryInput {
            request: ask.request.clone(),
            flights: coordination.flights,
            members: coordination.formation.map_or_else(Vec::new, |f| f.members),
            held,
            clock_faults,
            limits: self.plan_limits(),
            gate: self.shared.gate(),
            frame,
            now,
            start,
        })
    }

    /// A plan is there: it is flown if it still fits.
    pub(super) fn take_trajectories(&mut self, myself: &ActorRef<CoordinatorMessage>, planned: PlannedTrajectories) {
        let PlannedTrajectories {
            ask,
            attempts,
            made_for,
            made_at,
            outcome,
        } = planned;
        let flown = match outcome {
            Ok(flown) if ask.fly => flown,
            answer => return drop(ask.reply.send(answer.map(|flown| flown.plan))),
        };
        let now = self.shared.now();
        if !self.shared.coordinates() {
            return drop(ask.reply.send(Err(of_all(Refusal::Superseded))));
        }
        let changed = made_for != (self.generation, self.flights_version);
        let late = flown.plan.start.seconds_since(now) < LEAD_TIME_S;
        let soon = ask.request.start == TrajectoryStart::Soon;
        if changed || self.begins_meanwhile(&flown, made_at, now) || (late && soon) {
            if attempts < ATTEMPTS {
                self.begin_trajectories(myself, ask, attempts + 1);
            } else {
                drop(ask.reply.send(Err(of_all(Refusal::Superseded))));
            }
        } else if late {
            let why = "the start has passed while it was planned";
            drop(ask.reply.send(Err(clock(why))));
        } else {
            let mut plan = flown.plan.clone();
            plan.starts_in_s = plan.start.seconds_since(now);
            self.fly_trajectories(flown);
            let _ = ask.reply.send(Ok(plan));
        }
    }

    /// Whether a former trajectory of one of them begins between planning and publishing: it was taken for one that stands, and may move.
    fn begins_meanwhile(&self, flown: &PlannedFlights, from: NodeTime, to: NodeTime) -> bool {
        let window = from.plus_seconds(-LEAD_TIME_S)..=to.plus_seconds(LEAD_TIME_S);
        let coordination = self.shared.coordination.read();
        let former = |id| coordination.flights.get(id).filter(|f| f.is_on());
        flown
            .flights
            .keys()
            .filter_map(former)
            .any(|f| window.contains(&f.trajectory.start))
    }

    fn fly_trajectories(&mut self, flown: PlannedFlights) {
        let PlannedFlights { plan, flights, routes } = flown;
        let ids: Vec<VehicleId> = flights.keys().copied().collect();
        // The operator calls them back.
        self.shared.vehicles.call_back(&ids);
        self.shared.coordination.change().flights.extend(flights);
        self.flights_version += 1;
        self.publish();
        for (id, points) in routes {
            let actor = self.shared.vehicles.record(id).and_then(|record| record.actor.get());
            if let Some(node) = self.shared.host(id) {
                self.ask_elsewhere(node, Ask::Upload(vec![(id, points)]));
            } else if let Some(actor) = actor {
                let _ = actor.cast(VehicleMessage::UploadRoute(points));
            }
        }
        let apart = plan
            .min_distance_m
            .map_or_else(String::new, |m| format!(", {m:.1} m apart at least"));
        let text = format!(
            "trajectories of {} begin in {:.1} s: {:.1} s{apart}",
            list(&ids),
            plan.starts_in_s,
            plan.duration_s
        );
        self.tell_trajectory(None, Severity::Info, text);
    }

    /// Ends all trajectories; who flew one holds.
    pub(super) fn end_trajectories(&mut self) -> Vec<VehicleId> {
        let mut ended = Vec::new();
        for (id, flight) in &mut self.shared.coordination.change().flights {
            if flight.is_on() {
                flight.ended = Some("ended by an operator".to_owned());
                ended.push(*id);
            }
        }
        if !ended.is_empty() {
            self.flights_version += 1;
            self.publish();
            self.tell_trajectory(None, Severity::Info, format!("trajectories of {} ended", list(&ended)));
        }
        ended
    }

    /// Members of a formation fly no trajectory of their own.
    pub(super) fn leave_trajectories(&mut self, members: &[VehicleId]) {
        let mut coordination = self.shared.coordination.change();
        for id in members {
            if let Some(flight) = coordination.flights.get_mut(id).filter(|f| f.is_on()) {
                flight.ended = Some("taken into the formation".to_owned());
                self.flights_version += 1;
            }
        }
    }

    /// The vehicles without those that are on their way along a trajectory: who is not named is not called away from it.
    pub(super) fn without_flights(&self, peers: &PeerSnapshot) -> PeerSnapshot {
        let coordination = self.shared.coordination.read();
        let flies = |id: &VehicleId| coordination.flights.get(id).is_some_and(|f| f.is_on() && !f.finished);
        let mut left = peers.clone();
        left.entries.retain(|e| !flies(&e.id));
        left
    }

    /// Notes who has come to the end, and who does something else by now.
    pub(super) fn review_trajectories(&mut self, peers: &PeerSnapshot) {
        let now = self.shared.now();
        let withdrawn = self.shared.vehicles.withdrawn();
        let intent = self.shared.coordination.intent();
        let mut left = Vec::new();
        for (id, flight) in &mut self.shared.coordination.change().flights {
            if !flight.is_on() {
                continue;
            }
            let told = self.route_finished(*id);
            let task = intent.tasks.get(id).filter(|t| matches!(t.task, Task::Fly(_)));
            flight.finished |= told.is_some() && told == task.map(|t| t.version);
            let why = if withdrawn.contains(id) {
                Some("commanded otherwise".to_owned())
            } else {
                why_left(flight, *id, peers, now)
            };
            if let Some(why) = why {
                left.push((*id, flight.finished, why.clone()));
                flight.ended = Some(why);
            }
        }
        if left.is_empty() {
            return;
        }
        self.flights_version += 1;
        self.publish();
        for (id, finished, why) in left {
            let severity = if finished { Severity::Info } else { Severity::Advisory };
            self.tell_trajectory(
                Some(id),
                severity,
                format!("vehicle {id} has left its trajectory: {why}"),
            );
        }
    }

    fn tell_trajectory(&self, vehicle: Option<VehicleId>, severity: Severity, text: String) {
        self.shared
            .events
            .record(self.shared.now(), vehicle, severity, EventKind::Trajectory, text);
    }
}

/// Why a vehicle does not fly its trajectory any more; nothing if it does, or waits for the start.
fn why_left(flight: &Flight, id: VehicleId, peers: &PeerSnapshot, now: NodeTime) -> Option<String> {
    let Some(entry) = peers.entry(id) else {
        return Some("it is not there any more".to_owned());
    };
    if !entry.link.connected {
        return Some("its link is lost".to_owned());
    }
    if entry.under_order {
        return Some("a reaction of its failsafe policy is in force".to_owned());
    }
    let flies = match entry.flight_state {
        FlightState::GoingTo => true,
        FlightState::Holding => flight.finished || now.seconds_since(flight.trajectory.start) < TAKE_UP_S,
        _ => false,
    };
    (!flies).then(|| format!("it is {}", entry.flight_state))
}
