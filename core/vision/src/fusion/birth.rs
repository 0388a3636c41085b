//! Whether two cameras see the same thing: one place and one velocity that explain what both saw in the last moments.

use super::Observation;
use super::estimate::{Compared, Estimate, compare};
use nalgebra::{Matrix2x6, Matrix6, Vector2, Vector3, Vector6};
use skein_domain::NodeTime;

/// Steps of Gauss and Newton to the best fit.
const STEPS: usize = 8;
/// Nothing that is looked for flies faster, in m/s: one standard deviation.
const SPEED_M_S: f64 = 15.0;
/// How much what is looked for may accelerate while it is looked at, in m/s²: one standard deviation.
const ACCELERATION_M_S2: f64 = 1.5;
/// Nearer to a camera than this nothing is believed, in metres.
const NEAREST_M: f64 = 1.0;
/// Farther than this neither, in metres.
const FARTHEST_M: f64 = 3_000.0;

/// The best explanation of some observations.
pub(super) struct Explained {
    pub(super) estimate: Estimate,
    /// Sum of squared deviations.
    pub(super) squared: f64,
    /// What it should be.
    pub(super) freedom: f64,
}

impl Explained {
    /// How well it explains: about 1 if it is true.
    pub(super) fn ratio(&self) -> f64 {
        self.squared / self.freedom.max(1.0)
    }
}

/// One place and velocity, as of `time`, that explain bearings of both; `None` if there is none in front of all cameras.
pub(super) fn explain(
    time: NodeTime,
    first: &[(NodeTime, Observation)],
    second: &[(NodeTime, Observation)],
) -> Option<Explained> {
    let start = crossing(&first.last()?.1, &second.last()?.1)?;
    let all = || first.iter().chain(second);
    let mut state = Vector6::new(start.x, start.y, start.z, 0.0, 0.0, 0.0);
    let slow = 1.0 / (SPEED_M_S * SPEED_M_S);
    let mut information = Matrix6::zeros();
    for _ in 0..STEPS {
        information = Matrix6::from_diagonal(&Vector6::new(0.0, 0.0, 0.0, slow, slow, slow));
        let mut gradient: Vector6<f64> = -information * state;
        for (at, seen) in all() {
            let (off, by_state, weight) = weigh(&state, at.seconds_since(time), seen)?;
            information += by_state.transpose() * by_state * weight;
            gradient += by_state.transpose() * off * weight;
        }
        let step = information.cholesky()?.solve(&gradient);
        state += step;
        if step.norm() < 1e-4 {
            break;
        }
    }
    let mut squared = slow * state.fixed_rows::<3>(3).norm_squared();
    let mut count = 0_u32;
    for (at, seen) in all() {
        let (off, _, weight) = weigh(&state, at.seconds_since(time), seen)?;
        squared += weight * off.norm_squared();
        count += 2;
    }
    let covariance = information.try_inverse()?;
    let estimate = Estimate {
        time,
        state,
        covariance: (covariance + covariance.transpose()) * 0.5,
    };
    estimate.is_sound().then_some(Explained {
        estimate,
        squared,
        freedom: f64::from(count) - 3.0,
    })
}

/// Off, how that changes with the state, and what it weighs.
fn weigh(state: &Vector6<f64>, since_s: f64, seen: &Observation) -> Option<(Vector2<f64>, Matrix2x6<f64>, f64)> {
    let Observation::Bearing {
        origin,
        origin_error_m,
        direction,
        error_rad,
    } = seen
    else {
        return None;
    };
    let way = state.fixed_rows::<3>(0) + state.fixed_rows::<3>(3) * since_s - origin;
    let Compared { off, by_place, along_m } = compare(&way, direction)?;
    if !(NEAREST_M..FARTHEST_M).contains(&along_m) {
        return None;
    }
    let mut by_state = Matrix2x6::zeros();
    by_state.fixed_columns_mut::<3>(0).copy_from(&by_place);
    by_state.fixed_columns_mut::<3>(3).copy_from(&(by_place * since_s));
    let bent_m = 0.5 * ACCELERATION_M_S2 * since_s * since_s;
    let error = error_rad.powi(2) + (origin_error_m.powi(2) + bent_m.powi(2)) / (along_m * along_m);
    Some((off, by_state, 1.0 / error))
}

/// Where two bearings come nearest to each other, in front of both.
fn crossing(first: &Observation, second: &Observation) -> Option<Vector3<f64>> {
    let (
        Observation::Bearing {
            origin: a,
            direction: along_a,
            ..
        },
        Observation::Bearing {
            origin: b,
            direction: along_b,
            ..
        },
    ) = (first, second)
    else {
        return None;
    };
    let (between, angle) = (b - a, along_a.dot(along_b));
    let apart = 1.0 - angle * angle;
    // Less than half a degree: they never cross where that would mean anything.
    if apart < 1e-4 {
        return None;
    }
    let far_a = (between.dot(along_a) - angle * between.dot(along_b)) / apart;
    let far_b = (angle * between.dot(along_a) - between.dot(along_b)) / apart;
    let fits = |far: f64| (NEAREST_M..FARTHEST_M).contains(&far);
    (fits(far_a) && fits(far_b)).then(|| (a + along_a * far_a + b + along_b * far_b) * 0.5)
}
