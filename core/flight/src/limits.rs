//! What a formation as a whole can do, given what its vehicles can.

use skein_domain::OffsetFrd;

/// Share of the largest speed that a planned turn uses; the rest is for gusts and for catching up.
pub const TURN_SPEED_SHARE: f64 = 0.9;
/// No formation turns faster than this, however small it is, in radians per second.
pub const MAX_TURN_RATE_RAD_S: f64 = 1.0;

/// The largest rate in radians per second at which a formation may turn, to either side, while its leader flies
/// `leader_speed_m_s` along the heading: then no slot is faster than [`TURN_SPEED_SHARE`] of `max_speed_m_s`. Zero if the leader
/// alone is that fast, or if a number is not usable.
#[must_use]
pub fn max_turn_rate_rad_s(slots: &[OffsetFrd], leader_speed_m_s: f64, max_speed_m_s: f64) -> f64 {
    let (leader, limit) = (leader_speed_m_s.abs(), max_speed_m_s * TURN_SPEED_SHARE);
    if !(limit > 0.0 && limit.is_finite() && leader <= limit) {
        return 0.0;
    }
    // The slot at (forward f, right r) flies at (v - ω r, ω f). With the worse sign of ω and R² = f² + r²:
    // R² ω² + 2 v |r| ω + v² = limit².
    let rate_of = |slot: &OffsetFrd| {
        let radius2 = slot.forward_m * slot.forward_m + slot.right_m * slot.right_m;
        let half_b = leader * slot.right_m.abs();
        let spare = limit * limit - leader * leader;
        // The root in the form that does not cancel: spare / (b + √(b² + R² spare)).
        let denominator = half_b + (half_b * half_b + radius2 * spare).sqrt();
        if denominator.is_nan() {
            0.0
        } else if denominator > 0.0 {
            spare / denominator
        } else {
            MAX_TURN_RATE_RAD_S
        }
    };
    slots.iter().map(rate_of).fold(MAX_TURN_RATE_RAD_S, f64::min)
}

/// The same, and no slot's acceleration in a steady turn is above `max_acceleration_m_s2`.
#[must_use]
pub fn max_turn_rate_within_rad_s(
    slots: &[OffsetFrd],
    leader_speed_m_s: f64,
    max_speed_m_s: f64,
    max_acceleration_m_s2: f64,
) -> f64 {
    let by_speed = max_turn_rate_rad_s(slots, leader_speed_m_s, max_speed_m_s);
    // In a steady turn every slot circles about one centre: its acceleration is ω times its speed, which is within the limit.
    let fastest = max_speed_m_s * TURN_SPEED_SHARE;
    if max_acceleration_m_s2 > 0.0 && fastest > 0.0 {
        by_speed.min(max_acceleration_m_s2 / fastest)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
