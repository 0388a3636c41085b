//! What went wrong: of events, setpoints and distances those that a person has to know, the same one once with how often it came.
//!
//! Must never do: leave out a failsafe reaction, or count one thing as two.

use super::Since;
use super::fleet::{Fleet, pair};
use super::incidents::{self, Incident, Key};
use super::wire::JudgedSetpoint;
use crate::facts::{Finding, FindingKind, Step};
use crate::nearest::Nearest;
use skein_domain::exchange::Severity;
use skein_domain::{FlightMode, PositionNed, VehicleId};
use skein_recording::VehicleTelemetry;
use skein_view::{EventKind, EventRecord};
use std::collections::{BTreeMap, HashMap};

/// So many different findings are kept.
const KEPT: usize = 400;
/// Two vehicles are apart again when they were for so long, in seconds.
const APART_S: f64 = 2.0;
/// PX4 leaves OFFBOARD when fewer setpoints a second come.
const LEAST_RATE_HZ: f32 = 2.0;
/// A rate that is too low counts when it lasts, in samples of telemetry.
const LOW_SAMPLES: u32 = 3;

/// Two vehicles that are nearer than the limit.
#[derive(Debug)]
struct Close {
    began_s: f64,
    last_s: f64,
    least_m: f64,
    limit_m: f64,
    index: Option<usize>,
}

/// What was found so far.
#[derive(Debug)]
pub struct Findings {
    since: Since,
    found: Vec<Finding>,
    by_key: HashMap<Key, usize>,
    /// What lasts: a lost link, an actor that restarts, a failsafe trigger.
    open: BTreeMap<incidents::Open, usize>,
    close: BTreeMap<[VehicleId; 2], Close>,
    slow: BTreeMap<VehicleId, u32>,
    /// When each vehicle was armed first.
    armed_s: BTreeMap<VehicleId, f64>,
    left_out: u64,
}

impl Findings {
    pub fn new(since: Since) -> Self {
        Self {
            since,
            found: Vec::new(),
            by_key: HashMap::new(),
            open: BTreeMap::new(),
            close: BTreeMap::new(),
            slow: BTreeMap::new(),
            armed_s: BTreeMap::new(),
            left_out: 0,
        }
    }

    /// Adds one, or counts it to the one that is the same.
    fn add(&mut self, incident: Incident, fleet: &Fleet) -> Option<usize> {
        let place = incident.vehicle.and_then(|vehicle| fleet.place(vehicle));
        self.add_at(incident, place)
    }

    fn add_at(&mut self, incident: Incident, place: Option<PositionNed>) -> Option<usize> {
        let key = incident.key();
        if let Some(index) = self.by_key.get(&key).copied() {
            let found = self.found.get_mut(index)?;
            found.count += 1;
            found.last_s = incident.t_s;
            found.severity = found.severity.max(incident.severity);
            return Some(index);
        }
        if self.found.len() == KEPT {
            self.left_out += 1;
            return None;
        }
        let index = self.found.len();
        self.by_key.insert(key, index);
        self.found.push(Finding {
            number: 0,
            t_s: incident.t_s,
            last_s: incident.t_s,
            count: 1,
            vehicle: incident.vehicle,
            severity: incident.severity,
            kind: incident.kind,
            what: incident.what,
            done: incident.done,
            place,
        });
        Some(index)
    }

    /// What was done about the first one of its kind.
    fn done(&mut self, index: usize, t_s: f64, text: String) {
        if let Some(found) = self.found.get_mut(index)
            && found.count == 1
        {
            found.done.push(Step { t_s, text });
        }
    }

    pub fn event(&mut self, event: &EventRecord, fleet: &Fleet) {
        let t_s = self.since.s(event.time);
        if self.follows(event, t_s) {
            return;
        }
        if let EventKind::Failsafe { event: step } = &event.kind {
            return self.failsafe(event, step, t_s, fleet);
        }
        let Some((kind, what)) = incidents::of(event) else {
            return;
        };
        let incident = Incident {
            t_s,
            vehicle: event.vehicle,
            severity: event.severity.max(Severity::Warning),
            kind,
            what,
            done: incidents::done(event, t_s),
        };
        let index = self.add(incident, fleet);
        if let (Some(open), Some(index)) = (incidents::opens(event), index) {
            self.open.insert(open, index);
        }
    }

    /// Whether it tells how something that lasts went on.
    fn follows(&mut self, event: &EventRecord, t_s: f64) -> bool {
        let Some((open, text)) = incidents::closes(event) else {
            return false;
        };
        if let Some(index) = self.open.remove(&open) {
            let began_s = self.found.get(index).map_or(t_s, |found| found.last_s);
            self.done(index, t_s, format!("{text} after {:.1} s", t_s - began_s));
        }
        true
    }

    fn failsafe(&mut self, event: &EventRecord, step: &skein_domain::FailsafeEvent, t_s: f64, fleet: &Fleet) {
        let open = incidents::Open::Failsafe(event.vehicle, step.trigger);
        let known = self.open.get(&open).copied();
        let index = known.or_else(|| {
            if incidents::ends(step) {
                return None;
            }
            let incident = Incident {
                t_s,
                vehicle: event.vehicle,
                severity: event.severity,
                kind: FindingKind::Failsafe,
                what: incidents::failsafe_words(event, step),
                done: Vec::new(),
            };
            self.add(incident, fleet)
        });
        let Some(index) = index else { return };
        if let Some(found) = self.found.get_mut(index) {
            found.severity = found.severity.max(event.severity);
        }
        if let Some(text) = incidents::failsafe_step(step) {
            self.done(index, t_s, text);
        }
        if incidents::ends(step) {
            self.open.remove(&open);
        } else {
            self.open.insert(open, index);
        }
    }

    /// A setpoint that was refused, or for which no distance could be kept: events tell of the first one, these tell how often.
    pub fn setpoint(&mut self, of: &JudgedSetpoint, fleet: &Fleet) {
        let t_s = self.since.s(of.time);
        let infeasible = of.change.as_ref().filter(|change| !change.feasible);
        let (kind, what) = match (&of.refusal, infeasible) {
            (Some(refusal), _) => (FindingKind::Refusal, format!("Setpoint refused: {refusal}")),
            (None, Some(change)) => (FindingKind::Avoidance, incidents::infeasible(change)),
            _ => return,
        };
        let incident = Incident {
            t_s,
            vehicle: Some(of.vehicle),
            severity: Severity::Warning,
            kind,
            what,
            done: Vec::new(),
        };
        self.add(incident, fleet);
    }

    /// A vehicle in OFFBOARD that gets too few setpoints.
    pub fn telemetry(&mut self, of: &VehicleTelemetry) {
        if of.armed {
            self.armed_s.entry(of.vehicle).or_insert(self.since.s(of.time));
        }
        let flown = of.armed && of.link.connected && of.mode == FlightMode::Offboard;
        let slow = flown && of.link.setpoint_rate_hz < LEAST_RATE_HZ;
        let samples = self.slow.entry(of.vehicle).or_default();
        *samples = if slow { *samples + 1 } else { 0 };
        if *samples != LOW_SAMPLES {
            return;
        }
        let rate_hz = of.link.setpoint_rate_hz;
        let what = format!(
            "Setpoints came {rate_hz:.1} times a second in OFFBOARD, under the {LEAST_RATE_HZ} Hz that PX4 needs"
        );
        let incident = Incident {
            t_s: self.since.s(of.time),
            vehicle: Some(of.vehicle),
            severity: Severity::Warning,
            kind: FindingKind::Setpoints,
            what,
            done: Vec::new(),
        };
        let place = of.kinematics.map(|kinematics| kinematics.position);
        self.add_at(incident, place);
    }

    /// Who is nearer to whom than permitted, at one moment.
    pub fn distances(&mut self, nearest: &[Nearest], limit_m: f64, t_s: f64, fleet: &Fleet) {
        for near in nearest.iter().filter(|near| near.distance_m < limit_m) {
            let began = Close {
                began_s: t_s,
                last_s: t_s,
                least_m: near.distance_m,
                limit_m,
                index: None,
            };
            let close = self.close.entry(pair(near)).or_insert(began);
            close.last_s = t_s;
            close.least_m = close.least_m.min(near.distance_m);
        }
        let over = self.close.iter().filter(|(_, close)| t_s - close.last_s > APART_S);
        let over: Vec<[VehicleId; 2]> = over.map(|(pair, _)| *pair).collect();
        for pair in over {
            self.apart(pair);
        }
        let begun: Vec<[VehicleId; 2]> = self
            .close
            .iter()
            .filter(|(_, close)| close.index.is_none())
            .map(|(pair, _)| *pair)
            .collect();
        for of in begun {
            let incident = Incident {
                t_s,
                vehicle: Some(of[0]),
                severity: Severity::Critical,
                kind: FindingKind::TooClose,
                what: format!("Vehicles {} and {} nearer than permitted", of[0], of[1]),
                done: Vec::new(),
            };
            let index = self.add(incident, fleet);
            if let Some(close) = self.close.get_mut(&of) {
                close.index = index.or(Some(usize::MAX));
            }
        }
    }

    fn apart(&mut self, pair: [VehicleId; 2]) {
        let Some(close) = self.close.remove(&pair) else { return };
        let Some(index) = close.index else { return };
        let lasted_s = close.last_s - close.began_s;
        let text = format!(
            "down to {:.2} m, limit {:.2} m; under it for {lasted_s:.1} s",
            close.least_m, close.limit_m
        );
        self.done(index, close.last_s, text);
    }

    /// All of it was read: in order of time, with numbers.
    pub fn finish(mut self) -> (Vec<Finding>, u64) {
        let pairs: Vec<[VehicleId; 2]> = self.close.keys().copied().collect();
        for pair in pairs {
            self.apart(pair);
        }
        for (open, index) in std::mem::take(&mut self.open) {
            if let incidents::Open::Link(_) = open
                && let Some(found) = self.found.get_mut(index)
            {
                let t_s = found.last_s;
                found.done.push(Step {
                    t_s,
                    text: "not heard again in this recording".into(),
                });
            }
        }
        let armed_s = &self.armed_s;
        self.found.retain(|found| !is_before_flight(found, armed_s));
        self.found.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        for (at, found) in self.found.iter_mut().enumerate() {
            found.number = at + 1;
        }
        (self.found, self.left_out)
    }
}

/// What an autopilot had against being armed, and had no more when it was: it is among the events. Of one that never was armed it says why.
fn is_before_flight(found: &Finding, armed_s: &BTreeMap<VehicleId, f64>) -> bool {
    let armed_s = found.vehicle.and_then(|vehicle| armed_s.get(&vehicle));
    found.kind == FindingKind::Warning && armed_s.is_some_and(|armed_s| found.last_s < *armed_s)
}
