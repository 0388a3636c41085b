//! Speed along a straight piece of path: speed up, cruise, slow down, with one acceleration.

/// One stretch of constant acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Phase {
    pub duration_s: f64,
    /// Distance along the piece where it begins.
    pub at_m: f64,
    pub speed_m_s: f64,
    pub acceleration_m_s2: f64,
}

impl Phase {
    /// Distance along the piece and speed, `t_s` after the phase's begin.
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let distance = self.at_m + t_s * (self.speed_m_s + 0.5 * self.acceleration_m_s2 * t_s);
        (distance, (self.speed_m_s + self.acceleration_m_s2 * t_s).max(0.0))
    }
}

/// The phases over `length_m` from `entry` to `exit` speed, never above `cap` (all in metres per second). The caller sees to it
/// that the change from entry to exit is possible over the length.
pub(crate) fn ramps(length_m: f64, entry: f64, exit: f64, cap: f64, acceleration: f64) -> [Phase; 3] {
    let reachable = (acceleration * length_m + 0.5 * (entry * entry + exit * exit))
        .max(0.0)
        .sqrt();
    let peak = reachable.min(cap).max(entry).max(exit);
    let up_m = ((peak * peak - entry * entry) / (2.0 * acceleration)).clamp(0.0, length_m);
    let down_m = ((peak * peak - exit * exit) / (2.0 * acceleration)).clamp(0.0, length_m - up_m);
    let cruise_m = length_m - up_m - down_m;
    let cruise_s = if peak > 0.0 { cruise_m / peak } else { 0.0 };
    [
        Phase {
            duration_s: (peak - entry) / acceleration,
            at_m: 0.0,
            speed_m_s: entry,
            acceleration_m_s2: acceleration,
        },
        Phase {
            duration_s: cruise_s,
            at_m: up_m,
            speed_m_s: peak,
            acceleration_m_s2: 0.0,
        },
        Phase {
            duration_s: (peak - exit) / acceleration,
            at_m: length_m - down_m,
            speed_m_s: peak,
            acceleration_m_s2: -acceleration,
        },
    ]
}
