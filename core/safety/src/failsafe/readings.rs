//! From a vehicle's health to one reading per trigger: how bad, against which limit, and what is to be done about it.

use super::{FenceBreach, Health};
use crate::failsafe::tracker::Tracker;
use crate::gnss::is_good_fix;
use skein_domain::failsafe::{FailsafeSettings, FailsafeStep, FenceBreachRule, TriggerMode};
use skein_domain::{EnergyLevel, FlightMode, NodeTime, Reaction, Trigger};

/// What is to be done about a trigger that lasts.
#[derive(Debug, Clone, Copy)]
pub(super) enum Course<'a> {
    /// Step by step with the time.
    Steps(&'a [FailsafeStep]),
    /// One reaction, once it has been wanted for so long.
    Wanted {
        /// The reaction.
        reaction: Reaction,
        /// For how long, in seconds.
        after_s: f64,
    },
}

/// One trigger's value now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading<'a> {
    /// The value, in `unit`.
    pub value: f64,
    /// The limit, in `unit`; of ages the first step's.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Beyond the limit.
    pub bad: bool,
    /// Below what it clears at.
    pub good: bool,
    /// For how long, if the value itself says it, in seconds.
    pub lasted_s: Option<f64>,
    /// What is to be done.
    pub course: Course<'a>,
}

/// What readings are made of beside the health: what the failsafe policy remembers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Memory {
    /// When a good fix was last reported.
    pub gnss_good_at: Option<NodeTime>,
    /// Since when it has been heard without a silence.
    pub heard_since: NodeTime,
    /// How far the clocks are from where they should be, in seconds.
    pub clock_deviation_s: f64,
    /// Since when the vehicle has been in the air and under the swarm's control.
    pub reacting_since: Option<NodeTime>,
}

/// When the newest good fix was reported, as far as this health tells.
pub(super) fn good_fix_at(health: &Health, settings: &FailsafeSettings) -> Option<NodeTime> {
    health
        .gnss
        .filter(|g| is_good_fix(g.fix) && g.satellites >= settings.gnss_loss.min_satellites)
        .map(|g| g.heard)
}

/// The reading of a trigger; `None` if there is nothing to read, or it is switched off.
pub(super) fn read<'a>(
    trigger: Trigger,
    now: NodeTime,
    health: &Health,
    settings: &'a FailsafeSettings,
    memory: &Memory,
    tracker: &Tracker,
) -> Option<Reading<'a>> {
    if settings.mode(trigger) == TriggerMode::Off {
        return None;
    }
    let steps = settings.steps(trigger);
    let age = |at: NodeTime| by_age(now.seconds_since(at).max(0.0), steps);
    // While nothing at all is heard, that is the link's trouble; and what comes first after a silence tells nothing of what comes next.
    let heard_without = |at: NodeTime| {
        let since = at.max(memory.heard_since);
        by_age(health.last_heard.seconds_since(since).max(0.0), steps)
    };
    match trigger {
        Trigger::LinkLoss => age(health.last_heard),
        Trigger::GnssLoss => memory.gnss_good_at.and_then(heard_without),
        Trigger::GnssDisagreement => {
            let rule = &settings.gnss_disagreement;
            health
                .disagreement_m
                .map(|value| beyond(value, (rule.limit_m, rule.clear_m), "m", steps))
        }
        Trigger::TrackingError => {
            let rule = &settings.tracking_error;
            health
                .tracking_error_m
                .filter(|_| !flies_by_itself(health.mode))
                .map(|value| beyond(value, (rule.limit_m, rule.clear_m), "m", steps))
        }
        Trigger::StaleEstimate => match health.position_time {
            Some(at) => heard_without(at),
            None if health.airborne => by_age(f64::INFINITY, steps),
            None => None,
        },
        Trigger::ClockFault => {
            let rule = &settings.clock_fault;
            Some(beyond(
                memory.clock_deviation_s,
                (rule.limit_s, rule.clear_s),
                "s",
                steps,
            ))
        }
        Trigger::FenceBreach => {
            let breach = health.breach.as_ref()?;
            Some(fence(now, breach, &settings.fence_breach, tracker))
        }
        Trigger::CoordinatorLoss => health.coordinator_heard.and_then(age),
        Trigger::OperatorDeadMan => health.operator_heard.or(memory.reacting_since).and_then(age),
        Trigger::Energy => energy(health, settings.energy.after_s),
    }
}

/// Whether a trigger's value is for how long something has not been heard.
pub(super) fn is_age(trigger: Trigger) -> bool {
    matches!(
        trigger,
        Trigger::LinkLoss | Trigger::GnssLoss | Trigger::StaleEstimate | Trigger::CoordinatorLoss
    )
}

/// Whether the autopilot is on a way of its own: where a setpoint would have the vehicle means nothing then.
fn flies_by_itself(mode: FlightMode) -> bool {
    matches!(
        mode,
        FlightMode::TakeOff
            | FlightMode::Mission
            | FlightMode::Return
            | FlightMode::Land
            | FlightMode::Descend
            | FlightMode::Termination
    )
}

/// A value that is itself the time for which it has been so.
fn by_age(age_s: f64, steps: &[FailsafeStep]) -> Option<Reading<'_>> {
    let limit = steps.iter().map(|s| s.after_s).fold(f64::INFINITY, f64::min);
    let bad = age_s >= limit;
    (!steps.is_empty()).then_some(Reading {
        value: age_s,
        limit,
        unit: "s",
        bad,
        good: !bad,
        lasted_s: Some(age_s),
        course: Course::Steps(steps),
    })
}

/// A value beyond a limit, over again below another. One that is not a number is beyond every limit.
fn beyond<'a>(value: f64, (limit, clear): (f64, f64), unit: &'static str, steps: &'a [FailsafeStep]) -> Reading<'a> {
    let bad = value.is_nan() || value > limit;
    Reading {
        value,
        limit,
        unit,
        bad,
        good: !bad && value <= clear.min(limit),
        lasted_s: None,
        course: Course::Steps(steps),
    }
}

fn fence<'a>(now: NodeTime, breach: &FenceBreach, rule: &FenceBreachRule, tracker: &Tracker) -> Reading<'a> {
    let mut reaction = breach.reaction;
    if let Some(stand) = tracker.stand().filter(|s| s.reaction >= Reaction::Hold) {
        let held_s = now.seconds_since(stand.since);
        if stand.reaction == Reaction::Hold && held_s >= rule.hold_for_s {
            reaction = reaction.max(Reaction::Return);
        }
        if breach.outside_m > stand.value + rule.worse_by_m {
            // Landing is the most a fence asks for: nothing brings it back sooner.
            reaction = reaction.max(stand.reaction.stronger().min(Reaction::Land));
        }
    }
    Reading {
        value: breach.outside_m,
        limit: 0.0,
        unit: "m",
        bad: true,
        good: false,
        lasted_s: None,
        course: Course::Wanted {
            reaction,
            after_s: rule.after_s,
        },
    }
}

fn energy<'a>(health: &Health, after_s: f64) -> Option<Reading<'a>> {
    let energy = health.energy?;
    let reaction = match energy.level {
        EnergyLevel::Ok | EnergyLevel::ReplanSoon => Reaction::Warn,
        EnergyLevel::ReturnNow => Reaction::Return,
        EnergyLevel::LandNow => Reaction::Land,
    };
    let bad = energy.level != EnergyLevel::Ok;
    Some(Reading {
        value: energy.margin,
        limit: 0.0,
        unit: "",
        bad,
        good: !bad,
        lasted_s: None,
        course: Course::Wanted { reaction, after_s },
    })
}
