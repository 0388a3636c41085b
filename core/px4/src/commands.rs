//! Commands under way: sent, sent again, acknowledged, confirmed by the state that must follow; one of a kind at a time.
//!
//! An acknowledgement names the command's number and nothing else, so that two of one number must never be under way at once.
//! A command is accepted only when it was acknowledged AND what should follow was seen; a refusal carries the autopilot's
//! result and the status text beside it, which comes shortly before or after the acknowledgement.

mod task;

use crate::acknowledgement::Acknowledgement;
use crate::mode_watch::ModeWatch;
use crate::plan::{Class, Command, Condition, Plan, Situation};
use crate::settings::LinkSettings;
use crate::status_text::StatusTexts;
use skein_domain::{NodeTime, Refusal, RequestId};
use task::{LATE_MODE_S, Next, Phase, Task};

/// How much longer an `IN_PROGRESS` lets us wait, in seconds.
const PROGRESS_STEP_S: f64 = 3.0;
/// After a command that was sent more than once, its number rests: a late second answer must not be taken for the next's.
const REST_S: f64 = 0.15;
/// How long a landing waits for the take-off it breaks off to begin, in seconds.
const LIFT_OFF_S: f64 = 8.0;
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

/// What carries commands to the vehicle. MAVLink is one way, DDS another; the rules of this module are the same on any.
pub trait CommandOutlet {
    /// Sends one; `confirmation` counts how often it was sent before.
    fn command(&mut self, command: &Command, confirmation: u8);
}

/// What commands need around them.
pub struct Around<'a> {
    /// Now.
    pub now: NodeTime,
    /// Times and counts.
    pub settings: &'a LinkSettings,
    /// What is known of the vehicle.
    pub situation: Situation,
    /// Whether the setpoint stream has run long enough for OFFBOARD.
    pub stream_has_run: bool,
    /// Texts beside refusals.
    pub texts: &'a StatusTexts,
    /// Told which modes are asked for.
    pub modes: &'a mut ModeWatch,
    /// The way out.
    pub outlet: &'a mut dyn CommandOutlet,
    /// Commands that ended.
    pub ended: &'a mut Vec<Ended>,
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

    /// Ends every command that flies or arms: an emergency stop goes ahead of all of them. Acknowledgements that are still on the
    /// way find nobody any more.
    pub fn end_flying(&mut self, ended: &mut Vec<Ended>, refusal: &Refusal) {
        self.tasks.retain(|task| {
            if task.class != Class::Service && task.origin != Origin::Nobody {
                ended.push(Ended {
                    origin: task.origin,
                    outcome: Err(refusal.clone()),
                });
            }
            task.class == Class::Service
        });
    }

    /// Lets a command's number rest: late answers to it must not be taken for those of the next.
    pub fn rest(&mut self, number: u16, until: NodeTime) {
        self.resting.push((number, until));
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
        let Some(number) = self.tasks.get(i).and_then(Task::ready_number) else {
            return self.tasks.get_mut(i).map_or(Next::Stay, |task| task.advance(around));
        };
        let taken = self.tasks.iter().any(|task| task.is_sent(number))
            || self.resting.iter().any(|(resting, _)| *resting == number);
        if !taken && let Some(task) = self.tasks.get_mut(i) {
            task.send_first(around);
        }
        Next::Stay
    }
}

#[cfg(test)]
mod tests;
