//! Commands under way: sent, sent again, acknowledged, confirmed by the state that must follow; one of a kind at a time.
//!
//! An acknowledgement names the command's number and nothing else, so that two of one number must never be under way at once.
//! A command is accepted only when it was acknowledged AND what should follow was seen; a refusal carries the autopilot's
//! result and the status text beside it, which comes shortly before or after the acknowledgement.

use crate::decode::Acknowledgement;
use crate::outbox::Outbox;
use crate::settings::LinkSettings;
use crate::vehicle::mode_watch::ModeWatch;
use crate::vehicle::plan::{Class, Condition, Goal, Plan, Situation, Step};
use crate::vehicle::status_text::StatusTexts;
use skein_domain::{LandedState, NodeTime, Refusal, RequestId};

/// How much longer an `IN_PROGRESS` lets us wait, in seconds.
const PROGRESS_STEP_S: f64 = 3.0;
/// After the first text beside a refusal, how long a second one is awaited, in seconds.
const MORE_TEXT_S: f64 = 0.03;
/// After a command that was sent more than once, its number rests: a late second answer must not be taken for the next's.
const REST_S: f64 = 0.15;
/// How long a landing waits for the take-off it breaks off to begin, in seconds.
const LIFT_OFF_S: f64 = 8.0;
/// How much longer than its confirmation a change of mode still counts as asked for, in seconds.
const LATE_MODE_S: f64 = 2.0;
/// Most commands under way at once.
const TASKS_MAX: usize = 32;

/// Who asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The vehicle actor.
    Request(RequestId),
    /// The rate keeper, about this message id.
    Rate(u32),
    /// The rate keeper, for one copy of this message id.
    Copy(u32),
    /// Nobody any more: it was replaced while its acknowledgement was on the way.
    Nobody,
}

/// How a command ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// Who had asked.
    pub origin: Origin,
    /// Accepted and seen, or why not.
    pub outcome: Result<(), Refusal>,
}

/// What commands need around them.
pub struct Around<'a> {
    /// Now.
    pub now: NodeTime,
    /// Times and counts.
    pub settings: &'a LinkSettings,
    /// System and component the commands go to.
    pub target: (u8, u8),
    /// What is known of the vehicle.
    pub situation: Situation,
    /// Whether the setpoint stream has run long enough for OFFBOARD.
    pub stream_has_run: bool,
    /// Texts beside refusals.
    pub texts: &'a StatusTexts,
    /// Told which modes are asked for.
    pub modes: &'a mut ModeWatch,
    /// Frames out.
    pub outbox: &'a mut Outbox,
    /// Commands that ended.
    pub ended: &'a mut Vec<Ended>,
}

#[derive(Debug)]
enum Phase {
    /// Until its condition holds.
    Waiting {
        since: NodeTime,
        until: NodeTime,
    },
    /// Until no other command of its number is under way.
    Ready,
    Sent {
        first: NodeTime,
        confirmation: u8,
        deadline: NodeTime,
        in_progress: bool,
    },
    Refused {
        first: NodeTime,
        result: String,
        until: NodeTime,
        latest: NodeTime,
    },
    Confirming {
        since: NodeTime,
        until: NodeTime,
    },
}

#[derive(Debug)]
struct Task {
    origin: Origin,
    name: &'static str,
    class: Class,
    condition: Condition,
    /// The present step and those after it.
    steps: Vec<Step>,
    phase: Phase,
}

impl Task {
    fn is_sent(&self, number: u16) -> bool {
        matches!(self.phase, Phase::Sent { .. }) && self.steps.first().is_some_and(|s| s.command.number() == number)
    }

    fn goal(&self) -> Goal {
        self.steps.first().map_or(Goal::Acknowledged, |step| step.goal)
    }
}

/// What a task does next.
enum Next {
    Stay,
    /// It did something; look again.
    Again,
    End(Result<(), Refusal>),
}

/// The commands of one vehicle.
#[derive(Debug, Default)]
pub struct Commands {
    tasks: Vec<Task>,
    /// Command numbers that rest, and until when.
    resting: Vec<(u16, NodeTime)>,
}

impl Commands {
    /// Starts a command; an older one of the same class is replaced.
    pub fn start(&mut self, around: &mut Around<'_>, origin: Origin, plan: Plan) {
        if self.tasks.len() >= TASKS_MAX {
            let detail = format!("{TASKS_MAX} commands are under way");
            around.ended.push(Ended {
                origin,
                outcome: Err(Refusal::InvalidValue { detail }),
            });
            return;
        }
        if plan.class != Class::Service {
            self.replace(around, plan.class);
        }
        let (now, settings) = (around.now, around.settings);
        let phase = match plan.condition {
            Condition::None => Phase::Ready,
            Condition::Streaming => Phase::Waiting {
                since: now,
                until: now.plus_seconds(settings.offboard_wait_s),
            },
            Condition::LiftedOff => Phase::Waiting {
                since: now,
                until: now.plus_seconds(LIFT_OFF_S),
            },
        };
        if let (Phase::Waiting { until, .. }, Some(mode)) = (&phase, plan.steps.first().and_then(|s| s.goal.mode())) {
            // Out of a failsafe, the stream that is waited for brings OFFBOARD back before it is asked for: that is meant.
            around.modes.expect(mode, *until);
        }
        let Plan {
            name,
            class,
            condition,
            steps,
        } = plan;
        self.tasks.push(Task {
            origin,
            name,
            class,
            condition,
            steps,
            phase,
        });
        self.poll(around);
    }

    /// Takes in an acknowledgement.
    pub fn on_ack(&mut self, around: &mut Around<'_>, ack: &Acknowledgement) {
        let (now, settings) = (around.now, around.settings);
        let Some(i) = self.tasks.iter().position(|task| task.is_sent(ack.command)) else {
            return;
        };
        let Some(task) = self.tasks.get_mut(i) else { return };
        let Phase::Sent {
            first,
            confirmation,
            deadline,
            in_progress,
        } = &mut task.phase
        else {
            return;
        };
        if ack.result == Acknowledgement::IN_PROGRESS {
            let latest = first.plus_seconds(settings.progress_timeout_s);
            *deadline = now
                .plus_seconds(PROGRESS_STEP_S.max(settings.ack_timeout_s))
                .min(latest);
            *in_progress = true;
            return;
        }
        if *confirmation > 0 {
            self.resting.push((ack.command, now.plus_seconds(REST_S)));
        }
        if task.origin == Origin::Nobody {
            self.tasks.remove(i);
        } else if ack.result == Acknowledgement::ACCEPTED {
            let until = now.plus_seconds(settings.confirm_timeout_s);
            if let Some(mode) = task.goal().mode() {
                around.modes.expect(mode, until.plus_seconds(LATE_MODE_S));
            }
            task.phase = Phase::Confirming { since: now, until };
        } else {
            let latest = now.plus_seconds(settings.refusal_text_s);
            task.phase = Phase::Refused {
                first: *first,
                result: ack.result_word(),
                until: latest,
                latest,
            };
        }
        self.poll(around);
    }

    /// Does what has become due or possible.
    pub fn poll(&mut self, around: &mut Around<'_>) {
        self.resting.retain(|(_, until)| *until > around.now);
        let mut i = 0;
        while i < self.tasks.len() {
            match self.advance(i, around) {
                Next::Stay => i += 1,
                Next::Again => {}
                Next::End(outcome) => {
                    let task = self.tasks.remove(i);
                    if let Some(mode) = task.goal().mode().filter(|_| outcome.is_ok()) {
                        around.modes.forget(mode);
                    }
                    if task.origin != Origin::Nobody {
                        around.ended.push(Ended {
                            origin: task.origin,
                            outcome,
                        });
                    }
                    // One of the same number may have waited for this.
                    i = 0;
                }
            }
        }
    }

    /// When [`Self::poll`] has something to do next, if nothing is heard until then.
    #[must_use]
    pub fn due(&self) -> Option<NodeTime> {
        let tasks = self.tasks.iter().filter_map(|task| match task.phase {
            // Conditions are looked at with every frame and every tick.
            Phase::Waiting { until, .. } | Phase::Refused { until, .. } | Phase::Confirming { until, .. } => {
                Some(until)
            }
            Phase::Sent { deadline, .. } => Some(deadline),
            Phase::Ready => None,
        });
        tasks.chain(self.resting.iter().map(|(_, until)| *until)).min()
    }

    /// Whether one of the rate keeper's commands is under way.
    #[must_use]
    pub fn is_tuning(&self) -> bool {
        self.tasks
            .iter()
            .any(|task| matches!(task.origin, Origin::Rate(_) | Origin::Copy(_)))
    }

    /// Whether OFFBOARD is being asked for.
    #[must_use]
    pub fn is_entering_offboard(&self) -> bool {
        self.tasks
            .iter()
            .any(|task| task.condition == Condition::Streaming && task.origin != Origin::Nobody)
    }

    /// Ends all for one reason.
    pub fn end_all(&mut self, ended: &mut Vec<Ended>, refusal: &Refusal) {
        for task in self.tasks.drain(..).filter(|task| task.origin != Origin::Nobody) {
            ended.push(Ended {
                origin: task.origin,
                outcome: Err(refusal.clone()),
            });
        }
        self.resting.clear();
    }

    /// Ends the commands of a class that a newer one replaces. Those whose acknowledgement is on the way keep their number
    /// for as long as it may still come.
    fn replace(&mut self, around: &mut Around<'_>, class: Class) {
        let latest = around.now.plus_seconds(around.settings.ack_timeout_s);
        self.tasks.retain_mut(|task| {
            if task.class != class {
                return true;
            }
            if task.origin != Origin::Nobody {
                let refusal = match &task.phase {
                    // It has its answer; only more of the words beside it were awaited.
                    Phase::Refused {
                        first, result, latest, ..
                    } => Refusal::Autopilot {
                        result: result.clone(),
                        text: around.texts.between(*first, *latest),
                    },
                    _ => Refusal::Superseded,
                };
                around.ended.push(Ended {
                    origin: task.origin,
                    outcome: Err(refusal),
                });
            }
            task.origin = Origin::Nobody;
            match &mut task.phase {
                Phase::Sent { deadline, .. } => {
                    *deadline = latest.min(*deadline);
                    true
                }
                _ => false,
            }
        });
    }

    fn advance(&mut self, i: usize, around: &mut Around<'_>) -> Next {
        let Some(task) = self.tasks.get(i) else {
            return Next::Stay;
        };
        let now = around.now;
        match &task.phase {
            Phase::Waiting { since, until } => {
                let met = match task.condition {
                    Condition::None => true,
                    Condition::Streaming => around.stream_has_run,
                    Condition::LiftedOff => around.situation.landed != LandedState::OnGround,
                };
                if met {
                    self.enter(i, Phase::Ready)
                } else if now >= *until {
                    let what = match task.condition {
                        Condition::LiftedOff => "the take-off that was to be broken off".to_owned(),
                        _ => "a running setpoint stream".to_owned(),
                    };
                    Next::End(Err(Refusal::TimedOut {
                        what,
                        after_s: now.seconds_since(*since),
                    }))
                } else {
                    Next::Stay
                }
            }
            Phase::Ready => self.send_first(i, around),
            Phase::Sent { .. } => self.wait_for_ack(i, around),
            Phase::Refused {
                first,
                result,
                until,
                latest,
            } => {
                let text = around.texts.between(*first, *latest);
                if now >= *until {
                    if let Some(mode) = task.goal().mode() {
                        around.modes.forget(mode);
                    }
                    return Next::End(Err(Refusal::Autopilot {
                        result: result.clone(),
                        text,
                    }));
                }
                let sooner = now.plus_seconds(MORE_TEXT_S);
                if !text.is_empty() && *until == *latest && sooner < *until {
                    let (first, result, latest) = (*first, result.clone(), *latest);
                    return self.enter(
                        i,
                        Phase::Refused {
                            first,
                            result,
                            until: sooner,
                            latest,
                        },
                    );
                }
                Next::Stay
            }
            Phase::Confirming { since, until } => {
                if task.goal().is_met(&around.situation) {
                    self.next_step(i, around)
                } else if now >= *until {
                    Next::End(Err(Refusal::TimedOut {
                        what: task.goal().words(),
                        after_s: now.seconds_since(*since),
                    }))
                } else {
                    Next::Stay
                }
            }
        }
    }

    fn enter(&mut self, i: usize, phase: Phase) -> Next {
        if let Some(task) = self.tasks.get_mut(i) {
            task.phase = phase;
        }
        Next::Again
    }

    fn next_step(&mut self, i: usize, around: &mut Around<'_>) -> Next {
        let Some(task) = self.tasks.get_mut(i) else {
            return Next::Stay;
        };
        if task.steps.len() <= 1 {
            return Next::End(Ok(()));
        }
        let done = task.steps.remove(0);
        if let Some(mode) = done.goal.mode() {
            around.modes.forget(mode);
        }
        task.phase = Phase::Ready;
        Next::Again
    }

    fn send_first(&mut self, i: usize, around: &mut Around<'_>) -> Next {
        let Some(step) = self.tasks.get(i).and_then(|task| task.steps.first()).copied() else {
            return Next::End(Ok(()));
        };
        let number = step.command.number();
        let taken = self.tasks.iter().any(|task| task.is_sent(number))
            || self.resting.iter().any(|(resting, _)| *resting == number);
        if taken {
            return Next::Stay;
        }
        send(around, &step, 0);
        let deadline = around.now.plus_seconds(around.settings.ack_timeout_s);
        let phase = Phase::Sent {
            first: around.now,
            confirmation: 0,
            deadline,
            in_progress: false,
        };
        if let Some(task) = self.tasks.get_mut(i) {
            task.phase = phase;
        }
        Next::Stay
    }

    fn wait_for_ack(&mut self, i: usize, around: &mut Around<'_>) -> Next {
        let (now, settings) = (around.now, around.settings);
        let Some(task) = self.tasks.get_mut(i) else {
            return Next::Stay;
        };
        let Phase::Sent {
            first,
            confirmation,
            deadline,
            in_progress,
        } = &mut task.phase
        else {
            return Next::Stay;
        };
        if now < *deadline {
            return Next::Stay;
        }
        let after_s = now.seconds_since(*first);
        if task.origin == Origin::Nobody {
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
            let what = format!("{end} {}{beside}", task.name);
            return Next::End(Err(Refusal::TimedOut { what, after_s }));
        }
        *confirmation += 1;
        *deadline = now.plus_seconds(settings.ack_timeout_s);
        let again = *confirmation;
        if let Some(step) = task.steps.first() {
            send(around, step, again);
        }
        Next::Stay
    }
}

/// Sends a step's command and lets the mode that comes with it count as asked for.
fn send(around: &mut Around<'_>, step: &Step, confirmation: u8) {
    if let Some(mode) = step.goal.mode() {
        let settings = around.settings;
        let until = around
            .now
            .plus_seconds(settings.ack_timeout_s + settings.confirm_timeout_s + LATE_MODE_S);
        around.modes.expect(mode, until);
    }
    match step.command.int_message(around.target) {
        Some(message) => around.outbox.push(&message),
        None => around
            .outbox
            .push(&step.command.long_message(confirmation, around.target)),
    }
}

#[cfg(test)]
mod tests;
