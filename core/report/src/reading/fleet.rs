//! What is kept of the fleet: its vehicles, the distances between them at each moment, limits and fences.
//!
//! Must never do: compare vehicles of different moments, or one on the ground.

use super::Since;
use super::findings::Findings;
use super::vehicle::{Vehicle, airborne, place_now};
use super::wire::{FailsafeRules, JudgedSetpoint, WholeFleet, WholeFormation};
use crate::curve::{Sample, Thinner};
use crate::facts::{ChartFacts, LimitFrom, MapFacts, Near, VehicleFacts, ZoneFacts};
use crate::nearest::{Nearest, nearest};
use skein_domain::{Geodetic, NodeTime, PositionNed, SwarmFrame, VehicleId};
use skein_recording::VehicleTelemetry;
use skein_recording::decisions::GateState;
use skein_view::EventRecord;
use std::collections::BTreeMap;

/// Names, launch places and charges change seldom: the whole picture is looked at so often, in seconds.
const WHOLE_S: f64 = 2.0;
/// A formation that was not seen for longer has ended, in seconds.
const FORMATION_S: f64 = 6.0;
/// So many times in formation are kept.
const FORMATIONS: usize = 1_000;

/// The fleet.
#[derive(Debug)]
pub struct Fleet {
    since: Since,
    points: usize,
    vehicles: BTreeMap<VehicleId, Vehicle>,
    frame: Option<SwarmFrame>,
    whole_at: Option<NodeTime>,
    formation: Option<WholeFormation>,
    tick: Tick,
    distance: Thinner,
    charts: ChartFacts,
    map: MapFacts,
}

/// The vehicles in the air at one moment.
#[derive(Debug, Default)]
struct Tick {
    at: NodeTime,
    places: Vec<(VehicleId, PositionNed)>,
}

impl Fleet {
    pub fn new(since: Since, points: usize) -> Self {
        Self {
            since,
            points,
            vehicles: BTreeMap::new(),
            frame: None,
            whole_at: None,
            formation: None,
            tick: Tick::default(),
            distance: Thinner::new(super::POINTS),
            charts: ChartFacts::default(),
            map: MapFacts::default(),
        }
    }

    pub fn origin(&self) -> Option<Geodetic> {
        self.frame.map(|frame| frame.origin)
    }

    /// Where a vehicle was last.
    pub fn place(&self, vehicle: VehicleId) -> Option<PositionNed> {
        let last = self.vehicles.get(&vehicle)?.last()?;
        last.kinematics.map(|kinematics| kinematics.position)
    }

    fn vehicle(&mut self, id: VehicleId) -> &mut Vehicle {
        let points = self.points;
        self.vehicles.entry(id).or_insert_with(|| Vehicle::new(id, points))
    }

    pub fn telemetry(&mut self, of: VehicleTelemetry, findings: &mut Findings) {
        if of.time != self.tick.at {
            self.finish_tick(findings);
            self.tick.at = of.time;
        }
        if airborne(&of)
            && let Some(place) = place_now(&of)
        {
            self.tick.places.push((of.vehicle, place));
        }
        findings.telemetry(&of);
        let (since, in_place) = (self.since, self.is_in_place(&of));
        self.vehicle(of.vehicle).telemetry(since, of, in_place);
    }

    /// Whether it has a place in a formation that all had the time to come into. On the way to a place it is not off it.
    fn is_in_place(&self, of: &VehicleTelemetry) -> bool {
        let formation = self.formation.as_ref().filter(|one| one.settled_at <= of.time);
        formation.is_some_and(|formation| formation.members.contains(&of.vehicle))
    }

    /// All vehicles of a moment are there: who is nearest to whom.
    pub fn finish_tick(&mut self, findings: &mut Findings) {
        let t_s = self.since.s(self.tick.at);
        let found = nearest(&self.tick.places);
        self.tick.places.clear();
        let least = found.iter().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        if let Some(least) = least {
            let pair = Some(pair(least));
            self.distance.push(Sample {
                t_s,
                value: least.distance_m,
                pair,
            });
        }
        for near in &found {
            let Nearest {
                vehicle,
                other,
                distance_m,
            } = *near;
            self.vehicle(vehicle).near(Near { t_s, distance_m, other });
        }
        if let Some(limit) = self.charts.distance_limit_m.last().copied() {
            findings.distances(&found, limit.value, t_s, self);
        }
    }

    pub fn setpoint(&mut self, of: &JudgedSetpoint) {
        let since = self.since;
        let vehicle = self.vehicle(of.vehicle);
        vehicle.setpoint(since, of.time, of.refusal.is_some(), of.change.is_some());
    }

    pub fn event(&mut self, event: &EventRecord) {
        if let Some(vehicle) = event.vehicle.and_then(|id| self.vehicles.get_mut(&id)) {
            vehicle.event(event.severity);
        }
    }

    /// Whether the whole picture of a moment is wanted.
    pub fn wants_whole(&self, at: NodeTime) -> bool {
        self.whole_at.is_none_or(|last| at.seconds_since(last) >= WHOLE_S)
    }

    pub fn whole(&mut self, at: NodeTime, of: WholeFleet) {
        self.whole_at = Some(at);
        self.frame = of.frame.or(self.frame);
        let t_s = self.since.s(at);
        if of.formation.is_some() {
            let spans_s = &mut self.charts.formations_s;
            let count = spans_s.len();
            match spans_s.last_mut() {
                Some([_, until_s]) if t_s - *until_s < FORMATION_S => *until_s = t_s,
                _ if count < FORMATIONS => spans_s.push([t_s, t_s]),
                _ => {}
            }
        }
        self.formation = of.formation;
        for vehicle in of.vehicles {
            if let Some(energy) = vehicle.energy {
                self.charts.reserve = Some(energy.reserve);
            }
            let frame = self.frame;
            self.vehicle(vehicle.id).whole(vehicle, frame.as_ref());
        }
    }

    pub fn gate(&mut self, of: &GateState) {
        let limit = LimitFrom {
            t_s: self.since.s(of.time).max(0.0),
            value: of.limits.min_separation_m,
        };
        let limits = &mut self.charts.distance_limit_m;
        if limits.last().is_none_or(|last| last.value != limit.value) && limits.len() < super::POINTS {
            limits.push(limit);
        }
        self.frame = of.frame.or(self.frame);
        let Ok(gate) = of.gate() else { return };
        let zones = gate.fences().zones().iter().map(|zone| ZoneFacts {
            name: zone.name.clone(),
            kind: zone.kind,
            corners_m: zone.volume.vertices().to_vec(),
            heights_m: [zone.volume.floor_m(), zone.volume.ceiling_m()].map(|m| Some(m).filter(|m| m.is_finite())),
        });
        let zones: Vec<ZoneFacts> = zones.collect();
        if !self.map.zones.is_empty() && self.map.zones != zones {
            self.map.fence_changes += 1;
        }
        self.map.zones = zones;
    }

    pub fn failsafe_rules(&mut self, of: &FailsafeRules) {
        self.charts.tracking_limit_m = Some(of.settings.tracking_error.limit_m);
    }

    pub fn finish(self, duration_s: f64) -> (MapFacts, ChartFacts, Vec<VehicleFacts>) {
        let mut charts = self.charts;
        charts.distance_m = self.distance.finish();
        for span in &mut charts.formations_s {
            span[1] = span[1].min(duration_s);
        }
        let vehicles = self.vehicles.into_values().map(Vehicle::finish).collect();
        (self.map, charts, vehicles)
    }
}

/// Two vehicles, the lower id first.
pub fn pair(of: &Nearest) -> [VehicleId; 2] {
    [of.vehicle.min(of.other), of.vehicle.max(of.other)]
}
