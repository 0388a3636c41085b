//! Who is to keep a track in view: which vehicles are best placed for it, from which sides, and who takes over from one that no longer can.
//!
//! Must never do: command anybody.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::{EnergyLevel, PositionNed, VehicleId};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// At this distance, in metres, nearness counts for half.
const HALF_NEAR_M: f64 = 200.0;
/// What counts for how much; together 1.
const NEARNESS: f64 = 0.35;
const CHARGE: f64 = 0.25;
const GIMBAL: f64 = 0.2;
const FREE: f64 = 0.2;

/// A track that vehicles keep in view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackObservation {
    /// Its number.
    pub track: u64,
    /// Who keeps it in view, and from which side: the bearing from the track to the vehicle, in radians clockwise from north.
    pub by: Vec<(VehicleId, f64)>,
    /// Horizontal distance to keep, in metres; each model's own if absent.
    pub stand_off_m: Option<f64>,
}

/// A vehicle whose model can keep something in view.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Which.
    pub vehicle: VehicleId,
    /// Where it is, if that is known.
    pub position: Option<PositionNed>,
    /// It is heard, in the air, and no pilot or failsafe flies it; otherwise why it cannot be asked.
    pub unfit: Option<String>,
    /// It is in the air.
    pub flies: bool,
    /// Charge that is left, 0..=1, if known.
    pub battery: Option<f64>,
    /// How urgent its way home is, if known.
    pub energy: Option<EnergyLevel>,
    /// It has a camera on a gimbal.
    pub gimbal_camera: bool,
    /// What it is doing for somebody; absent if nothing.
    pub busy: Option<String>,
}

/// How well a vehicle is placed to keep something in view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
pub struct ObserverProposal {
    /// Which.
    pub vehicle: VehicleId,
    /// How well: 0..=1, the greatest is the best. Of nearness, charge, a camera on a gimbal, and being free.
    pub score: f64,
    /// How far it is from the track, in metres; null if its place is not known.
    pub distance_m: Option<f64>,
    /// Charge that is left, 0..=1; null if not known.
    pub battery: Option<f64>,
    /// It is in the air.
    pub flies: bool,
    /// It has a camera on a gimbal.
    pub gimbal_camera: bool,
    /// What it is doing already, in words; null if nothing.
    pub busy: Option<String>,
    /// Why it cannot be asked, in words; null if it can.
    pub unfit: Option<String>,
}

/// All of them, the best first: those that can be asked before those that cannot.
#[must_use]
pub fn ranked(target: &PositionNed, candidates: &[Candidate]) -> Vec<ObserverProposal> {
    let mut all: Vec<ObserverProposal> = candidates.iter().map(|candidate| proposal(target, candidate)).collect();
    all.sort_by(|a, b| {
        let by_fitness = a.unfit.is_some().cmp(&b.unfit.is_some());
        by_fitness
            .then(b.score.total_cmp(&a.score))
            .then(a.vehicle.cmp(&b.vehicle))
    });
    all
}

fn proposal(target: &PositionNed, candidate: &Candidate) -> ObserverProposal {
    let distance_m = candidate
        .position
        .map(|position| position.distance_m(target))
        .filter(|distance_m| distance_m.is_finite());
    let share = |is: bool| if is { 1.0 } else { 0.0 };
    let battery = candidate.battery.filter(|battery| battery.is_finite());
    let score = NEARNESS * distance_m.map_or(0.0, |m| HALF_NEAR_M / (HALF_NEAR_M + m))
        // A charge that is not known counts as half of one.
        + CHARGE * battery.unwrap_or(0.5).clamp(0.0, 1.0)
        + GIMBAL * share(candidate.gimbal_camera)
        + FREE * share(candidate.busy.is_none());
    let low = candidate.energy.filter(|level| *level >= EnergyLevel::ReplanSoon);
    let unfit = match (&candidate.unfit, low, distance_m) {
        (Some(why), _, _) => Some(why.clone()),
        (None, Some(level), _) => Some(format!("its charge is low ({level})")),
        (None, None, None) => Some("its place is not known".to_owned()),
        (None, None, Some(_)) => None,
    };
    ObserverProposal {
        vehicle: candidate.vehicle,
        score,
        distance_m,
        battery,
        flies: candidate.flies,
        gimbal_camera: candidate.gimbal_camera,
        busy: candidate.busy.clone(),
        unfit,
    }
}

/// From which side each is to look, in radians clockwise from north: spread evenly around the target, so that nobody has to pass another one on the way
/// there, with as little turning as that takes. Two stand at a right angle: the bearings of two that face each other cross nowhere.
#[must_use]
pub fn sides(target: &PositionNed, vehicles: &[(VehicleId, PositionNed)]) -> Vec<(VehicleId, f64)> {
    let bearing = |place: &PositionNed| {
        let way = place.vector() - target.vector();
        way.y.atan2(way.x).rem_euclid(TAU)
    };
    let mut present: Vec<(VehicleId, f64)> = vehicles.iter().map(|(id, place)| (*id, bearing(place))).collect();
    present.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let apart = match present.len() {
        2 => FRAC_PI_2,
        count => TAU / count.max(1) as f64,
    };
    if present.len() == 2 && present[1].1 - present[0].1 > PI {
        // The shorter way around leads through north.
        present.rotate_left(1);
    }
    let offsets = present
        .iter()
        .enumerate()
        .map(|(place, (_, bearing))| bearing - place as f64 * apart);
    let (sin, cos) = offsets.fold((0.0, 0.0), |(sin, cos), angle: f64| {
        (sin + angle.sin(), cos + angle.cos())
    });
    let first = f64::atan2(sin, cos);
    let side = |(place, (id, _)): (usize, &(VehicleId, f64))| (*id, (first + place as f64 * apart).rem_euclid(TAU));
    present.iter().enumerate().map(side).collect()
}

/// Who takes over looks from so far beside the place of who is relieved, in radians: that one may still be there, heard or not.
const BESIDE_RAD: f64 = 0.5;

/// A side beside a bearing: the one that is farther from all others who look.
fn beside(bearing_rad: f64, others_rad: &[f64]) -> f64 {
    let apart = |side: f64| {
        let off = others_rad.iter().map(|other| {
            let off = (side - other).rem_euclid(TAU);
            off.min(TAU - off)
        });
        off.fold(PI, f64::min)
    };
    let [after, before] = [BESIDE_RAD, -BESIDE_RAD].map(|off| (bearing_rad + off).rem_euclid(TAU));
    if apart(before) > apart(after) { before } else { after }
}

/// How a vehicle is that keeps something in view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObserverState {
    /// It is heard.
    pub heard: bool,
    /// How urgent its way home is, if known.
    pub energy: Option<EnergyLevel>,
    /// It was asked to take over, and refused.
    pub refused: bool,
    /// It has been told to do something else, or has done so by itself.
    pub left: bool,
}

/// Why a vehicle no longer keeps something in view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unable {
    /// It must return soon.
    LowCharge,
    /// It is not heard any more.
    Lost,
    /// It was asked to take over, and refused.
    Refused,
}

/// What changes in an observation.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// Another vehicle is to look from that side, if there is one.
    HandOver {
        /// Who no longer can.
        from: VehicleId,
        /// Why.
        why: Unable,
        /// Who is to take over.
        to: Option<VehicleId>,
        /// From which side: beside the place of who no longer can.
        bearing_rad: f64,
    },
    /// A vehicle does something else: nobody is asked in its place.
    Left(VehicleId),
}

/// What has to change so that the view is kept. `proposals` are all that could be asked, the best first; `refused` are those that have just refused.
#[must_use]
pub fn changes(
    observation: &TrackObservation,
    states: &BTreeMap<VehicleId, ObserverState>,
    proposals: &[ObserverProposal],
    refused: &[VehicleId],
) -> Vec<Change> {
    let looking = |id: &VehicleId| observation.by.iter().any(|(by, _)| by == id);
    let mut free = proposals
        .iter()
        .filter(|one| one.unfit.is_none() && !looking(&one.vehicle) && !refused.contains(&one.vehicle))
        .map(|one| one.vehicle);
    let mut changes = Vec::new();
    for (vehicle, bearing_rad) in &observation.by {
        let state = states.get(vehicle);
        let why = match state {
            None => Some(Unable::Lost),
            Some(state) if !state.heard => Some(Unable::Lost),
            Some(state) if state.energy.is_some_and(|level| level >= EnergyLevel::ReplanSoon) => {
                Some(Unable::LowCharge)
            }
            Some(state) if state.refused => Some(Unable::Refused),
            Some(_) => None,
        };
        match why {
            Some(why) => changes.push(Change::HandOver {
                from: *vehicle,
                why,
                to: free.next(),
                bearing_rad: {
                    let others = observation.by.iter().filter(|(id, _)| id != vehicle);
                    beside(*bearing_rad, &others.map(|(_, other)| *other).collect::<Vec<_>>())
                },
            }),
            None if state.is_some_and(|state| state.left) => changes.push(Change::Left(*vehicle)),
            None => {}
        }
    }
    changes
}

#[cfg(test)]
mod tests;
