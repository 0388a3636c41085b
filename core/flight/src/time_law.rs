//! The one time law that all vehicles of a transition share: a smooth ramp up, a cruise, a smooth ramp down; and the bump of a
//! detour over it.

/// A value that depends on one argument, with its first and second derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Curve {
    pub value: f64,
    pub first: f64,
    pub second: f64,
}

/// Both ramps of a long move last this long, in seconds; those of a short one half of it each. It is the same for all vehicles
/// whatever they can do, since all must cover the same share of their ways at the same time.
pub(crate) const RAMP_S: f64 = 4.0;

/// The share of the way that is covered `t_s` seconds into a move of `duration_s`, with its derivatives per second.
///
/// The speed rises as 3x² - 2x³ over the ramp, so that speed and acceleration are continuous and zero at both ends. Against a
/// minimum-jerk law over the whole move (peak speed 15/8 of the mean) the cruise makes long moves up to 40 % shorter at the same
/// peak speed.
pub(crate) fn progress(t_s: f64, duration_s: f64) -> Curve {
    if t_s >= duration_s {
        return Curve {
            value: 1.0,
            first: 0.0,
            second: 0.0,
        };
    }
    if t_s <= 0.0 {
        return Curve {
            value: 0.0,
            first: 0.0,
            second: 0.0,
        };
    }
    if t_s > 0.5 * duration_s {
        // The second half mirrors the first.
        let mirrored = progress(duration_s - t_s, duration_s);
        return Curve {
            value: 1.0 - mirrored.value,
            first: mirrored.first,
            second: -mirrored.second,
        };
    }
    let ramp_s = RAMP_S.min(0.5 * duration_s);
    let cruise = 1.0 / (duration_s - ramp_s);
    if t_s > ramp_s {
        return Curve {
            value: cruise * (t_s - 0.5 * ramp_s),
            first: cruise,
            second: 0.0,
        };
    }
    let x = t_s / ramp_s;
    Curve {
        value: cruise * ramp_s * x * x * x * (1.0 - 0.5 * x),
        first: cruise * x * x * (3.0 - 2.0 * x),
        second: 6.0 * cruise / ramp_s * x * (1.0 - x),
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

/// The bump over time, for the progress at that time.
pub(crate) fn bump_over_time(s: Curve) -> Curve {
    let b = bump(s.value);
    Curve {
        value: b.value,
        first: b.first * s.first,
        second: b.second * s.first * s.first + b.first * s.second,
    }
}

/// What a vehicle can do, as far as the duration of a move is concerned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ability {
    pub speed_m_s: f64,
    pub acceleration_m_s2: f64,
    pub climb_m_s: f64,
}

/// How long a move must take so that no limit is exceeded. `way_m` is the straight line (forward, right, up), `lift_m` the height
/// of the detour over it. Not less than `at_least_s`, and quick to tell where that is enough.
pub(crate) fn duration_s(way_m: [f64; 3], lift_m: f64, ability: &Ability, at_least_s: f64) -> f64 {
    let length_m = way_m[0].hypot(way_m[1]).hypot(way_m[2]);
    let straight_s = by_rate(length_m / ability.speed_m_s)
        .max(by_rate(way_m[2].abs() / ability.climb_m_s))
        .max(by_acceleration(length_m / ability.acceleration_m_s2))
        .max(at_least_s);
    if lift_m == 0.0 || !straight_s.is_finite() {
        return straight_s;
    }
    // With a detour no formula is at hand: bracket, then halve. More time always asks less of the vehicle.
    let least_s = straight_s.max(MIN_DETOUR_S);
    if used_share(way_m, lift_m, ability, least_s) <= 1.0 {
        return least_s;
    }
    let mut enough_s = 1.5 * least_s;
    while used_share(way_m, lift_m, ability, enough_s) > 1.0 && enough_s < MAX_DURATION_S {
        enough_s *= 1.5;
    }
    let mut short_s = least_s;
    for _ in 0..24 {
        let middle_s = 0.5 * (short_s + enough_s);
        if used_share(way_m, lift_m, ability, middle_s) > 1.0 {
            short_s = middle_s;
        } else {
            enough_s = middle_s;
        }
    }
    enough_s
}

/// A detour is never flown in less, in seconds: it gives the search a place to begin at.
const MIN_DETOUR_S: f64 = 0.5;
/// Longer than any move that a battery allows.
const MAX_DURATION_S: f64 = 1e6;

/// The duration at which the cruise has the wanted rate, for way / rate = `cruise_s`.
fn by_rate(cruise_s: f64) -> f64 {
    if cruise_s < RAMP_S {
        2.0 * cruise_s
    } else {
        cruise_s + RAMP_S
    }
}

/// The duration at which a ramp has the wanted acceleration at its steepest (3/2 of the mean), for way / acceleration = `ratio_s2`.
fn by_acceleration(ratio_s2: f64) -> f64 {
    let without_cruise_s = (6.0 * ratio_s2).sqrt();
    if without_cruise_s < 2.0 * RAMP_S {
        without_cruise_s
    } else {
        RAMP_S + 1.5 * ratio_s2 / RAMP_S
    }
}

/// The largest of speed, climb and acceleration over a move, as shares of what the vehicle can do.
fn used_share(way_m: [f64; 3], lift_m: f64, ability: &Ability, duration_s: f64) -> f64 {
    let horizontal_m = way_m[0].hypot(way_m[1]);
    let mut used = 0.0_f64;
    let ramp_s = RAMP_S.min(0.5 * duration_s);
    let spans = [
        (0.0, ramp_s),
        (ramp_s, duration_s - ramp_s),
        (duration_s - ramp_s, duration_s),
    ];
    let moments = spans.into_iter().flat_map(|(begin_s, end_s)| {
        (0..=SAMPLES).map(move |i| begin_s + (end_s - begin_s) * f64::from(i) / f64::from(SAMPLES))
    });
    for t_s in moments {
        let s = progress(t_s, duration_s);
        let b = bump_over_time(s);
        let up_rate = way_m[2] * s.first + lift_m * b.first;
        let up_acceleration = way_m[2] * s.second + lift_m * b.second;
        used = used
            .max((horizontal_m * s.first).hypot(up_rate) / ability.speed_m_s)
            .max(up_rate.abs() / ability.climb_m_s)
            .max((horizontal_m * s.second).hypot(up_acceleration) / ability.acceleration_m_s2);
    }
    // The true peak may lie between two samples, higher by less than this.
    used * 1.003
}

/// How finely [`used_share`] looks for the peaks in each ramp and in the cruise.
const SAMPLES: u32 = 48;

#[cfg(test)]
mod tests;
