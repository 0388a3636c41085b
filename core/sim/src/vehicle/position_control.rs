//! The position controller, after the structure and the default gains of PX4's multicopter one: P on position, PID on
//! velocity, thrust vector from acceleration, with its limits and its anti-windup.

use super::body::GRAVITY_M_S2;
use super::estimator::Estimate;
use nalgebra::{Vector2, Vector3};

const POSITION_GAIN: Vector3<f64> = Vector3::new(0.95, 0.95, 1.0);
const VELOCITY_P: Vector3<f64> = Vector3::new(1.8, 1.8, 4.0);
const VELOCITY_I: Vector3<f64> = Vector3::new(0.4, 0.4, 2.0);
const VELOCITY_D: Vector3<f64> = Vector3::new(0.2, 0.2, 0.0);
/// The acceleration that the D part sees is low-passed with this time in seconds: PX4's MPC_VELD_LP of 5 Hz.
const ACCELERATION_LAG_S: f64 = 0.032;
/// Thrust per mass the motors can give, and the least they give in flight, in multiples of gravity.
const THRUST_MAX_G: f64 = 1.9;
const THRUST_MIN_G: f64 = 0.24;
/// Kept free for level flight when the vertical wants everything, in multiples of gravity.
const HORIZONTAL_MARGIN_G: f64 = 0.55;

/// What to fly: NaN parts are not asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Target {
    /// Metres in the vehicle's own frame.
    pub position: Vector3<f64>,
    /// Metres per second.
    pub velocity: Vector3<f64>,
    /// Metres per second squared.
    pub acceleration: Vector3<f64>,
    /// Radians.
    pub yaw_rad: f64,
    /// Radians per second.
    pub yaw_rate_rad_s: f64,
}

impl Target {
    /// Nothing asked for.
    pub(crate) const NONE: Self = Self {
        position: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        velocity: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        acceleration: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        yaw_rad: f64::NAN,
        yaw_rate_rad_s: f64::NAN,
    };
}

/// Limits, from the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ControlLimits {
    /// Horizontal speed in metres per second.
    pub horizontal_m_s: f64,
    /// Climb in metres per second.
    pub up_m_s: f64,
    /// Descent in metres per second.
    pub down_m_s: f64,
    /// Tilt in radians.
    pub tilt_rad: f64,
}

/// The controller's memory, and what it last asked for.
#[derive(Debug, Clone)]
pub(crate) struct PositionControl {
    integral: Vector3<f64>,
    /// Acceleration as the D part sees it, in metres per second squared; not known before the first step.
    acceleration_seen: Option<Vector3<f64>>,
    /// Velocity it steers for in metres per second; NaN parts are not controlled.
    pub velocity_target: Vector3<f64>,
    /// Acceleration it asks for in metres per second squared.
    pub acceleration_target: Vector3<f64>,
}

impl PositionControl {
    pub(crate) fn new() -> Self {
        Self {
            integral: Vector3::zeros(),
            acceleration_seen: None,
            velocity_target: Vector3::zeros(),
            acceleration_target: Vector3::zeros(),
        }
    }

    /// Forgets what it has learnt of wind and drag.
    pub(crate) fn reset(&mut self) {
        *self = Self::new();
    }

    /// One step: the thrust per mass as a vector in metres per second squared.
    pub(crate) fn step(&mut self, now: &Estimate, target: &Target, limits: &ControlLimits, dt_s: f64) -> Vector3<f64> {
        let velocity_target = velocity_target(now, target, limits);
        let error = or_zero(velocity_target - now.velocity);
        let seen = self.acceleration_seen.unwrap_or(now.acceleration);
        let seen = seen + (now.acceleration - seen) * (dt_s / (ACCELERATION_LAG_S + dt_s));
        self.acceleration_seen = Some(seen);
        let feedback = VELOCITY_P.component_mul(&error) + self.integral - VELOCITY_D.component_mul(&seen);
        let acceleration = Vector3::from_fn(|i, _| {
            let forward = or(target.acceleration[i], 0.0);
            if velocity_target[i].is_finite() {
                forward + feedback[i]
            } else {
                forward
            }
        });
        let force = thrust(&acceleration, limits.tilt_rad);
        self.learn(error, &acceleration, &force, dt_s);
        self.velocity_target = velocity_target;
        self.acceleration_target = acceleration;
        force
    }

    /// Integrates what is left of the velocity error, but not into a saturation.
    fn learn(&mut self, mut error: Vector3<f64>, asked: &Vector3<f64>, force: &Vector3<f64>, dt_s: f64) {
        let size = force.norm();
        let wants_more_up = error.z < 0.0;
        if (size >= THRUST_MAX_G * GRAVITY_M_S2 * 0.999 && wants_more_up)
            || (size <= THRUST_MIN_G * GRAVITY_M_S2 * 1.001 && !wants_more_up)
        {
            error.z = 0.0;
        }
        let given = force.xy();
        if asked.xy().norm_squared() > given.norm_squared() + 1e-6 {
            let gain = 2.0 / VELOCITY_P.x;
            let excess = (asked.xy() - given) * gain;
            error.x -= excess.x;
            error.y -= excess.y;
        }
        self.integral += VELOCITY_I.component_mul(&error) * dt_s;
        self.integral.z = self.integral.z.clamp(-GRAVITY_M_S2, GRAVITY_M_S2);
        for axis in 0..2 {
            self.integral[axis] = self.integral[axis].clamp(-GRAVITY_M_S2, GRAVITY_M_S2);
        }
    }
}

/// Feed-forward plus what the position error asks for, within the limits.
fn velocity_target(now: &Estimate, target: &Target, limits: &ControlLimits) -> Vector3<f64> {
    let from_position = POSITION_GAIN.component_mul(&(target.position - now.position));
    let sum = Vector3::from_fn(
        |i, _| match (from_position[i].is_finite(), target.velocity[i].is_finite()) {
            (true, _) => from_position[i] + or(target.velocity[i], 0.0),
            (false, true) => target.velocity[i],
            (false, false) => f64::NAN,
        },
    );
    let level = constrain_level(
        or_zero(from_position).xy(),
        or_zero(target.velocity).xy(),
        limits.horizontal_m_s,
    );
    Vector3::new(
        if sum.x.is_finite() { level.x } else { f64::NAN },
        if sum.y.is_finite() { level.y } else { f64::NAN },
        if sum.z.is_finite() {
            sum.z.clamp(-limits.up_m_s, limits.down_m_s)
        } else {
            f64::NAN
        },
    )
}

/// Sum of both parts no longer than `limit`; the first has precedence, as in PX4.
fn constrain_level(first: Vector2<f64>, second: Vector2<f64>, limit: f64) -> Vector2<f64> {
    let sum = first + second;
    if sum.norm() <= limit {
        return sum;
    }
    let length = first.norm();
    if length >= limit {
        return first * (limit / length);
    }
    // As much of the second as leads to the circle of radius `limit`.
    let direction = second.normalize();
    let along = direction.dot(&first);
    let reach = -along + (along * along - first.norm_squared() + limit * limit).max(0.0).sqrt();
    first + direction * reach
}

/// Thrust vector per mass for an acceleration: the vertical comes first, the tilt is limited.
fn thrust(acceleration: &Vector3<f64>, tilt_max_rad: f64) -> Vector3<f64> {
    let max = THRUST_MAX_G * GRAVITY_M_S2;
    let min = THRUST_MIN_G * GRAVITY_M_S2;
    let lift = (GRAVITY_M_S2 - acceleration.z).clamp(min, max);
    let level = acceleration.xy();
    // The direction follows from the level acceleration as if the vertical were in balance: PX4's MPC_ACC_DECOUPLE.
    let mut side = level * (lift / GRAVITY_M_S2);
    let tilt_limit = lift * tilt_max_rad.tan();
    let length = side.norm();
    if length > tilt_limit {
        side *= tilt_limit / length;
    }
    // Saturated: keep the vertical but for the margin that steering needs.
    let margin = (HORIZONTAL_MARGIN_G * GRAVITY_M_S2).min(side.norm());
    let lift = lift.min((max * max - margin * margin).max(0.0).sqrt());
    let level_max = (max * max - lift * lift).max(0.0).sqrt();
    let length = side.norm();
    if length > level_max {
        side *= level_max / length;
    }
    Vector3::new(side.x, side.y, -lift)
}

fn or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

fn or_zero(v: Vector3<f64>) -> Vector3<f64> {
    v.map(|x| or(x, 0.0))
}
