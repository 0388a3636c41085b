//! The head of a gimbal: two driven axes with end stops, bounded in rate and acceleration, held to the horizon.
//!
//! Must never do: leave its limits, whatever it is asked for.

use std::f64::consts::PI;

/// What the manager in the autopilot turns: MNT_MODE_OUT of PX4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GimbalOutput {
    /// A device that speaks MAVLink, component 154 (MNT_MODE_OUT 2). It says itself where it looks.
    #[default]
    Device,
    /// Servos at the autopilot's outputs (MNT_MODE_OUT 0). Nobody measures where they are.
    Servos {
        /// The autopilot turns them against the vehicle's own turning (MNT_DO_STAB 1). Without it PX4 does not turn a servo that is to
        /// be held to the horizon or to north.
        stabilised: bool,
    },
}

/// How a gimbal is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GimbalSettings {
    /// What it is to the autopilot.
    pub output: GimbalOutput,
    /// Fastest turn about each axis in radians per second.
    pub rate_max_rad_s: f64,
    /// Strongest acceleration about each axis in radians per second squared.
    pub acceleration_max_rad_s2: f64,
    /// Lowest pitch about the horizon in radians.
    pub pitch_min_rad: f64,
    /// Highest pitch about the horizon in radians.
    pub pitch_max_rad: f64,
    /// Farthest yaw from the vehicle's nose to either side in radians.
    pub yaw_max_rad: f64,
}

impl Default for GimbalSettings {
    fn default() -> Self {
        Self {
            output: GimbalOutput::Device,
            rate_max_rad_s: 90_f64.to_radians(),
            acceleration_max_rad_s2: 720_f64.to_radians(),
            pitch_min_rad: -120_f64.to_radians(),
            pitch_max_rad: 30_f64.to_radians(),
            yaw_max_rad: PI,
        }
    }
}

/// What one axis is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxisGoal {
    /// Turn to this angle in radians and stay there.
    Angle(f64),
    /// Turn at this rate in radians per second.
    Rate(f64),
}

impl AxisGoal {
    /// The same angle, or so large a share of the rate.
    pub fn slowed(self, share: f64) -> Self {
        match self {
            Self::Angle(_) => self,
            Self::Rate(rate_rad_s) => Self::Rate(rate_rad_s * share),
        }
    }
}

/// What one axis cannot exceed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    /// End stops in radians.
    pub min_rad: f64,
    /// See `min_rad`.
    pub max_rad: f64,
    /// Radians per second.
    pub rate_rad_s: f64,
    /// Radians per second squared.
    pub acceleration_rad_s2: f64,
}

/// One axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Axis {
    /// Radians.
    pub angle_rad: f64,
    /// Radians per second.
    pub rate_rad_s: f64,
}

impl Axis {
    /// Lets `dt_s` pass. `drift_rad_s` is how fast the goal itself moves.
    pub fn step(&mut self, goal: AxisGoal, drift_rad_s: f64, limits: &AxisLimits, dt_s: f64) {
        let acceleration = limits.acceleration_rad_s2;
        let wanted = match goal {
            AxisGoal::Angle(angle_rad) => {
                let way_rad = angle_rad.clamp(limits.min_rad, limits.max_rad) - self.angle_rad;
                braking_rate(way_rad.abs(), acceleration, dt_s).copysign(way_rad) + drift_rad_s
            }
            AxisGoal::Rate(rate_rad_s) => rate_rad_s,
        };
        let wanted = if wanted.is_finite() { wanted } else { 0.0 };
        let reachable = acceleration * dt_s;
        let rate = wanted
            .clamp(-limits.rate_rad_s, limits.rate_rad_s)
            .clamp(self.rate_rad_s - reachable, self.rate_rad_s + reachable);
        // Never so fast that it could not stop before an end stop. Whoever kept to that in the last step can in this one,
        // without braking harder than allowed.
        let up = braking_rate(limits.max_rad - self.angle_rad, acceleration, dt_s);
        let down = braking_rate(self.angle_rad - limits.min_rad, acceleration, dt_s);
        self.rate_rad_s = rate.min(up).max(-down);
        self.angle_rad = (self.angle_rad + self.rate_rad_s * dt_s).clamp(limits.min_rad, limits.max_rad);
    }
}

/// The fastest rate for one more step from which an axis still stops within `way_rad`, each step slower than the one before by
/// what the acceleration allows.
fn braking_rate(way_rad: f64, acceleration_rad_s2: f64, dt_s: f64) -> f64 {
    let slower_rad_s = acceleration_rad_s2 * dt_s;
    // The way in units of what one unit of rate covers in a step: a rate of n + θ units takes n(n + 1)/2 + θ(n + 1) of it.
    let way = way_rad.max(0.0) / (slower_rad_s * dt_s);
    let whole = (((8.0 * way + 1.0).sqrt() - 1.0) / 2.0).floor();
    let part = (way - 0.5 * whole * (whole + 1.0)) / (whole + 1.0);
    (whole + part) * slower_rad_s
}

/// The head: pitch about the horizon, yaw from the vehicle's nose. Roll is level by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// How it is built.
    pub settings: GimbalSettings,
    /// Pitch about the horizon, upwards positive.
    pub pitch: Axis,
    /// Yaw from the vehicle's nose, clockwise.
    pub yaw: Axis,
}

impl Head {
    /// Level, looking ahead.
    pub fn new(settings: GimbalSettings) -> Self {
        Self {
            settings,
            pitch: Axis::default(),
            yaw: Axis::default(),
        }
    }

    /// Lets `dt_s` pass. `yaw_drift_rad_s` is how fast the yaw goal moves as seen from the vehicle.
    pub fn step(&mut self, pitch: AxisGoal, yaw: AxisGoal, yaw_drift_rad_s: f64, dt_s: f64) {
        let (pitch_limits, yaw_limits) = self.limits();
        self.pitch.step(pitch, 0.0, &pitch_limits, dt_s);
        self.yaw.step(yaw, yaw_drift_rad_s, &yaw_limits, dt_s);
    }

    /// Limits of pitch and yaw.
    pub fn limits(&self) -> (AxisLimits, AxisLimits) {
        let of = |min_rad, max_rad| AxisLimits {
            min_rad,
            max_rad,
            rate_rad_s: self.settings.rate_max_rad_s,
            acceleration_rad_s2: self.settings.acceleration_max_rad_s2,
        };
        (
            of(self.settings.pitch_min_rad, self.settings.pitch_max_rad),
            of(-self.settings.yaw_max_rad, self.settings.yaw_max_rad),
        )
    }
}

#[cfg(test)]
mod tests;
