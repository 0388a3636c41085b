//! Setpoints from outside: what they ask for, when the last one came, and how long the gaps between them were.

use super::estimator::Estimate;
use super::position_control::Target;
use crate::topics::AskedSetpoint;
use mavlink::dialects::common::{
    PositionTargetTypemask as Mask, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use nalgebra::Vector3;
use skein_domain::{Geodetic, LocalFrame};

// MAV_FRAME numbers.
const GLOBAL: u8 = 0;
const LOCAL_NED: u8 = 1;
const GLOBAL_RELATIVE: u8 = 3;
const GLOBAL_INT: u8 = 5;
const GLOBAL_RELATIVE_INT: u8 = 6;
const BODY_NED: u8 = 8;

/// Why a setpoint was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SetpointProblem {
    /// A frame this autopilot does not take; the number is the frame's.
    Frame(u8),
    /// Nothing in it asks for anything.
    Empty,
}

/// Setpoints as they came.
#[derive(Debug, Clone)]
pub(crate) struct OffboardInput {
    /// The last accepted one.
    pub target: Target,
    /// When it came, in seconds of the simulation.
    last_s: Option<f64>,
    /// When it was last said what of the setpoints counts. Over MAVLink every setpoint says so itself.
    told_s: Option<f64>,
    /// Accepted so far.
    pub accepted: u64,
    /// Dropped so far.
    pub refused: u64,
    /// Longest gap while it mattered, in seconds.
    pub gap_max_s: f64,
    /// The longest that was left without what the machine's stalls had in it.
    pub gap_sender_max_s: f64,
    /// The same since [`Self::forget_recent_gap`].
    pub gap_recent_s: f64,
    stalled_at_last_s: f64,
}

impl OffboardInput {
    pub(crate) fn new() -> Self {
        Self {
            target: Target::NONE,
            last_s: None,
            told_s: None,
            accepted: 0,
            refused: 0,
            gap_max_s: 0.0,
            gap_sender_max_s: 0.0,
            gap_recent_s: 0.0,
            stalled_at_last_s: 0.0,
        }
    }

    /// Forgets the setpoints, not what was counted.
    pub(crate) fn restart(&mut self) {
        (self.last_s, self.told_s) = (None, None);
        self.target = Target::NONE;
    }

    /// Seconds since the last accepted setpoint, or since it was last said what of it counts if that is longer; infinite without
    /// either.
    pub(crate) fn age_s(&self, now_s: f64) -> f64 {
        let age_s = |at: Option<f64>| at.map_or(f64::INFINITY, |at| now_s - at);
        age_s(self.last_s).max(age_s(self.told_s))
    }

    /// It is said that setpoints count, at a time in seconds of the simulation. One that asks for nothing this vehicle follows counts
    /// as refused.
    pub(crate) fn keep_alive(&mut self, follows: bool, at_s: f64) {
        if follows {
            self.told_s = Some(at_s);
        } else {
            self.refused += 1;
        }
    }

    /// A setpoint as a topic has it: in the vehicle's own frame, what is not a number is not controlled. It does not keep OFFBOARD
    /// alive by itself.
    pub(crate) fn topic(&mut self, s: &AskedSetpoint, now_s: f64, stalled_s: f64) -> Result<(), SetpointProblem> {
        let target = Target {
            position: s.position_m,
            velocity: s.velocity_m_s,
            acceleration: s.acceleration_m_s2,
            yaw_rad: s.yaw_rad,
            yaw_rate_rad_s: s.yaw_rate_rad_s,
        };
        self.take(target, now_s, stalled_s)
    }

    /// Takes what counts the gap to the last setpoint, while OFFBOARD is in use.
    pub(crate) fn count_gap(&mut self, now_s: f64, stalled_s: f64) {
        if let Some(last) = self.last_s {
            let gap = now_s - last;
            self.gap_max_s = self.gap_max_s.max(gap);
            let of_sender = gap - (stalled_s - self.stalled_at_last_s);
            self.gap_sender_max_s = self.gap_sender_max_s.max(of_sender);
            self.gap_recent_s = self.gap_recent_s.max(of_sender);
        }
    }

    /// Gaps are recent from now on.
    pub(crate) fn forget_recent_gap(&mut self) {
        self.gap_recent_s = 0.0;
    }

    /// A setpoint in the vehicle's own frame.
    pub(crate) fn local(
        &mut self,
        m: &SET_POSITION_TARGET_LOCAL_NED_DATA,
        yaw_rad: f64,
        now_s: f64,
        stalled_s: f64,
    ) -> Result<(), SetpointProblem> {
        let mut position = Vector3::new(m.x, m.y, m.z).cast::<f64>();
        let mut velocity = Vector3::new(m.vx, m.vy, m.vz).cast::<f64>();
        let mut acceleration = Vector3::new(m.afx, m.afy, m.afz).cast::<f64>();
        mask_out(m.type_mask, &mut position, &mut velocity, &mut acceleration);
        match m.coordinate_frame as u8 {
            LOCAL_NED => {}
            BODY_NED => {
                // Velocity and acceleration turn with the nose; a position in this frame means nothing to PX4.
                position = Target::NONE.position;
                velocity = turned(velocity, yaw_rad);
                acceleration = turned(acceleration, yaw_rad);
            }
            other => {
                self.refused += 1;
                return Err(SetpointProblem::Frame(other));
            }
        }
        let target = target(position, velocity, acceleration, m.type_mask, m.yaw, m.yaw_rate);
        self.accept(target, now_s, stalled_s)
    }

    /// A setpoint on the globe.
    pub(crate) fn global(
        &mut self,
        m: &SET_POSITION_TARGET_GLOBAL_INT_DATA,
        frame: &LocalFrame,
        home: &Vector3<f64>,
        now_s: f64,
        stalled_s: f64,
    ) -> Result<(), SetpointProblem> {
        let relative = match m.coordinate_frame as u8 {
            GLOBAL | GLOBAL_INT => false,
            GLOBAL_RELATIVE | GLOBAL_RELATIVE_INT => true,
            other => {
                self.refused += 1;
                return Err(SetpointProblem::Frame(other));
            }
        };
        let altitude = f64::from(m.alt);
        let place = Geodetic {
            latitude_deg: f64::from(m.lat_int) * 1e-7,
            longitude_deg: f64::from(m.lon_int) * 1e-7,
            altitude_amsl_m: altitude,
        };
        let mut position = frame.position(&place).vector();
        if relative {
            position.z = home.z - altitude;
        }
        let mut velocity = Vector3::new(m.vx, m.vy, m.vz).cast::<f64>();
        let mut acceleration = Vector3::new(m.afx, m.afy, m.afz).cast::<f64>();
        mask_out(m.type_mask, &mut position, &mut velocity, &mut acceleration);
        let target = target(position, velocity, acceleration, m.type_mask, m.yaw, m.yaw_rate);
        self.accept(target, now_s, stalled_s)
    }

    fn accept(&mut self, target: Target, now_s: f64, stalled_s: f64) -> Result<(), SetpointProblem> {
        self.take(target, now_s, stalled_s)?;
        self.told_s = Some(now_s);
        Ok(())
    }

    fn take(&mut self, target: Target, now_s: f64, stalled_s: f64) -> Result<(), SetpointProblem> {
        let asked = |v: &Vector3<f64>| v.iter().any(|x| x.is_finite());
        if !asked(&target.position) && !asked(&target.velocity) && !asked(&target.acceleration) {
            self.refused += 1;
            return Err(SetpointProblem::Empty);
        }
        self.target = target;
        self.last_s = Some(now_s);
        self.stalled_at_last_s = stalled_s;
        self.accepted += 1;
        Ok(())
    }

    /// Whether what is asked for leads up from here.
    pub(crate) fn leads_up(&self, now: &Estimate) -> bool {
        let t = &self.target;
        t.position.z < now.position.z - 0.2
            || (t.position.z.is_nan() && t.velocity.z < -0.05)
            || (t.position.z.is_nan() && t.velocity.z.is_nan() && t.acceleration.z < -0.05)
    }
}

fn mask_out(mask: Mask, position: &mut Vector3<f64>, velocity: &mut Vector3<f64>, acceleration: &mut Vector3<f64>) {
    for axis in 0..3 {
        let ignored = |first: u32| mask.bits() & (1 << (first + axis as u32)) != 0;
        if ignored(0) {
            position[axis] = f64::NAN;
        }
        if ignored(3) {
            velocity[axis] = f64::NAN;
        }
        if ignored(6) {
            acceleration[axis] = f64::NAN;
        }
    }
}

fn target(
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    mask: Mask,
    yaw: f32,
    yaw_rate: f32,
) -> Target {
    let unless = |flag: Mask, value: f32| {
        if mask.contains(flag) {
            f64::NAN
        } else {
            f64::from(value)
        }
    };
    Target {
        position,
        velocity,
        acceleration,
        yaw_rad: unless(Mask::POSITION_TARGET_TYPEMASK_YAW_IGNORE, yaw),
        yaw_rate_rad_s: unless(Mask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE, yaw_rate),
    }
}

fn turned(v: Vector3<f64>, yaw_rad: f64) -> Vector3<f64> {
    let (sin, cos) = yaw_rad.sin_cos();
    Vector3::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos, v.z)
}
