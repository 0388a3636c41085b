//! From a purpose to a way through space, and along that way over time.

use crate::blend::{Blend, Motion, Stop};
use crate::flight::{Asking, Flying, Kept, Lead, Phase, Plan, Purpose};
use crate::model::GenericUav;
use crate::way::{Sample, Track};
use skein_domain::exchange::Severity;
use skein_domain::{AccelerationNed, NodeTime, PositionNed};
use skein_flight::{GoTo, RouteTrajectory, follow};
use skein_plugin_sdk::Effects;

impl GenericUav {
    /// Flies for another purpose from now on: in OFFBOARD already, or after the autopilot has entered it.
    pub(crate) fn fly(&mut self, purpose: Purpose, yaw_rad: Option<f64>, detail: &str, out: &mut Effects) {
        let yaw_now = self.flight.reference.and_then(|r| r.yaw_rad);
        let (engaging, after) = match &self.flight.phase {
            Phase::Flying(flying) => (flying.engaging.clone(), flying.after),
            Phase::Landing(landing) => (Some(Asking::default()), landing.asking.outstanding),
            Phase::TakingOff(taking_off) => (Some(Asking::default()), taking_off.asking.outstanding),
            _ => (Some(Asking::default()), None),
        };
        let yaw_rad = yaw_rad
            .or(yaw_now)
            .or(self.own.and_then(|own| own.kinematics).map(|k| k.yaw_rad));
        let flying = Flying {
            purpose,
            engaging,
            plan: Plan::Slot,
            elapsed_s: 0.0,
            blend: None,
            yaw_rad,
            after,
        };
        self.lay_out(flying, detail, out);
    }

    /// Lays the way out for the purpose, from where the vehicle is, and enters it.
    pub(crate) fn lay_out(&mut self, mut flying: Flying, detail: &str, out: &mut Effects) {
        self.plan_from_here(&mut flying, out);
        self.enter(Phase::Flying(flying), detail);
    }

    /// The way for the purpose, from where the vehicle is.
    pub(crate) fn plan_from_here(&mut self, flying: &mut Flying, out: &mut Effects) {
        let Some((have, at)) = self.present_motion() else {
            return;
        };
        let here = have.position;
        let above = |place: &PositionNed| PositionNed {
            down_m: here.down_m,
            ..*place
        };
        let cruise = self.settings.cruise_speed_m_s;
        let straight = |to: PositionNed, speed_m_s: f64| Plan::Straight {
            from: here,
            to,
            speed_m_s,
        };
        let stop = Plan::Stop(Stop {
            from: here,
            velocity: have.velocity,
        });
        flying.plan = match &flying.purpose {
            Purpose::TakeOff { hold } => Plan::Stop(Stop::at(*hold)),
            Purpose::Hold { at } => at.map_or(stop, |place| Plan::Stop(Stop::at(place))),
            Purpose::GoTo { to, speed_m_s } => straight(*to, *speed_m_s),
            Purpose::LandAt { spot } => straight(above(spot), cruise),
            Purpose::Home { home } => straight(above(home), cruise),
            Purpose::Guided(_) | Purpose::Steer(_) | Purpose::Lead(Lead { steered: Some(_), .. }) => Plan::Guided {
                position: here,
                velocity: have.velocity,
                acceleration: AccelerationNed::default(),
            },
            Purpose::Lead(Lead { route: Some(route), .. }) => Plan::Route {
                start: here,
                route: route.clone(),
                velocity: Some(have.velocity),
            },
            Purpose::Lead(_) => stop,
            Purpose::Follow(_) if self.usable_anchor(flying).is_some() => Plan::Slot,
            Purpose::Follow(_) => stop,
            Purpose::Keep(_) => Plan::Kept(Kept::from(&have)),
            Purpose::Fly(_) => Plan::Trajectory,
        };
        flying.elapsed_s = 0.0;
        self.track = None;
        if let Err(why) = self.build_track(&flying.plan) {
            out.notice(Severity::Warning, format!("the way cannot be flown: {why}"));
            flying.plan = Plan::Stop(Stop {
                from: here,
                velocity: have.velocity,
            });
            self.track = None;
        }
        self.blend_in(flying, &have, at);
    }

    /// Lets the difference between the motion that the vehicle has `at` a time and the plan's at that time fade out.
    pub(crate) fn blend_in(&mut self, flying: &mut Flying, have: &Motion, at: NodeTime) {
        let begin = self.sample(flying, at).motion;
        flying.blend = Blend::between(have, &begin, &self.settings);
    }

    fn build_track(&mut self, plan: &Plan) -> Result<(), skein_flight::RouteError> {
        let (limits, fastest) = (self.settings.path_limits(), self.settings.max_speed_m_s);
        self.track = Some(match plan {
            Plan::Stop(_) | Plan::Slot | Plan::Guided { .. } | Plan::Kept(_) | Plan::Trajectory => Track::None,
            Plan::Straight { from, to, speed_m_s } => {
                Track::Straight(GoTo::within(*from, *to, speed_m_s.min(fastest), &limits)?)
            }
            Plan::Route { start, route, velocity } => {
                let mut route = route.clone();
                // A speed that is not a number stays one, so that it is refused.
                if route.speed_m_s > fastest {
                    route.speed_m_s = fastest;
                }
                let velocity = velocity.unwrap_or_default();
                Track::Route(RouteTrajectory::from_motion(*start, &velocity, &route, &limits)?)
            }
        });
        Ok(())
    }

    /// Where the plan, without any blend, wants the vehicle.
    pub(crate) fn sample(&mut self, flying: &Flying, now: NodeTime) -> Sample {
        if self.track.is_none() && self.build_track(&flying.plan).is_err() {
            self.track = Some(Track::None);
        }
        let acceleration = self.settings.acceleration_m_s2;
        match (&flying.plan, &self.track) {
            (Plan::Straight { .. }, Some(Track::Straight(way))) => {
                let (position, velocity, acceleration, finished) = way.sample(flying.elapsed_s);
                let motion = Motion::new(position, velocity, acceleration);
                standing(motion, finished)
            }
            (Plan::Route { .. }, Some(Track::Route(way))) => {
                let at = way.sample(flying.elapsed_s);
                let motion = Motion::new(at.position, at.velocity, at.acceleration);
                Sample {
                    motion,
                    yaw: None,
                    // A leader that stands has no course: its formation stays as it is turned, instead of sweeping round a fixed point.
                    course_rad: (!at.finished).then_some(at.course_rad),
                    finished: at.finished,
                }
            }
            (Plan::Slot, _) => self.slot_sample(flying, now),
            (
                Plan::Guided {
                    position,
                    velocity,
                    acceleration,
                },
                _,
            ) => {
                let motion = Motion::new(*position, *velocity, *acceleration);
                standing(motion, false)
            }
            (Plan::Kept(kept), _) => standing(kept.motion(), false),
            (Plan::Trajectory, _) => match &flying.purpose {
                Purpose::Fly(fly) => self.trajectory_sample(fly, now),
                _ => self.slot_sample(flying, now),
            },
            (Plan::Stop(stop), _) => {
                let motion = stop.sample(flying.elapsed_s, acceleration);
                standing(motion, flying.elapsed_s >= stop.duration_s(acceleration))
            }
            // A plan whose way cannot be built (it was checked when it was made): stand where it began.
            (Plan::Straight { from: place, .. } | Plan::Route { start: place, .. }, _) => {
                standing(Stop::at(*place).sample(0.0, acceleration), true)
            }
        }
    }

    fn slot_sample(&self, flying: &Flying, now: NodeTime) -> Sample {
        let (Purpose::Follow(follow), Some(anchor)) = (&flying.purpose, self.usable_anchor(flying)) else {
            let reference = self
                .flight
                .reference
                .map(|r| r.position)
                .or(self.measured().map(|m| m.position));
            return standing(Stop::at(reference.unwrap_or_default()).sample(0.0, 1.0), false);
        };
        let slot = follow.previous.as_ref().unwrap_or(&follow.slot);
        let setpoint = follow::setpoint(&anchor, slot, now);
        let motion = Motion {
            position: setpoint.position.unwrap_or_default(),
            velocity: setpoint.velocity.unwrap_or_default(),
            acceleration: setpoint.acceleration.unwrap_or_default(),
        };
        Sample {
            motion,
            yaw: setpoint.yaw_rad.zip(setpoint.yaw_rate_rad_s),
            course_rad: None,
            finished: false,
        }
    }
}

fn standing(motion: Motion, finished: bool) -> Sample {
    Sample {
        motion,
        yaw: None,
        course_rad: None,
        finished,
    }
}
