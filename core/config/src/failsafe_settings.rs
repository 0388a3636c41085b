//! `[safety.failsafe]`: what makes its values wrong. The settings themselves are `skein-domain`'s, because the failsafe policy is pure code.
//!
//! Must never do: let the two triggers be switched off without which nothing else is known.

use crate::problem::Problem;
use skein_domain::Trigger;
use skein_domain::failsafe::{FailsafeSettings, FailsafeStep, TriggerMode};

/// No step comes later than this, in seconds: a reaction that late is none.
const LATEST_STEP_S: f64 = 600.0;

/// Everything that is wrong with the failsafe policy.
pub(crate) fn problems(failsafe: &FailsafeSettings, problems: &mut Vec<Problem>) {
    let mut range = |key: &str, value: f64, low: f64, high: f64| {
        if !(low..=high).contains(&value) {
            let message = format!("{value} is not between {low} and {high}");
            problems.push(problem(key, &message));
        }
    };
    range("reaction_within_s", failsafe.reaction_within_s, 0.5, 30.0);
    range("recovered_after_s", failsafe.recovered_after_s, 0.1, 60.0);
    for (key, limit, clear) in [
        (
            "gnss_disagreement",
            failsafe.gnss_disagreement.limit_m,
            failsafe.gnss_disagreement.clear_m,
        ),
        (
            "tracking_error",
            failsafe.tracking_error.limit_m,
            failsafe.tracking_error.clear_m,
        ),
    ] {
        range(&format!("{key}.limit_m"), limit, 0.5, 1000.0);
        range(&format!("{key}.clear_m"), clear, 0.1, limit);
    }
    let clock = &failsafe.clock_fault;
    range("clock_fault.limit_s", clock.limit_s, 0.005, 10.0);
    range("clock_fault.clear_s", clock.clear_s, 0.001, clock.limit_s);
    range("clock_fault.max_drift_s_per_s", clock.max_drift_s_per_s, 0.0, 0.01);
    range("clock_fault.settled_after_s", clock.settled_after_s, 1.0, 60.0);
    let fence = &failsafe.fence_breach;
    range("fence_breach.after_s", fence.after_s, 0.0, 10.0);
    range("fence_breach.hold_for_s", fence.hold_for_s, 1.0, LATEST_STEP_S);
    range("fence_breach.worse_by_m", fence.worse_by_m, 1.0, 1000.0);
    range("energy.after_s", failsafe.energy.after_s, 0.0, 10.0);
    for trigger in Trigger::ALL {
        trigger_problems(failsafe, *trigger, problems);
    }
}

fn trigger_problems(failsafe: &FailsafeSettings, trigger: Trigger, problems: &mut Vec<Problem>) {
    let is_needed = matches!(trigger, Trigger::LinkLoss | Trigger::StaleEstimate);
    let (mode, steps) = match trigger {
        // Asked for as they are written: the settings' own methods already answer what is made of them.
        Trigger::LinkLoss => (failsafe.link_loss.mode, &failsafe.link_loss.steps[..]),
        Trigger::StaleEstimate => (failsafe.stale_estimate.mode, &failsafe.stale_estimate.steps[..]),
        _ => (failsafe.mode(trigger), failsafe.steps(trigger)),
    };
    if is_needed && mode == TriggerMode::Off {
        let message = "cannot be \"off\": without it nothing is known of the vehicle; \"warn_only\" is the least";
        problems.push(problem(&format!("{trigger}.mode"), message));
    }
    let has_steps = !matches!(trigger, Trigger::FenceBreach | Trigger::Energy);
    if has_steps && let Err(message) = check_steps(steps) {
        problems.push(problem(&format!("{trigger}.steps"), &message));
    }
}

fn check_steps(steps: &[FailsafeStep]) -> Result<(), String> {
    if steps.is_empty() {
        return Err("must have at least one step; mode = \"warn_only\" or \"off\" says that nothing is done".into());
    }
    if let Some(step) = steps.iter().find(|s| !(0.0..=LATEST_STEP_S).contains(&s.after_s)) {
        return Err(format!("{} s is not between 0 and {LATEST_STEP_S} s", step.after_s));
    }
    let rises =
        |pair: (&FailsafeStep, &FailsafeStep)| pair.0.after_s < pair.1.after_s && pair.0.reaction < pair.1.reaction;
    if steps.iter().zip(steps.iter().skip(1)).all(rises) {
        Ok(())
    } else {
        Err("each step must come later than the one before, and be stronger".into())
    }
}

fn problem(key: &str, message: &str) -> Problem {
    Problem {
        key: format!("safety.failsafe.{key}"),
        message: message.into(),
    }
}

#[cfg(test)]
mod tests;
