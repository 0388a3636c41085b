//! From the ground into the air: arming, the autopilot's take-off, and back to the ground when that fails.
//!
//! Must never do: ask for a take-off before arming was confirmed. PX4 accepts it even after a refused arming and flies off later.

use crate::blend::{Motion, Stop};
use crate::flight::{Arming, Asking, Flying, Phase, Plan, Purpose, TakingOff};
use crate::model::{GenericUav, is_airborne};
use crate::modes::ARMED;
use skein_domain::exchange::{OwnState, Severity};
use skein_domain::{AutopilotCommand, FlightMode, PositionNed, Refusal};
use skein_plugin_sdk::Effects;

impl GenericUav {
    pub(crate) fn step_arming(&mut self, mut arming: Arming, own: &OwnState, out: &mut Effects) {
        if own.armed {
            self.armed(&arming, out);
            return;
        }
        let waited_s = self.flight.heard_s - arming.since_s;
        if waited_s > self.settings.arm_timeout_s {
            let refusal = arming.arm.refusal.as_ref().or(arming.mode.refusal.as_ref()).cloned();
            let refusal = refusal.unwrap_or_else(|| match own.ready_to_arm {
                Some(false) => Refusal::NotReadyToArm {
                    detail: "the autopilot did not become ready".to_owned(),
                },
                _ => Refusal::timed_out("arming", waited_s),
            });
            self.not_armed(refusal, out);
            return;
        }
        if !own.mode.arms_by_command() {
            let hold = AutopilotCommand::SetMode { mode: FlightMode::Hold };
            // Whether it was accepted shows in the mode; the time-out of arming bounds the whole.
            let _ = self.ask(&mut arming.mode, hold, u32::MAX, out);
            self.enter(Phase::Arming(arming), format!("leaving mode {}", own.mode));
            return;
        }
        if own.ready_to_arm == Some(false) {
            self.enter(Phase::Arming(arming), "waiting until the autopilot is ready");
            return;
        }
        match self.ask(&mut arming.arm, AutopilotCommand::Arm, u32::MAX, out) {
            // The state that follows shows it; accepted is not yet armed.
            None | Some(Ok(())) => {
                let refusal = arming.arm.refusal.as_ref();
                let detail = refusal.map(|refusal| format!("trying again: {refusal}"));
                let detail = detail.unwrap_or_default();
                self.enter(Phase::Arming(arming), detail);
            }
            Some(Err(refusal)) => self.not_armed(refusal, out),
        }
    }

    fn not_armed(&mut self, refusal: Refusal, out: &mut Effects) {
        self.enter(Phase::Idle, format!("not armed: {refusal}"));
        self.command_refused(refusal, out);
    }

    fn armed(&mut self, arming: &Arming, out: &mut Effects) {
        let Some(height_m) = arming.take_off_m else {
            self.enter(Phase::Idle, ARMED);
            self.command_done(out);
            return;
        };
        let Some(Motion { position: launch, .. }) = self.measured() else {
            self.begin_disarming("no position");
            self.command_refused(Refusal::NoPosition, out);
            return;
        };
        let taking_off = TakingOff {
            height_m,
            launch,
            since_s: self.flight.heard_s,
            asking: Asking::default(),
            accepted: false,
        };
        self.enter(Phase::TakingOff(taking_off.clone()), "");
        if let Some(own) = self.own {
            self.step_taking_off(taking_off, &own, out);
        }
    }

    pub(crate) fn step_taking_off(&mut self, mut taking_off: TakingOff, own: &OwnState, out: &mut Effects) {
        if !own.armed {
            self.enter(Phase::Idle, "the autopilot disarmed before it was up");
            let text = "disarmed before it was in the air".to_owned();
            self.command_refused(
                Refusal::Autopilot {
                    result: "disarmed".to_owned(),
                    text,
                },
                out,
            );
            return;
        }
        let waited_s = self.flight.heard_s - taking_off.since_s;
        if waited_s > self.settings.take_off_timeout_s {
            let refusal = Refusal::timed_out("take-off", waited_s);
            self.break_off_take_off(refusal, own, out);
            return;
        }
        if !taking_off.accepted {
            let command = AutopilotCommand::TakeOff {
                height_m: taking_off.height_m,
            };
            match self.ask(&mut taking_off.asking, command, self.settings.attempts, out) {
                None => {}
                Some(Ok(())) => taking_off.accepted = true,
                Some(Err(refusal)) => {
                    self.break_off_take_off(refusal, own, out);
                    return;
                }
            }
        } else if let Some(hold) = self.top_of_take_off(&taking_off, own) {
            let flying = Flying {
                purpose: Purpose::TakeOff { hold },
                engaging: Some(Asking::default()),
                plan: Plan::Stop(Stop::at(hold)),
                elapsed_s: 0.0,
                blend: None,
                yaw_rad: own.kinematics.map(|k| k.yaw_rad),
                after: None,
            };
            self.step_flying(flying, own, 0.0, out);
            return;
        }
        self.flight.phase = Phase::TakingOff(taking_off);
    }

    /// Where to hold, once the climb is over: the asked height is reached within a little, or the autopilot has ended it by itself.
    fn top_of_take_off(&self, taking_off: &TakingOff, own: &OwnState) -> Option<PositionNed> {
        let TakingOff { height_m, launch, .. } = *taking_off;
        let climbed_m = launch.down_m - self.measured()?.position.down_m;
        let near = climbed_m >= height_m - self.settings.take_off_reached_m;
        // Also in HOLD on the ground: then it has not climbed at all.
        let ended = own.mode == FlightMode::Hold && is_airborne(own) && climbed_m > 0.5 * height_m;
        let hold = PositionNed {
            down_m: launch.down_m - height_m,
            ..launch
        };
        (near || ended).then_some(hold)
    }

    /// A take-off that does not go on ends on the ground.
    fn break_off_take_off(&mut self, refusal: Refusal, own: &OwnState, out: &mut Effects) {
        out.notice(Severity::Warning, format!("take-off broken off: {refusal}"));
        self.command_refused(refusal, out);
        if is_airborne(own) {
            self.begin_landing(false, "take-off broken off", out);
        } else {
            self.begin_disarming("take-off broken off");
        }
    }

    pub(crate) fn step_disarming(&mut self, mut asking: Asking, own: &OwnState, out: &mut Effects) {
        if !own.armed {
            let detail = std::mem::take(&mut self.flight.detail);
            self.enter(Phase::Idle, detail);
            self.command_done(out);
            return;
        }
        match self.ask(&mut asking, AutopilotCommand::Disarm, self.settings.attempts, out) {
            None | Some(Ok(())) => self.flight.phase = Phase::Disarming(asking),
            Some(Err(refusal)) => {
                self.enter(Phase::Idle, format!("not disarmed: {refusal}"));
                self.command_refused(refusal, out);
            }
        }
    }
}
