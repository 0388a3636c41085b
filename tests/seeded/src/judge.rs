//! The judge: knows the truth, and nothing of how it came about.

use crate::case::Case;
use crate::craft::Craft;
use crate::ground::Ground;
use crate::outcome::{Arrival, Closest, Crossing, Failure, Lowest, OnRoute, Outcome};
use nalgebra::Vector3;
use skein_domain::{Keeping, KeepingLaw, NeighbourPlace, OffsetFrd, VehicleId};
use skein_safety::Approach;
use skein_safety::avoidance::NeighbourId;
use skein_view::PeerSnapshot;

/// Within this distance of its place a vehicle has arrived, in metres.
const ARRIVED_M: f64 = 1.5;
/// No fence can be kept better than a vehicle knows where it is: bound of the drawn errors of the estimates, with the gusts that push a
/// hovering one off its place, in metres.
const FENCE_UNCERTAIN_M: f64 = 0.6;
/// Who was held back within this time is held back, in seconds: one that is led round something is free now and then.
const HELD_BACK_S: f64 = 8.0;

/// How the slots are kept is looked at so often, in seconds, and while the leader is faster than this, in metres per second.
const LOOK_EVERY_S: f64 = 0.1;
const MOVES_M_S: f64 = 1.0;

/// Watches a flight.
pub struct Judge {
    pub outcome: Outcome,
    approach: Approach,
    least_m: f64,
    order: Vec<usize>,
    /// How far followers were from their slots on a route, in metres; and when that was looked at last, in seconds.
    on_route_m: Vec<f64>,
    looked_s: f64,
}

impl Judge {
    pub fn new(case: &Case, ground: &Ground) -> Self {
        let settings = ground.gate.avoidance();
        Self {
            outcome: Outcome {
                seed: case.seed,
                vehicles: case.starts.len(),
                ..Outcome::default()
            },
            approach: Approach {
                max_speed_m_s: settings.max_speed_m_s,
                braking_m_s2: settings.braking_m_s2,
                reaction_s: settings.reaction_s,
                margin_m: 0.0,
            },
            least_m: settings.min_separation_m,
            order: (0..case.starts.len()).collect(),
            on_route_m: Vec::new(),
            looked_s: 0.0,
        }
    }

    /// Looks at one moment.
    pub fn watch(
        &mut self,
        now_s: f64,
        crafts: &[Craft],
        ground: &Ground,
        peers: &PeerSnapshot,
        foreign: &[Vector3<f64>],
    ) {
        self.watch_pairs(now_s, crafts);
        self.watch_slots(now_s, crafts, ground, peers);
        for craft in crafts.iter().filter(|c| c.answers()) {
            let place = craft.plant.position();
            if !place.iter().all(|x| x.is_finite()) {
                self.outcome.failures.push(Failure::NotFinite(craft.id));
            }
            for foreign in foreign {
                let distance_m = (place - foreign).norm();
                if distance_m < self.outcome.closest_foreign.distance_m {
                    self.outcome.closest_foreign = closest(distance_m, craft.id, craft.id, now_s);
                }
            }
            let height_m = -place.z;
            if height_m < self.outcome.lowest.height_m {
                self.outcome.lowest = Lowest {
                    height_m,
                    id: craft.id,
                    at_s: now_s,
                };
            }
            if ground.gate.fences().is_empty() {
                continue;
            }
            let outside_m = ground.gate.fences().excess(&place.into()).distance_m();
            let allowed_m = FENCE_UNCERTAIN_M + self.approach.stopping_m(craft.plant.velocity().norm());
            let worst = &mut self.outcome.crossing;
            if outside_m > 0.0 && outside_m - allowed_m > worst.outside_m - worst.allowed_m || worst.allowed_m == 0.0 {
                *worst = Crossing {
                    outside_m,
                    allowed_m,
                    id: craft.id,
                    at_s: now_s,
                };
            }
        }
    }

    /// How the slots are kept while a vehicle leads along a route, looked at now and then.
    fn watch_slots(&mut self, now_s: f64, crafts: &[Craft], ground: &Ground, peers: &PeerSnapshot) {
        let Some(leader) = ground.coordination.formation.as_ref().and_then(|f| f.leader) else {
            return;
        };
        let on_route = ground.coordination.route.as_ref().is_some_and(|r| !r.finished);
        let moves = |c: &Craft| c.id == leader && c.answers() && c.plant.velocity().norm() > MOVES_M_S;
        if now_s < self.looked_s + LOOK_EVERY_S || !on_route || !crafts.iter().any(moves) {
            return;
        }
        self.looked_s = now_s;
        let follows = |c: &&Craft| c.id != leader && c.answers() && !ground.withdrawn.contains(&c.id);
        for craft in crafts.iter().filter(follows) {
            let place = slot_place(craft, crafts, ground, peers);
            let off_m = place.map(|place| (place - craft.plant.position()).norm());
            self.on_route_m.extend(off_m.filter(|m| m.is_finite()));
        }
    }

    /// All pairs one of which answers: two that do not are nobody's to keep apart.
    fn watch_pairs(&mut self, now_s: f64, crafts: &[Craft]) {
        let north = |i: usize| crafts[i].plant.position().x;
        self.order.sort_by(|a, b| north(*a).total_cmp(&north(*b)));
        for (k, &i) in self.order.iter().enumerate() {
            let a = &crafts[i];
            if !a.flies() {
                continue;
            }
            let place = a.plant.position();
            for &j in &self.order[k + 1..] {
                let b = &crafts[j];
                let apart = b.plant.position() - place;
                if apart.x >= self.outcome.closest.distance_m {
                    break;
                }
                if !b.flies() || !(a.answers() || b.answers()) || !a.is_known(now_s) || !b.is_known(now_s) {
                    continue;
                }
                let distance_m = apart.norm();
                if distance_m < self.outcome.closest.distance_m {
                    self.outcome.closest = closest(distance_m, a.id, b.id, now_s);
                }
            }
        }
    }

    /// Where everyone who answers is relative to its place.
    pub fn arrivals(&self, crafts: &[Craft], ground: &Ground, peers: &PeerSnapshot) -> Vec<(VehicleId, Option<f64>)> {
        let answering = crafts.iter().filter(|c| c.answers() && !c.climbing);
        answering.map(|c| (c.id, off_m(c, crafts, ground, peers))).collect()
    }

    /// Whether everyone who has a place is there.
    pub fn all_there(&self, crafts: &[Craft], ground: &Ground, peers: &PeerSnapshot) -> bool {
        let all = self.arrivals(crafts, ground, peers);
        all.iter()
            .all(|(_, off_m)| off_m.is_none_or(|off_m| off_m <= ARRIVED_M))
    }

    /// The judgement at the end.
    pub fn close(
        mut self,
        end_s: f64,
        under_way: bool,
        crafts: &[Craft],
        ground: &Ground,
        peers: &PeerSnapshot,
    ) -> Outcome {
        let outcome = &mut self.outcome;
        outcome.end_s = end_s;
        outcome.on_route = OnRoute::of(std::mem::take(&mut self.on_route_m));
        outcome.refusals.clone_from(&ground.refusals);
        for craft in crafts {
            outcome.filter.calls += craft.calls;
            outcome.filter.changed += craft.changed;
            outcome.filter.infeasible += craft.infeasible;
        }
        if outcome.closest.distance_m < self.least_m {
            outcome.failures.push(Failure::TooClose(outcome.closest));
        }
        if outcome.closest_foreign.distance_m < self.least_m {
            outcome
                .failures
                .push(Failure::TooCloseToForeign(outcome.closest_foreign));
        }
        if outcome.crossing.outside_m > outcome.crossing.allowed_m {
            outcome.failures.push(Failure::FenceCrossed(outcome.crossing));
        }
        if outcome.lowest.height_m < ground.config.safety.min_height_m - FENCE_UNCERTAIN_M {
            outcome.failures.push(Failure::TooLow(outcome.lowest));
        }
        let all = self.arrivals(crafts, ground, peers);
        let held = held(&all, crafts, ground, peers, end_s);
        for (id, off_m) in all {
            let arrival = match (off_m, held.iter().find(|(held, _)| *held == id)) {
                (Some(off_m), _) if off_m <= ARRIVED_M => Arrival::There(off_m),
                (Some(off_m), Some((_, why))) => Arrival::Held {
                    off_m,
                    why: why.clone(),
                },
                (Some(off_m), None) if under_way => {
                    let why = "the flight was cut short: by its plan it is still under way".into();
                    self.outcome.cut_short = true;
                    Arrival::Held { off_m, why }
                }
                (Some(off_m), None) => {
                    let why = state(id, crafts);
                    self.outcome.failures.push(Failure::NotArrived {
                        id,
                        off_m,
                        why: why.clone(),
                    });
                    Arrival::Held { off_m, why }
                }
                (None, _) => match without(id, ground) {
                    Some(why) => Arrival::Without(why),
                    None => {
                        self.outcome.failures.push(Failure::Forgotten(id));
                        Arrival::Without("nothing is known".into())
                    }
                },
            };
            self.outcome.arrivals.push((id, arrival));
        }
        self.outcome
    }
}

fn closest(distance_m: f64, a: VehicleId, b: VehicleId, at_s: f64) -> Closest {
    Closest { distance_m, a, b, at_s }
}

/// Where the formation wants a follower, if it has a slot and the anchor is known.
fn slot_place(craft: &Craft, crafts: &[Craft], ground: &Ground, peers: &PeerSnapshot) -> Option<Vector3<f64>> {
    let formation = ground.coordination.formation.as_ref()?;
    let (anchor, heading_rad) = match formation.leader {
        Some(leader) => {
            let leads = crafts.iter().find(|c| c.id == leader)?;
            let heading_rad = leads.entry.anchor.map(|a| a.heading_rad);
            (leads.plant.position(), heading_rad.unwrap_or(f64::NAN))
        }
        None => peers.anchor.map(|a| (a.position.vector(), a.heading_rad))?,
    };
    let slot = formation.slots.get(&craft.id)?;
    let offset: Vector3<f64> = OffsetFrd::rotated(&slot.to, heading_rad);
    Some(anchor + offset)
}

/// How far a vehicle is from its place, if it has one.
fn off_m(craft: &Craft, crafts: &[Craft], ground: &Ground, peers: &PeerSnapshot) -> Option<f64> {
    let formation = ground.coordination.formation.as_ref()?;
    // Who was sent elsewhere may still be a member, if the rest finds no shape without it.
    if ground.withdrawn.contains(&craft.id) {
        return None;
    }
    if formation.leader == Some(craft.id) {
        // Who leads is where it should be when its route is flown.
        let under_way = ground.coordination.route.as_ref().filter(|r| !r.finished);
        let end = under_way.and_then(|r| r.route.waypoints.last());
        return Some(end.map_or(0.0, |end| (end.vector() - craft.plant.position()).norm()));
    }
    let place = slot_place(craft, crafts, ground, peers)?;
    if ground.keeps_itself
        && let Some(keeping) = formation.keeping.get(&craft.id)
    {
        return Some(off_among_neighbours_m(craft, crafts, keeping));
    }
    let off_m = (place - craft.plant.position()).norm();
    // Nobody is in place about an anchor that is nowhere.
    Some(if off_m.is_finite() { off_m } else { f64::INFINITY })
}

/// How far a vehicle that keeps its place by its neighbours is off, as it keeps it: the mean over those that answer of the distances, or of
/// the places.
fn off_among_neighbours_m(craft: &Craft, crafts: &[Craft], keeping: &Keeping) -> f64 {
    let off_m = |place: &NeighbourPlace| {
        let neighbour = crafts.iter().find(|c| c.id == place.vehicle && c.answers())?;
        let is = neighbour.plant.position() - craft.plant.position();
        let wanted = Vector3::new(place.north_m, place.east_m, place.down_m);
        Some(match keeping.law {
            KeepingLaw::Distances => (is.norm() - wanted.norm()).abs(),
            KeepingLaw::Bearings => (is - wanted).norm(),
        })
    };
    let all: Vec<f64> = keeping.neighbours.iter().filter_map(off_m).collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// Who is held back, and by what: a refusal, a fence, somebody who does not answer or was sent elsewhere, or one who is held back itself.
fn held(
    all: &[(VehicleId, Option<f64>)],
    crafts: &[Craft],
    ground: &Ground,
    peers: &PeerSnapshot,
    now_s: f64,
) -> Vec<(VehicleId, String)> {
    let away = |id: VehicleId| {
        all.iter()
            .any(|(of, off_m)| *of == id && off_m.is_some_and(|m| m > ARRIVED_M))
    };
    let mut held: Vec<(VehicleId, String)> = Vec::new();
    loop {
        let known = held.len();
        for craft in crafts.iter().filter(|c| c.answers() && away(c.id)) {
            if held.iter().any(|(id, _)| *id == craft.id) {
                continue;
            }
            let why = reason(craft, crafts, ground, &held, now_s)
                .or_else(|| closed_to_it(craft, crafts, ground, peers, &held))
                .or_else(|| of_a_neighbour(craft, ground, &held));
            if let Some(why) = why {
                held.push((craft.id, why));
            }
        }
        if held.len() == known {
            return held;
        }
    }
}

fn reason(
    craft: &Craft,
    crafts: &[Craft],
    ground: &Ground,
    held: &[(VehicleId, String)],
    now_s: f64,
) -> Option<String> {
    if let Some(refusal) = &craft.refusal {
        return Some(refusal.to_string());
    }
    let lately = craft.held_back.iter().filter(|(_, at_s)| now_s - at_s < HELD_BACK_S);
    lately
        .filter_map(|(who, _)| match who {
            None => Some("a fence".into()),
            Some(NeighbourId::Foreign(_)) => Some("a foreign aircraft".into()),
            Some(NeighbourId::Vehicle(id)) => {
                let answers = crafts.iter().any(|c| c.id == *id && c.answers() && !c.climbing);
                if !answers || ground.withdrawn.contains(id) {
                    Some(format!("{id} is in the way, which is not ours to move"))
                } else {
                    let (_, why) = held.iter().find(|(other, _)| other == id)?;
                    Some(format!("{id} is in the way, held back itself: {why}"))
                }
            }
        })
        .next()
}

/// Whether its place is one where it may not go: behind a fence, or so near somebody who does not answer, or who is held back there.
fn closed_to_it(
    craft: &Craft,
    crafts: &[Craft],
    ground: &Ground,
    peers: &PeerSnapshot,
    held: &[(VehicleId, String)],
) -> Option<String> {
    let place = slot_place(craft, crafts, ground, peers)?;
    if let Err(refusal) = ground.gate.goal(&place.into()) {
        return Some(format!("its place is closed: {refusal}"));
    }
    // What is kept free around one that does not answer: the separation, and what both may be wrong about where they are.
    let free_m = ground.gate.avoidance().min_separation_m + FENCE_UNCERTAIN_M;
    let stands = |c: &&Craft| c.flies() && c.id != craft.id && (c.plant.position() - place).norm() < free_m + ARRIVED_M;
    if let Some(by) = crafts.iter().filter(stands).find(|c| !c.answers()) {
        return Some(format!("{} stands in its place, and is not ours to move", by.id));
    }
    let why = |c: &Craft| held.iter().find(|(id, _)| *id == c.id);
    let (by, why) = crafts.iter().filter(stands).find_map(why)?;
    Some(format!("{by} stands in its place, held back itself: {why}"))
}

/// Who keeps its place by its neighbours is off it when one of them is held off its own: they know no other measure.
fn of_a_neighbour(craft: &Craft, ground: &Ground, held: &[(VehicleId, String)]) -> Option<String> {
    let keeping = ground.coordination.formation.as_ref()?.keeping.get(&craft.id)?;
    let held_off = |place: &NeighbourPlace| held.iter().find(|(id, _)| *id == place.vehicle);
    let (id, why) = keeping
        .neighbours
        .iter()
        .filter(|_| ground.keeps_itself)
        .find_map(held_off)?;
    Some(format!("its neighbour {id} is held off its place: {why}"))
}

fn state(id: VehicleId, crafts: &[Craft]) -> String {
    let Some(craft) = crafts.iter().find(|c| c.id == id) else {
        return String::new();
    };
    format!("{} {:?}", craft.entry.flight_state, craft.change)
}

/// Why a vehicle that answers has no place.
fn without(id: VehicleId, ground: &Ground) -> Option<String> {
    if ground.withdrawn.contains(&id) {
        return Some("an operator sent it elsewhere".into());
    }
    match &ground.coordination.formation {
        None => Some("no formation is flown".into()),
        Some(_) => ground.refusals.last().cloned(),
    }
}
