//! The anchor of a formation that follows no vehicle: a virtual leader, a reference that moves, a place. Worked out once per period
//! from the intent, so that every vehicle sees the same one, and goes on without the coordinator.
//!
//! Must never do: decide anything. A virtual leader's way follows from the intent alone, so that every node finds the same.

use crate::references::References;
use skein_domain::{AnchorPlan, AnchorReference, FormationHeading, NodeTime, PositionNed, VelocityNed};
use skein_flight::virtual_leader::VirtualLeader;
use skein_flight::{HeadingFollower, PathLimits};

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
}

impl AnchorKeeper {
    /// The anchor at `now`; `None` without a plan, or as long as its reference is not known. `formerly` is the heading of the
    /// formation until now, from which it turns.
    pub fn at(
        &mut self,
        plan: Option<&AnchorPlan>,
        formerly: Option<&AnchorReference>,
        references: &References,
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
            AnchorPlan::Reference { name, heading } => {
                let heading = *heading;
                match references.anchor(name, now) {
                    Some(moving) => self.moving(moving, heading, dt_s),
                    // A reference that was removed in flight: the formation stands where it was.
                    None => {
                        let before = before?;
                        AnchorReference {
                            velocity: VelocityNed::default(),
                            acceleration: skein_domain::AccelerationNed::default(),
                            heading_rate_rad_s: 0.0,
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
            time: now,
            ..AnchorReference::default()
        }
    }

    /// The heading follows the reference's course, or the heading it tells while it stands.
    fn moving(&mut self, reference: AnchorReference, mode: FormationHeading, dt_s: f64) -> AnchorReference {
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
        AnchorReference {
            heading_rad,
            heading_rate_rad_s,
            ..reference
        }
    }
}

#[cfg(test)]
mod tests;
