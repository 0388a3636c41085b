//! The one time law that all vehicles of a transition share: minimum jerk along the straight line, and the bump of a detour.

use std::f64::consts::PI;

/// A value that depends on one argument, with its first and second derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Curve {
    pub value: f64,
    pub first: f64,
    pub second: f64,
}

/// The largest slope of [`min_jerk`], at half-time.
pub(crate) const PEAK_RATE: f64 = 15.0 / 8.0;
/// The largest curvature of [`min_jerk`]: 10/√3, at τ = ½ ± √3/6.
pub(crate) const PEAK_ACCELERATION: f64 = 5.773_502_691_896_258;

/// Share of the way covered at the share `tau` of the time: 10τ³ - 15τ⁴ + 6τ⁵, at rest with no acceleration at both ends.
/// Outside of 0..=1 it stands still at that end.
pub(crate) fn min_jerk(tau: f64) -> Curve {
    if tau <= 0.0 {
        return Curve {
            value: 0.0,
            first: 0.0,
            second: 0.0,
        };
    }
    if tau >= 1.0 {
        return Curve {
            value: 1.0,
            first: 0.0,
            second: 0.0,
        };
    }
    let rest = 1.0 - tau;
    Curve {
        value: tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau)),
        first: 30.0 * tau * tau * rest * rest,
        second: 60.0 * tau * rest * (1.0 - 2.0 * tau),
    }
}

/// Height of a detour as a share of its full height when the share `s` of the way is covered: 1 - (1 - 2s)⁶. It is steep at the
/// ends and flat in the middle, so that the full height is there for most of the way, wherever on it the other vehicle is.
pub(crate) fn bump(s: f64) -> Curve {
    let u = 1.0 - 2.0 * s;
    let u4 = u * u * u * u;
    Curve {
        value: 1.0 - u4 * u * u,
        first: 12.0 * u4 * u,
        second: -120.0 * u4,
    }
}

/// The largest slope of [`bump`] between two shares of the way.
pub(crate) fn bump_slope_between(s0: f64, s1: f64) -> f64 {
    let u = (1.0 - 2.0 * s0).abs().max((1.0 - 2.0 * s1).abs());
    12.0 * u.powi(5)
}

/// The bump over time: height, rate and acceleration per unit of height and of duration.
pub(crate) fn bump_over_time(tau: f64) -> Curve {
    let s = min_jerk(tau);
    let b = bump(s.value);
    Curve {
        value: b.value,
        first: b.first * s.first,
        second: b.second * s.first * s.first + b.first * s.second,
    }
}

/// How long a move must take so that no limit is exceeded: the largest of what speed, acceleration and climb ask for.
/// `way_m` is the straight line (forward, right, up), `lift_m` the height of the detour.
pub(crate) fn duration_s(way_m: [f64; 3], lift_m: f64, speed_m_s: f64, acceleration_m_s2: f64, climb_m_s: f64) -> f64 {
    let horizontal_m = way_m[0].hypot(way_m[1]);
    if lift_m == 0.0 {
        let length_m = horizontal_m.hypot(way_m[2]);
        return (PEAK_RATE * length_m / speed_m_s)
            .max((PEAK_ACCELERATION * length_m / acceleration_m_s2).sqrt())
            .max(PEAK_RATE * way_m[2].abs() / climb_m_s);
    }
    let (mut speed, mut climb, mut acceleration) = (0.0_f64, 0.0_f64, 0.0_f64);
    for i in 0..=SAMPLES {
        // Denser towards the ends, where the bump changes most.
        let tau = 0.5 * (1.0 - (PI * f64::from(i) / f64::from(SAMPLES)).cos());
        let (s, b) = (min_jerk(tau), bump_over_time(tau));
        let up_rate = way_m[2] * s.first + lift_m * b.first;
        let up_acceleration = way_m[2] * s.second + lift_m * b.second;
        speed = speed.max((horizontal_m * s.first).hypot(up_rate));
        climb = climb.max(up_rate.abs());
        acceleration = acceleration.max((horizontal_m * s.second).hypot(up_acceleration));
    }
    // The true peak lies between two samples: the curves are smooth, so that it is higher by far less than this.
    let between = 1.002;
    between
        * (speed / speed_m_s)
            .max((acceleration / acceleration_m_s2).sqrt())
            .max(climb / climb_m_s)
}

/// How finely [`duration_s`] looks for the peaks.
const SAMPLES: u32 = 96;

#[cfg(test)]
mod tests;
