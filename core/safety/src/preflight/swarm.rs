//! The items of the swarm as a whole.

use super::{Subject, Unit, must_be};
use skein_domain::preflight::PreflightSettings;
use skein_domain::{ItemStatus, NodeTime, PositionNed, PreflightItem, PreflightReport, VehicleId};

/// What is known of the swarm before any of it is armed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SwarmChecks {
    /// The common frame is set.
    pub frame_known: bool,
    /// Where the vehicles on the ground stand.
    pub on_ground: Vec<(VehicleId, PositionNed)>,
    /// What each vehicle's clock is off the common one by, in seconds: after its offset is taken out, what is left of it.
    pub clock_offsets_s: Vec<(VehicleId, f64)>,
    /// The coordinator runs.
    pub coordinator_running: bool,
    /// Vehicles that can host the coordinator.
    pub coordinator_capable: u32,
    /// Fences that are loaded; `None` if loading one failed.
    pub fences: Option<u32>,
    /// Vehicles whose launch place is outside of a fence.
    pub homes_outside: Vec<VehicleId>,
    /// Vehicles whose launch place is not known.
    pub homes_unknown: Vec<VehicleId>,
}

/// The report on the swarm. Items of plugins are added to it by the caller.
#[must_use]
pub fn swarm_report(checks: &SwarmChecks, settings: &PreflightSettings, now: NodeTime) -> PreflightReport {
    PreflightReport {
        vehicle: None,
        items: vec![
            frame(checks),
            ground_distance(checks, settings),
            clock_spread(checks, settings),
            coordinator(checks),
            coordinator_vehicles(checks, settings),
            fences(checks, settings),
            homes(checks),
        ],
        made_at: now,
    }
}

fn frame(c: &SwarmChecks) -> PreflightItem {
    let subject = Subject::new("swarm_frame", "Common frame")
        .because("without it no place of one vehicle means anything to another");
    subject.word(
        must_be(Some(c.frame_known)),
        if c.frame_known { "known" } else { "not known" },
    )
}

fn ground_distance(c: &SwarmChecks, s: &PreflightSettings) -> PreflightItem {
    let subject = Subject::new("ground_distance", "Distance on the ground")
        .because("vehicles that stand too close touch when they take off");
    let mut closest: Option<(f64, VehicleId, VehicleId)> = None;
    for (i, (a, at)) in c.on_ground.iter().enumerate() {
        for (b, other) in c.on_ground.iter().skip(i + 1) {
            let distance_m = at.distance_m(other);
            // A place that is not a number is as close as can be.
            let distance_m = if distance_m.is_finite() { distance_m } else { 0.0 };
            if closest.is_none_or(|(least_m, ..)| distance_m < least_m) {
                closest = Some((distance_m, *a, *b));
            }
        }
    }
    let Some((distance_m, a, b)) = closest else {
        return subject.word(ItemStatus::Green, "no two on the ground");
    };
    let limit_m = s.min_ground_distance_m;
    let item = subject.at_least(Some(distance_m), limit_m, limit_m, Unit::METRES);
    PreflightItem {
        value: format!("{} between {a} and {b}", item.value),
        ..item
    }
}

fn clock_spread(c: &SwarmChecks, s: &PreflightSettings) -> PreflightItem {
    let subject = Subject::new("clock_spread", "Clocks agree")
        .because("vehicles that fly together start together and know each other's positions of the same moment");
    if c.clock_offsets_s.is_empty() {
        return subject.word(ItemStatus::Amber, "not known");
    }
    let offsets = c.clock_offsets_s.iter().map(|(_, offset_s)| *offset_s);
    let (low, high) = offsets.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), o| {
        if o.is_finite() {
            (f64::min(low, o), f64::max(high, o))
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        }
    });
    subject.at_most(
        Some(high - low),
        s.max_clock_spread_s,
        s.max_clock_spread_s,
        Unit::SECONDS,
    )
}

fn coordinator(c: &SwarmChecks) -> PreflightItem {
    let subject = Subject::new("coordinator", "Coordinator").because("it decides who leads and who has which slot");
    let value = if c.coordinator_running {
        "running"
    } else {
        "not running"
    };
    subject.word(must_be(Some(c.coordinator_running)), value)
}

fn coordinator_vehicles(c: &SwarmChecks, s: &PreflightSettings) -> PreflightItem {
    let subject = Subject::new("coordinator_vehicle", "Vehicles that can host the coordinator")
        .because("one of them carries on when the coordinator is lost");
    let count = f64::from(c.coordinator_capable);
    let needed = if s.require_coordinator_vehicle { 1.0 } else { 0.0 };
    subject.at_least(Some(count), needed, needed, Unit::COUNT)
}

fn fences(c: &SwarmChecks, s: &PreflightSettings) -> PreflightItem {
    let subject = Subject::new("fences", "Fences").because("what bounds the flight must be known before it begins");
    match c.fences {
        None => subject.word(ItemStatus::Red, "could not be loaded"),
        Some(0) if s.require_fence => subject.word(ItemStatus::Red, "none"),
        Some(0) => subject.word(ItemStatus::Amber, "none"),
        Some(count) => subject.word(ItemStatus::Green, format!("{count} loaded")),
    }
}

fn homes(c: &SwarmChecks) -> PreflightItem {
    let subject = Subject::new("homes_inside", "Launch places inside of the fences")
        .because("a return would lead out of the fence");
    let list = |vehicles: &[VehicleId]| vehicles.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    if !c.homes_outside.is_empty() {
        return subject.word(ItemStatus::Red, format!("outside: {}", list(&c.homes_outside)));
    }
    if !c.homes_unknown.is_empty() {
        return subject.word(ItemStatus::Amber, format!("not known: {}", list(&c.homes_unknown)));
    }
    subject.word(ItemStatus::Green, "all inside")
}
