//! The heading of a formation over time: fixed, or after the leader's course as fast as the formation may turn.

use skein_domain::FormationHeading;
use skein_domain::frames::wrap_angle_rad;

/// Time in which the rate of turning grows from zero to its limit, in seconds. A sudden rate would ask of the outermost vehicle a
/// sudden speed.
const RAMP_S: f64 = 2.0;

/// Follows a course with a limited rate that changes gently. One per leader, stepped once per control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingFollower {
    mode: FormationHeading,
    heading_rad: f64,
    rate_rad_s: f64,
    acceleration_rad_s2: f64,
}

impl HeadingFollower {
    /// A follower that starts at `initial_rad` without turning; a fixed heading is taken up at once.
    #[must_use]
    pub fn new(mode: FormationHeading, initial_rad: f64) -> Self {
        let mut follower = Self {
            mode,
            heading_rad: 0.0,
            rate_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
        };
        if initial_rad.is_finite() {
            follower.heading_rad = wrap_angle_rad(initial_rad);
        }
        if let FormationHeading::Fixed { heading_rad, .. } = mode
            && heading_rad.is_finite()
        {
            follower.heading_rad = wrap_angle_rad(heading_rad);
        }
        follower
    }

    /// Goes on from another follower's heading and rate, perhaps with another limit: after a restart, or when a formation that flies is
    /// to have another heading. A fixed heading is turned to with its limit; one without is taken up at once.
    #[must_use]
    pub fn resume(mode: FormationHeading, heading_rad: f64, rate_rad_s: f64) -> Self {
        let at_once = matches!(
            mode,
            FormationHeading::Fixed {
                max_rate_rad_s: None,
                ..
            }
        );
        let mut follower = Self::new(mode, heading_rad);
        if !at_once && heading_rad.is_finite() {
            follower.heading_rad = wrap_angle_rad(heading_rad);
        }
        if !at_once && rate_rad_s.is_finite() {
            follower.rate_rad_s = rate_rad_s;
        }
        follower
    }

    /// How the heading is chosen.
    #[must_use]
    pub fn mode(&self) -> FormationHeading {
        self.mode
    }

    /// The present heading in radians, within -π..=π.
    #[must_use]
    pub fn heading_rad(&self) -> f64 {
        self.heading_rad
    }

    /// The present rate in radians per second.
    #[must_use]
    pub fn rate_rad_s(&self) -> f64 {
        self.rate_rad_s
    }

    /// How the rate changed over the last step, in radians per second squared; zero before the first one.
    #[must_use]
    pub fn acceleration_rad_s2(&self) -> f64 {
        self.acceleration_rad_s2
    }

    /// One step of `dt_s` towards `course_rad`, or the fixed heading; gives heading and rate. The rate is the one over this step, never above the
    /// limit (from a faster turn it is slowed down to it). A course that is not finite leaves the heading where it is (the turning fades out).
    pub fn step(&mut self, course_rad: f64, dt_s: f64) -> (f64, f64) {
        let (course_rad, max_rate_rad_s) = match self.mode {
            FormationHeading::Course { max_rate_rad_s } => (course_rad, max_rate_rad_s),
            FormationHeading::Fixed {
                heading_rad,
                max_rate_rad_s,
            } => match max_rate_rad_s {
                Some(max_rate_rad_s) => (heading_rad, max_rate_rad_s),
                None => return (self.heading_rad, 0.0),
            },
        };
        let max_rate = if max_rate_rad_s.is_finite() {
            max_rate_rad_s.max(0.0)
        } else {
            0.0
        };
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return (self.heading_rad, self.rate_rad_s);
        }
        let error = if course_rad.is_finite() {
            wrap_angle_rad(course_rad - self.heading_rad)
        } else {
            0.0
        };
        // A turn that is faster than it may be now is slowed down, not broken off.
        let ramp = max_rate.max(self.rate_rad_s.abs()) / RAMP_S;
        // As fast as can still be slowed down from before the course is reached; within a step's reach, just onto it.
        let stoppable = (2.0 * ramp * error.abs() + (0.5 * ramp * dt_s).powi(2)).sqrt() - 0.5 * ramp * dt_s;
        let wanted = stoppable.min(error.abs() / dt_s).min(max_rate).copysign(error);
        let change = (wanted - self.rate_rad_s).clamp(-ramp * dt_s, ramp * dt_s);
        self.rate_rad_s += change;
        self.acceleration_rad_s2 = change / dt_s;
        self.heading_rad = wrap_angle_rad(self.heading_rad + self.rate_rad_s * dt_s);
        (self.heading_rad, self.rate_rad_s)
    }
}

#[cfg(test)]
mod tests;
