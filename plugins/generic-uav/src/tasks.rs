//! The task in the intent: which one counts, when it is taken up, and the anchor of the formation.

use crate::blend::Motion;
use crate::flight::{Flying, Follow, Lead, Phase, Plan, Purpose};
use crate::model::GenericUav;
use skein_domain::{
    AnchorReference, FormationHeading, NodeTime, Refusal, Route, SlotMove, Task, VehicleId, VehicleTask,
};
use skein_flight::HeadingFollower;
use skein_plugin_sdk::Effects;

/// Leader and follower learn of a change in the same control period, but not in the same microsecond: an anchor this much older than the
/// follower's change still tells of the time after it, in seconds. Half a period.
const SAME_PERIOD_S: f64 = 0.01;
/// For so long after its last anchor a new leader takes over the formation's heading instead of its own yaw, in seconds.
const HEADING_HANDOVER_S: f64 = 5.0;

impl GenericUav {
    /// A task came in: kept if it is newer than any seen.
    pub(crate) fn take_task(&mut self, task: &VehicleTask) {
        let seen = self
            .flight
            .task
            .as_ref()
            .map_or(self.flight.settled_version, |t| t.version);
        if task.version > seen.max(self.flight.settled_version) {
            self.flight.task = Some(task.clone());
        }
    }

    /// Takes the newest task up if the vehicle is in a state to do so and no command outranks it.
    pub(crate) fn take_up_task(&mut self, out: &mut Effects) {
        let Some(VehicleTask { version, task }) = self.flight.task.clone() else {
            return;
        };
        if version <= self.flight.settled_version {
            return;
        }
        let Phase::Flying(flying) = &self.flight.phase else {
            return;
        };
        let available = flying.engaging.is_none() && self.flight.phase.state().is_available_in_air();
        if !available {
            return;
        }
        if self.is_early(&task) {
            return;
        }
        self.flight.settled_version = version;
        let flying = flying.clone();
        if task == Task::Hold && matches!(flying.purpose, Purpose::Hold { .. }) {
            return; // That is what it does, perhaps by an operator's command.
        }
        if let (Task::Lead { route, heading }, Purpose::Lead(led)) = (&task, &flying.purpose)
            && led.steered.is_some()
            && (&led.route, &led.heading) == (route, heading)
        {
            return; // It is led by hand, and nothing else is asked of it.
        }
        self.command_refused(Refusal::Superseded, out);
        match task {
            Task::Hold => self.fly(Purpose::Hold { at: None }, None, "left the formation", out),
            Task::Lead { route, heading } => self.lead(flying, route, heading, out),
            Task::Follow { leader, slot } => self.follow(flying, leader, slot, out),
            Task::Keep(keeping) => self.keep(flying, keeping, out),
            Task::Fly(trajectory) => self.fly_trajectory(flying, trajectory, out),
        }
    }

    fn lead(&mut self, mut flying: Flying, route: Option<Route>, heading: FormationHeading, out: &mut Effects) {
        let (follower, same_route, finished) = match &flying.purpose {
            Purpose::Lead(before) => {
                let follower = HeadingFollower::resume(
                    turning_towards(heading, &self.settings),
                    before.heading_rad,
                    before.heading_rate_rad_s,
                );
                // Whoever was led by hand is not on its way any more.
                (
                    follower,
                    before.route == route && before.steered.is_none(),
                    before.finished,
                )
            }
            _ => (self.first_heading(heading), false, false),
        };
        let lead = Lead {
            route,
            heading,
            heading_rad: follower.heading_rad(),
            heading_rate_rad_s: follower.rate_rad_s(),
            finished: same_route && finished,
            steered: None,
        };
        flying.purpose = Purpose::Lead(lead);
        if same_route {
            // Only the heading is another: the way goes on.
            self.enter(Phase::Flying(flying), "");
        } else {
            self.lay_out(flying, "", out);
        }
    }

    /// The heading of a formation that this vehicle begins to lead: the one it followed in until now, from which it turns, or as it is
    /// asked for (its own yaw, to be turned along the course).
    fn first_heading(&self, heading: FormationHeading) -> HeadingFollower {
        let followed = match &self.flight.phase {
            Phase::Flying(Flying {
                purpose: Purpose::Follow(_),
                ..
            }) => self.flight.anchor,
            _ => None,
        };
        let age_s = |anchor: &AnchorReference| self.now.seconds_since(anchor.time).max(0.0);
        match followed.filter(|anchor| age_s(anchor) < HEADING_HANDOVER_S) {
            Some(anchor) => {
                let turned_s = age_s(&anchor).min(skein_flight::follow::MAX_EXTRAPOLATION_S);
                let heading_rad = anchor.heading_rad + anchor.heading_rate_rad_s * turned_s;
                let mode = turning_towards(heading, &self.settings);
                HeadingFollower::resume(mode, heading_rad, anchor.heading_rate_rad_s)
            }
            None => {
                let yaw_rad = self.own.and_then(|own| own.kinematics).map_or(0.0, |k| k.yaw_rad);
                HeadingFollower::new(heading, yaw_rad)
            }
        }
    }

    fn follow(&mut self, mut flying: Flying, leader: Option<VehicleId>, slot: SlotMove, out: &mut Effects) {
        let previous = match &flying.purpose {
            Purpose::Follow(before) => Some(before.previous.unwrap_or(before.slot)),
            _ => None,
        };
        let continuing = previous.is_some();
        let follow = Follow {
            leader,
            slot,
            previous,
            awaiting_since: Some(self.now),
        };
        flying.purpose = Purpose::Follow(follow);
        if continuing {
            // The slot's own time law makes the change smooth.
            self.enter(Phase::Flying(flying), "");
        } else {
            self.lay_out(flying, "waiting for the leader", out);
        }
    }

    /// The leader's anchor came in.
    pub(crate) fn take_anchor(&mut self, anchor: &AnchorReference) {
        let finite = anchor.position.is_finite() && anchor.velocity.is_finite() && anchor.acceleration.is_finite();
        if !(finite && anchor.heading_rad.is_finite() && anchor.heading_rate_rad_s.is_finite()) {
            return;
        }
        if let Phase::Flying(Flying {
            purpose: Purpose::Follow(follow),
            ..
        }) = &mut self.flight.phase
            && let Some(since) = follow.awaiting_since
        {
            if anchor.time.seconds_since(since) < -SAME_PERIOD_S {
                return; // Of the time before the change, perhaps of another leader: it does not go with the new slot.
            }
            follow.awaiting_since = None;
            let continues = follow.previous.take().is_some();
            self.flight.anchor = Some(*anchor);
            if continues {
                self.pass_over();
            }
        } else if self.flight.anchor.is_none_or(|known| anchor.time >= known.time) {
            self.flight.anchor = Some(*anchor);
        }
    }

    /// The slot is counted from another anchor from now on, perhaps of another leader, who is not exactly where its predecessor's slot
    /// had it: what the two differ by fades out, so that no setpoint jumps.
    fn pass_over(&mut self) {
        let (Phase::Flying(flying), Some((have, at))) = (&self.flight.phase, self.present_motion()) else {
            return;
        };
        let mut flying = flying.clone();
        if matches!(flying.plan, Plan::Slot) {
            let since_s = self.now.seconds_since(at).max(0.0);
            let have = Motion {
                position: have.position.after(&have.velocity, since_s),
                ..have
            };
            self.blend_in(&mut flying, &have, self.now);
            // The tick that follows moves on by the period that has just been carried on.
            flying.blend = flying.blend.map(|blend| blend.beginning_in(since_s));
            self.flight.phase = Phase::Flying(flying);
        }
    }

    /// The anchor that goes with the slot being flown, if it is young enough.
    pub(crate) fn usable_anchor(&self, flying: &Flying) -> Option<AnchorReference> {
        let Purpose::Follow(follow) = &flying.purpose else {
            return None;
        };
        // Without a former slot there is nothing to fly until the first anchor after the change.
        if follow.awaiting_since.is_some() && follow.previous.is_none() {
            return None;
        }
        let young = |anchor: &AnchorReference| age_s(anchor, self.now) <= self.settings.anchor_max_age_s;
        self.flight.anchor.filter(young)
    }
}

/// How old an anchor is, in seconds.
pub(crate) fn age_s(anchor: &AnchorReference, now: NodeTime) -> f64 {
    now.seconds_since(anchor.time)
}

/// How a heading goes on when it is to be chosen in another way: always turning with a limit, also to a fixed one, since the formation's
/// vehicles hang on it.
fn turning_towards(heading: FormationHeading, settings: &crate::Settings) -> FormationHeading {
    match heading {
        FormationHeading::Course { .. } => heading,
        FormationHeading::Fixed {
            heading_rad,
            max_rate_rad_s,
        } => {
            let within = max_rate_rad_s.map_or(settings.heading_rate_rad_s, |rate| {
                rate.min(settings.heading_rate_rad_s)
            });
            FormationHeading::Fixed {
                heading_rad,
                max_rate_rad_s: Some(within),
            }
        }
    }
}

impl Lead {
    /// Turns the formation for one period, along the course of the route if it has one.
    pub(crate) fn turn(&mut self, course_rad: Option<f64>, dt_s: f64, settings: &crate::Settings) {
        if self.steered.is_some() {
            return; // By the stick.
        }
        let towards = course_rad.unwrap_or(self.heading_rad);
        let mode = turning_towards(self.heading, settings);
        let mut follower = HeadingFollower::resume(mode, self.heading_rad, self.heading_rate_rad_s);
        (self.heading_rad, self.heading_rate_rad_s) = follower.step(towards, dt_s);
    }
}
