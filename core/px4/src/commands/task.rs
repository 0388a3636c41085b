//! One command under way: what it waits for, and what it does when that comes or does not come.

use super::{Around, Origin};
use crate::plan::{Class, Condition, Goal, PlanStep};
use skein_domain::{LandedState, NodeTime, Refusal};

/// After the first text beside a refusal, how long a second one is awaited, in seconds.
const MORE_TEXT_S: f64 = 0.03;
/// How much longer than its confirmation a change of mode still counts as asked for, in seconds.
pub const LATE_MODE_S: f64 = 2.0;

/// Where a command stands.
#[derive(Debug)]
pub enum Phase {
    /// Until its condition holds.
    Waiting { since: NodeTime, until: NodeTime },
    /// Until no other command of its number is under way.
    Ready,
    /// Until it is acknowledged.
    Sent {
        first: NodeTime,
        confirmation: u8,
        deadline: NodeTime,
        in_progress: bool,
    },
    /// Until the words beside a refusal have come.
    Refused {
        first: NodeTime,
        result: String,
        until: NodeTime,
        latest: NodeTime,
    },
    /// Until the state that must follow is seen.
    Confirming { since: NodeTime, until: NodeTime },
}

/// What a task does next.
pub enum Next {
    /// Nothing until something happens.
    Stay,
    /// It did something; look again.
    Again,
    /// It has ended.
    End(Result<(), Refusal>),
}

/// One command under way.
#[derive(Debug)]
pub struct Task {
    pub origin: Origin,
    pub name: &'static str,
    pub class: Class,
    pub condition: Condition,
    /// The present step and those after it.
    pub steps: Vec<PlanStep>,
    pub phase: Phase,
}

impl Task {
    /// Whether its present step is this command, and was sent.
    pub fn is_sent(&self, number: u16) -> bool {
        matches!(self.phase, Phase::Sent { .. }) && self.steps.first().is_some_and(|s| s.command.number() == number)
    }

    /// The number of the command it is about to send.
    pub fn ready_number(&self) -> Option<u16> {
        let step = self.steps.first()?;
        matches!(self.phase, Phase::Ready).then(|| step.command.number())
    }

    /// What must follow its present step.
    pub fn goal(&self) -> Goal {
        self.steps.first().map_or(Goal::Acknowledged, |step| step.goal)
    }

    /// Sends its present step for the first time.
    pub fn send_first(&mut self, around: &mut Around<'_>) {
        self.send(around, 0);
        self.phase = Phase::Sent {
            first: around.now,
            confirmation: 0,
            deadline: around.now.plus_seconds(around.settings.ack_timeout_s),
            in_progress: false,
        };
    }

    /// Sends the present step, and lets the mode that comes with it count as asked for.
    fn send(&self, around: &mut Around<'_>, confirmation: u8) {
        let Some(step) = self.steps.first() else { return };
        if let Some(mode) = step.goal.mode() {
            let settings = around.settings;
            let within_s = settings.ack_timeout_s + settings.confirm_timeout_s + LATE_MODE_S;
            around.modes.expect(mode, around.now.plus_seconds(within_s));
        }
        around.outlet.command(&step.command, confirmation);
    }

    /// Does what has become due or possible, sending its first step apart.
    pub fn advance(&mut self, around: &mut Around<'_>) -> Next {
        match self.phase {
            Phase::Waiting { since, until } => self.wait_for_condition(around, since, until),
            Phase::Ready => Next::End(Ok(())),
            Phase::Sent { .. } => self.wait_for_ack(around),
            Phase::Refused { .. } => self.wait_for_text(around),
            Phase::Confirming { since, until } => self.wait_for_goal(around, since, until),
        }
    }

    fn wait_for_condition(&mut self, around: &Around<'_>, since: NodeTime, until: NodeTime) -> Next {
        let (met, what) = match self.condition {
            Condition::None => (true, ""),
            Condition::Streaming => (around.stream_has_run, "a running setpoint stream"),
            Condition::LiftedOff => {
                let lifted_off = around.situation.landed != LandedState::OnGround;
                (lifted_off, "the take-off that was to be broken off")
            }
        };
        if met {
            self.phase = Phase::Ready;
            return Next::Again;
        }
        timed_out(around.now, since, until, || what.to_owned())
    }

    fn wait_for_goal(&mut self, around: &mut Around<'_>, since: NodeTime, until: NodeTime) -> Next {
        let goal = self.goal();
        if !goal.is_met(&around.situation) {
            return timed_out(around.now, since, until, || goal.words());
        }
        if self.steps.len() <= 1 {
            return Next::End(Ok(()));
        }
        if let Some(mode) = goal.mode() {
            around.modes.forget(mode);
        }
        self.steps.remove(0);
        self.phase = Phase::Ready;
        Next::Again
    }

    fn wait_for_text(&mut self, around: &mut Around<'_>) -> Next {
        let now = around.now;
        let goal = self.goal();
        let Phase::Refused {
            first,
            result,
            until,
            latest,
        } = &mut self.phase
        else {
            return Next::Stay;
        };
        let text = around.texts.between(*first, *latest);
        if now >= *until {
            if let Some(mode) = goal.mode() {
                around.modes.forget(mode);
            }
            let result = std::mem::take(result);
            return Next::End(Err(Refusal::Autopilot { result, text }));
        }
        if !text.is_empty() && *until == *latest {
            *until = now.plus_seconds(MORE_TEXT_S).min(*latest);
        }
        Next::Stay
    }

    fn wait_for_ack(&mut self, around: &mut Around<'_>) -> Next {
        let (now, settings) = (around.now, around.settings);
        let Phase::Sent {
            first,
            confirmation,
            deadline,
            in_progress,
        } = &mut self.phase
        else {
            return Next::Stay;
        };
        if now < *deadline {
            return Next::Stay;
        }
        if self.origin == Origin::Nobody {
            return Next::End(Ok(()));
        }
        if *in_progress || *confirmation + 1 >= settings.command_attempts.max(1) {
            let end = if *in_progress {
                "the end of"
            } else {
                "acknowledgement of"
            };
            let text = around.texts.between(*first, now);
            let beside = if text.is_empty() {
                String::new()
            } else {
                format!(" ({text})")
            };
            let what = format!("{end} {}{beside}", self.name);
            let after_s = now.seconds_since(*first);
            return Next::End(Err(Refusal::timed_out(what, after_s)));
        }
        *confirmation += 1;
        *deadline = now.plus_seconds(settings.ack_timeout_s);
        let again = *confirmation;
        self.send(around, again);
        Next::Stay
    }
}

fn timed_out(now: NodeTime, since: NodeTime, until: NodeTime, what: impl FnOnce() -> String) -> Next {
    if now < until {
        return Next::Stay;
    }
    let after_s = now.seconds_since(since);
    Next::End(Err(Refusal::TimedOut { what: what(), after_s }))
}
