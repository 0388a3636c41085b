//! The safety of vehicles as the stream tells it: rounded, so that what hardly changes is not told again and again.
//!
//! Must never do: round away what matters. Words, limits and times are as they are.

use crate::protocol::{DeadMan, DeadManState, VehicleSafety};
use skein_domain::failsafe::TriggerMode;
use skein_domain::{EnergyState, FailsafeState};
use skein_runtime::NodeHandle;
use skein_view::{Avoidance, FleetSnapshot, VehicleSnapshot};

/// Shares of a battery are told in hundredths.
const SHARE: f64 = 0.01;
/// Times ahead in steps of so many seconds.
const AHEAD_S: f64 = 5.0;
/// Distances and speeds of giving way.
const AVOIDING: f64 = 0.5;
/// Values of alarms: so many digits.
const DIGITS: i32 = 2;

/// All vehicles.
pub(crate) fn of(snapshot: &FleetSnapshot) -> Vec<VehicleSafety> {
    snapshot.vehicles.iter().map(vehicle).collect()
}

fn vehicle(vehicle: &VehicleSnapshot) -> VehicleSafety {
    VehicleSafety {
        id: vehicle.id,
        failsafe: vehicle.failsafe.as_ref().map(failsafe),
        energy: vehicle.energy.map(energy),
        avoiding: vehicle.avoiding.as_ref().map(avoiding),
        stopped: vehicle.stopped,
    }
}

fn to(value: f64, step: f64) -> f64 {
    // Once more, so that 0.30000000000000004 is told as 0.3.
    ((value / step).round() * step * 1e6).round() / 1e6
}

fn to_digits(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let step = 10_f64.powi(value.abs().log10().floor() as i32 + 1 - DIGITS);
    to(value, step.max(1e-3))
}

fn failsafe(state: &FailsafeState) -> FailsafeState {
    let mut state = state.clone();
    for alarm in &mut state.alarms {
        alarm.value = to_digits(alarm.value);
    }
    state
}

fn energy(state: EnergyState) -> EnergyState {
    EnergyState {
        remaining: to(state.remaining, SHARE),
        needed_home: state.needed_home.map(|share| to(share, SHARE)),
        reserve: to(state.reserve, SHARE),
        margin: to(state.margin, SHARE),
        endurance_s: to_digits(state.endurance_s),
        return_in_s: to(state.return_in_s, AHEAD_S),
        ground_speed_home_m_s: to(state.ground_speed_home_m_s, AVOIDING),
        ..state
    }
}

fn avoiding(avoidance: &Avoidance) -> Avoidance {
    Avoidance {
        by_m_s: to(avoidance.by_m_s, AVOIDING),
        distance_m: avoidance.distance_m.map(|m| to(m, AVOIDING)),
        predicted_m: avoidance.predicted_m.map(|m| to(m, AVOIDING)),
        ..avoidance.clone()
    }
}

/// Whether somebody has to give signs of life, and whether somebody does.
pub(crate) fn dead_man(node: &NodeHandle) -> DeadMan {
    let rule = &node.config().safety.failsafe.operator_dead_man;
    let first = rule.steps.first().map_or(f64::INFINITY, |step| step.after_s);
    let silent_s = node.operator_heard().map(|heard| node.now().seconds_since(heard));
    DeadMan {
        state: match (rule.mode, silent_s) {
            (TriggerMode::Off, _) => DeadManState::Off,
            (_, None) => DeadManState::Unheard,
            (_, Some(silent_s)) if silent_s >= first => DeadManState::Silent,
            _ => DeadManState::Heard,
        },
        warns_after_s: Some(first).filter(|s| s.is_finite()),
    }
}

#[cfg(test)]
mod tests;
