//! Flying without a slot from anybody: in a place among neighbours, or along a trajectory on the common clock.
//!
//! Must never do: move the reference faster than the limits, or begin a trajectory before its time.

use crate::blend::Motion;
use crate::flight::{Fly, Flying, Kept, Phase, Plan, Purpose};
use crate::model::{GenericUav, LONGEST_STEP_S};
use crate::way::Sample;
use skein_domain::exchange::Severity;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{Keeping, NodeTime, Task, Trajectory};
use skein_flight::consensus::{self, KeepingCommand, KeepingTuning};
use skein_flight::trajectory;
use skein_plugin_sdk::Effects;

/// How fast the reference takes up the velocity that the neighbours' states ask for, in seconds: short against the closing of
/// differences, long enough that what is not known exactly does not shake the vehicle.
const VELOCITY_TIME_S: f64 = 0.3;
/// How fast the nose is turned at most, in radians per second.
pub(crate) const YAW_RATE_RAD_S: f64 = 0.8;

impl GenericUav {
    /// A task to keep a place: goes on from the present motion, and without any change if it kept one already.
    pub(crate) fn keep(&mut self, mut flying: Flying, keeping: Keeping, out: &mut Effects) {
        flying.purpose = Purpose::Keep(keeping);
        if matches!(flying.plan, Plan::Kept(_)) {
            self.enter(Phase::Flying(flying), "");
        } else {
            self.lay_out(flying, "", out);
        }
    }

    /// Whether a task's time has not come: until then the vehicle goes on with what it does.
    pub(crate) fn is_early(&self, task: &Task) -> bool {
        match task {
            Task::Fly(trajectory) => trajectory.start > self.now && trajectory::check(trajectory).is_ok(),
            Task::Keep(keeping) => keeping.start > self.now,
            _ => false,
        }
    }

    /// A task to fly a trajectory.
    pub(crate) fn fly_trajectory(&mut self, flying: Flying, trajectory: Trajectory, out: &mut Effects) {
        if let Err(why) = trajectory::check(&trajectory) {
            out.notice(Severity::Warning, format!("the way cannot be flown: {why}"));
            self.fly(Purpose::Hold { at: None }, None, "the trajectory cannot be flown", out);
            return;
        }
        let purpose = Purpose::Fly(Fly {
            trajectory,
            finished: false,
        });
        self.lay_out(Flying { purpose, ..flying }, "", out);
    }

    /// Moves the reference among neighbours on by a period.
    pub(crate) fn step_keeping(&mut self, flying: &mut Flying, dt_s: f64, out: &mut Effects) {
        let (Plan::Kept(kept), Purpose::Keep(keeping)) = (&mut flying.plan, &flying.purpose) else {
            return;
        };
        let limits = self.settings.flight_limits();
        let tuning = KeepingTuning::default();
        let wanted = consensus::command(keeping, &kept.position, &self.peers, self.now, &limits, &tuning);
        let heard_before = kept.neighbours > 0;
        *kept = moved(kept, &wanted, self.settings.acceleration_m_s2, dt_s);
        match (heard_before, wanted.neighbours > 0) {
            (true, false) => {
                out.notice(Severity::Warning, "nothing from any neighbour: holding");
                self.flight.detail = "nothing from any neighbour: holding".to_owned();
            }
            (false, true) => self.flight.detail.clear(),
            _ => {}
        }
    }

    /// Where the trajectory wants the vehicle. A period that began just before the start was on the way to it.
    pub(crate) fn trajectory_sample(&self, fly: &Fly, now: NodeTime) -> Sample {
        let start = fly.trajectory.start;
        let at = trajectory::sample(&fly.trajectory, now.max(start));
        let early_s = start.seconds_since(now).clamp(0.0, LONGEST_STEP_S);
        Sample {
            motion: Motion::new(at.position.after(&at.velocity, -early_s), at.velocity, at.acceleration),
            yaw: None,
            course_rad: at.yaw_rad,
            finished: at.finished,
        }
    }
}

/// The reference one period later, for what the neighbours' states ask for.
fn moved(kept: &Kept, wanted: &KeepingCommand, acceleration_m_s2: f64, dt_s: f64) -> Kept {
    let velocity = kept.velocity.vector();
    let change = ((wanted.velocity.vector() - velocity) / VELOCITY_TIME_S).cap_magnitude(acceleration_m_s2);
    Kept {
        position: kept.position.moved(velocity * dt_s + change * (0.5 * dt_s * dt_s)),
        velocity: (velocity + change * dt_s).into(),
        acceleration: change.into(),
        error_m: wanted.error_m,
        neighbours: u32::try_from(wanted.neighbours).unwrap_or(u32::MAX),
    }
}

/// The yaw one period later on the way to another: no faster than the vehicle's nose follows well.
pub(crate) fn turned_towards(yaw_rad: f64, towards_rad: f64, dt_s: f64) -> f64 {
    let most = YAW_RATE_RAD_S * dt_s;
    let step = wrap_angle_rad(towards_rad - yaw_rad).clamp(-most, most);
    if step.is_finite() {
        wrap_angle_rad(yaw_rad + step)
    } else {
        yaw_rad
    }
}
