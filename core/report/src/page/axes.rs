//! Round numbers along the axes.
//!
//! Must never do: end without a step.

use super::clock::Clock;

/// Steps of an axis of time in seconds.
const TIME_STEPS_S: [f64; 16] = [
    1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0, 7200.0, 14_400.0, 43_200.0,
];

/// Round numbers from the lowest to the highest, about so many.
pub fn ticks(lowest: f64, highest: f64, about: usize) -> Vec<f64> {
    let span = (highest - lowest).max(1e-9);
    let step = round_step(span / about.max(1) as f64);
    let (first, last) = (
        (lowest / step - 1e-9).ceil() as i64,
        (highest / step + 1e-9).floor() as i64,
    );
    (first..=last).take(60).map(|n| n as f64 * step).collect()
}

/// The next step of 1, 2 or 5 times a power of ten.
pub fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.max(1e-9).log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// A number without needless digits.
pub fn plain(value: f64) -> String {
    let rounded = (value * 1000.0).round() / 1000.0;
    if rounded == 0.0 {
        "0".into()
    } else {
        rounded.to_string()
    }
}

/// Moments along an axis of time, with what stands there.
pub fn moments(clock: &Clock, duration_s: f64) -> Vec<(f64, String)> {
    let step_s = TIME_STEPS_S
        .into_iter()
        .find(|step_s| duration_s / step_s <= 9.0)
        .unwrap_or(86_400.0);
    let told = |t_s: f64| {
        if step_s < 60.0 {
            clock.time(t_s)
        } else {
            clock.minute(t_s)
        }
    };
    clock
        .round_moments(step_s, duration_s)
        .into_iter()
        .map(|t_s| (t_s, told(t_s)))
        .collect()
}

#[cfg(test)]
mod tests {
    //! Axes are round.

    use super::*;

    #[test]
    fn steps_are_round_and_within_the_axis() {
        assert_eq!(ticks(0.0, 10.0, 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks(-3.0, 4.0, 4), [-2.0, 0.0, 2.0, 4.0]);
        assert!((round_step(0.03) - 0.05).abs() < 1e-12);
        assert_eq!(plain(-0.0), "0");
        assert_eq!(plain(0.25), "0.25");
        assert!(!ticks(5.0, 5.0, 4).is_empty());
    }
}
