//! The anchor of a formation that follows no vehicle: a virtual leader, a reference that moves, a place. Worked out once per period
//! from the intent, so that every vehicle sees the same one, and goes on without the coordinator.
//!
//! Must never do: decide anything. A virtual leader's way follows from the intent alone, so that every node finds the same.

mod tether;

use crate::references::References;
use skein_domain::{AnchorPlan, AnchorReference, FormationHeading, NodeTime, PositionNed, VelocityNed};
use skein_flight::virtual_leader::VirtualLeader;
use skein_flight::{HeadingFollower, PathLimits};
use skein_safety::Fences;
use tether::{Room, Tether};

/// A reference slower than this has no course, in metres per second.
const SLOWEST_COURSE_M_S: f64 = 0.5;
/// A formation whose leader was heard this lately goes on from its heading, in seconds.
const LED_LATELY_S: f64 = 1.5;
/// After a longer gap between two periods the heading goes on without the time in between, in seconds.
const LONGEST_STEP_S: f64 = 0.25;

/// Works out the anchor of the present plan.
#[derive(Debug, Default)]
pub struct AnchorKeeper {
    plan: Option<AnchorPlan>,
    path: Option<VirtualLeader>,
    heading: Option<HeadingFollower>,
    last: Option<AnchorReference>,
    /// The anchor of whoever led last: a leader's is taken away in the moment in which the formation gets another.
    led: Option<AnchorReference>,
    tether: Tether,
}

impl AnchorKeeper {
    /// Whether the formation waits at a fence for the reference that it follows to come back.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.tether.is_held()
    }

    /// The anchor at `now`; `None` without a plan, or as long as its reference is not known. `formerly` is the heading of the
    /// formation until now, from which it turns.
    pub fn at(
        &mut self,
        plan: Option<&AnchorPlan>,
        formerly: Option<&AnchorReference>,
        references: &References,
        fences: &Fences,
        now: NodeTime,
    ) -> Option<AnchorReference> {
        self.led = formerly.copied().or(self.led);
        if self.plan.as_ref() != plan {
            self.take_up(plan, now);
        }
        let (dt_s, before) = match &self.last {
            Some(last) => (now.seconds_since(last.time).clamp(0.0, LONGEST_STEP_S), Some(*last)),
            None => (0.0, None),
        };
        let anchor = match self.plan.as_ref()? {
            AnchorPlan::Path { .. } => self.path.as_ref()?.anchor(now),
            AnchorPlan::Place {
                position, heading_rad, ..
            } => {
                let (position, heading_rad) = (*position, *heading_rad);
                self.standing(position, heading_rad, dt_s, now)
            }
            AnchorPlan::Reference { name, heading, places } => {
                let (heading, places) = (*heading, places.clone());
                let room = Room {
                    fences,
                    places: &places,
                };
                match references.anchor(name, now) {
                    Some(moving) => self.moving(moving, heading, &room, dt_s),
                    // A reference that was removed in flight: the formation stands where it was.
                    None => {
                        let before = before?;
                        AnchorReference {
                            velocity: VelocityNed::default(),
                            acceleration: skein_domain::AccelerationNed::default(),
                            heading_rate_rad_s: 0.0,
                            heading_acceleration_rad_s2: 0.0,
                            time: now,
                            ..before
                        }
                    }
                }
            }
        };
        self.last = Some(anchor);
        Some(anchor)
    }

    fn take_up(&mut self, plan: Option<&AnchorPlan>, now: NodeTime) {
        let led = self.led.filter(|led| now.seconds_since(led.time) < LED_LATELY_S);
        let present = self.last.or(led);
        if name_of(self.plan.as_ref()) != name_of(plan) {
            self.tether = Tether::default();
        }
        self.plan = plan.cloned();
        self.path = None;
        self.heading = None;
        match plan {
            None => self.last = None,
            Some(AnchorPlan::Path {
                route,
                from,
                heading_rad,
                heading,
                acceleration_m_s2,
                climb_m_s,
                descent_m_s,
                start,
            }) => {
                let limits = PathLimits {
                    acceleration_m_s2: *acceleration_m_s2,
                    climb_m_s: *climb_m_s,
                    descent_m_s: *descent_m_s,
                };
                // The plan has been made with it once: it can be flown.
                self.path = VirtualLeader::new(*from, route, &limits, *heading, *heading_rad, *start).ok();
            }
            Some(AnchorPlan::Reference { heading, .. }) => {
                self.heading = Some(match present {
                    Some(a) => HeadingFollower::resume(*heading, a.heading_rad, a.heading_rate_rad_s),
                    None => HeadingFollower::new(*heading, 0.0),
                });
            }
            Some(AnchorPlan::Place {
                heading_rad,
                max_rate_rad_s,
                ..
            }) => {
                let mode = FormationHeading::Course {
                    max_rate_rad_s: *max_rate_rad_s,
                };
                self.heading = Some(HeadingFollower::new(
                    mode,
                    present.map_or(*heading_rad, |a| a.heading_rad),
                ));
            }
        }
    }

    fn standing(&mut self, position: PositionNed, heading_rad: f64, dt_s: f64, now: NodeTime) -> AnchorReference {
        let (heading_rad, heading_rate_rad_s) = self
            .heading
            .as_mut()
            .map_or((heading_rad, 0.0), |h| h.step(heading_rad, dt_s));
        AnchorReference {
            position,
            heading_rad,
            heading_rate_rad_s,
            heading_acceleration_rad_s2: self.heading_acceleration_rad_s2(),
            time: now,
            ..AnchorReference::default()
        }
    }

    /// The heading follows the reference's course, or the heading it tells while it stands.
    fn moving(
        &mut self,
        reference: AnchorReference,
        mode: FormationHeading,
        room: &Room<'_>,
        dt_s: f64,
    ) -> AnchorReference {
        let formerly_rad = self.heading.map_or(reference.heading_rad, |h| h.heading_rad());
        let reference = self.tether.lead(reference, formerly_rad, room, dt_s);
        let v = &reference.velocity;
        let course_rad = match mode {
            FormationHeading::Fixed { heading_rad, .. } => heading_rad,
            FormationHeading::Course { .. } if v.north_m_s.hypot(v.east_m_s) > SLOWEST_COURSE_M_S => {
                v.east_m_s.atan2(v.north_m_s)
            }
            FormationHeading::Course { .. } => f64::NAN,
        };
        let (heading_rad, heading_rate_rad_s) = self
            .heading
            .as_mut()
            .map_or((reference.heading_rad, 0.0), |h| h.step(course_rad, dt_s));
        let outside = |heading_rad| room.outside(&reference.position, heading_rad);
        if !room.fences.is_empty() && outside(heading_rad) > outside(formerly_rad) {
            // A turn that would swing a place outside waits.
            self.heading = Some(HeadingFollower::resume(mode, formerly_rad, 0.0));
            return AnchorReference {
                heading_rad: formerly_rad,
                heading_rate_rad_s: 0.0,
                heading_acceleration_rad_s2: 0.0,
                ..reference
            };
        }
        AnchorReference {
            heading_rad,
            heading_rate_rad_s,
            heading_acceleration_rad_s2: self.heading_acceleration_rad_s2(),
            ..reference
        }
    }

    fn heading_acceleration_rad_s2(&self) -> f64 {
        self.heading.map_or(0.0, |heading| heading.acceleration_rad_s2())
    }
}

fn name_of(plan: Option<&AnchorPlan>) -> Option<&str> {
    match plan {
        Some(AnchorPlan::Reference { name, .. }) => Some(name),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
