//! Where something is and how it moves, with its covariance: an extended Kalman filter of constant velocity.
//!
//! An observation may be older than the estimate: it then corrects what the estimate says of that moment.

use super::Observation;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3, Matrix6, Vector2, Vector3, Vector6};
use skein_domain::NodeTime;

/// Steps to the most likely state; a bearing that crosses a long ellipse needs a few.
const STEPS: usize = 6;
/// Standard deviation of the velocity of something new, in m/s.
const FIRST_SPEED_M_S: f64 = 8.0;
/// Nearer than this a direction means nothing, in metres.
const NEAREST_M: f64 = 0.1;
/// Beyond this nothing is known of a place any more, in metres.
const LARGEST_ERROR_M: f64 = 1e5;

/// What is left when an observation is compared with an estimate, in as many numbers as it has.
struct Residual {
    off: DVector<f64>,
    by_place: DMatrix<f64>,
    noise: DMatrix<f64>,
}

/// How well an observation fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Squared deviation; its mean is the number of dimensions if all is well.
    pub(super) squared: f64,
    pub(super) dimensions: usize,
    /// Logarithm of the determinant of the covariance of what is left.
    pub(super) ln_det: f64,
}

impl Fit {
    /// Minus twice the logarithm of its likelihood, but for a constant.
    pub(super) fn cost(&self) -> f64 {
        self.squared + self.ln_det
    }
}

#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub(super) time: NodeTime,
    /// North, east, down in metres, and the same in metres per second.
    pub(super) state: Vector6<f64>,
    pub(super) covariance: Matrix6<f64>,
}

impl Estimate {
    /// Of something that was seen at this place, and may fly anywhere.
    pub(super) fn of_position(time: NodeTime, position: &Vector3<f64>, covariance: &Matrix3<f64>) -> Self {
        let mut whole = Matrix6::from_diagonal_element(FIRST_SPEED_M_S * FIRST_SPEED_M_S);
        whole.fixed_view_mut::<3, 3>(0, 0).copy_from(covariance);
        let mut state = Vector6::zeros();
        state.fixed_rows_mut::<3>(0).copy_from(position);
        Self {
            time,
            state,
            covariance: whole,
        }
    }

    pub(super) fn position(&self) -> Vector3<f64> {
        self.state.fixed_rows::<3>(0).into()
    }

    pub(super) fn velocity(&self) -> Vector3<f64> {
        self.state.fixed_rows::<3>(3).into()
    }

    pub(super) fn position_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into()
    }

    /// Whether it still says anything.
    pub(super) fn is_sound(&self) -> bool {
        let numbers = self.state.iter().chain(self.covariance.iter());
        numbers.into_iter().all(|number| number.is_finite())
            && (0..6).all(|index| self.covariance[(index, index)] > 0.0)
            && (0..3).all(|index| self.covariance[(index, index)] < LARGEST_ERROR_M * LARGEST_ERROR_M)
    }

    /// At another moment. `acceleration` is how quickly the velocity wanders, as a density in m²/s³.
    pub(super) fn at(&self, time: NodeTime, acceleration: f64) -> Self {
        let since_s = time.seconds_since(self.time);
        let step = transition(since_s);
        let covariance = step * self.covariance * step.transpose() + wandering(since_s, acceleration);
        Self {
            time,
            state: step * self.state,
            covariance,
        }
    }

    /// How well an observation of that moment fits.
    pub(super) fn fit(&self, time: NodeTime, seen: &Observation, acceleration: f64) -> Option<Fit> {
        let then = self.at(time, acceleration);
        let left = residual(&then.position(), seen)?;
        let whole = &left.by_place * then.position_covariance() * left.by_place.transpose() + &left.noise;
        let cholesky = whole.cholesky()?;
        let squared = left.off.dot(&cholesky.solve(&left.off));
        let ln_det = 2.0 * cholesky.l_dirty().diagonal().iter().map(|side| side.ln()).sum::<f64>();
        squared.is_finite().then_some(Fit {
            squared,
            dimensions: left.off.len(),
            ln_det,
        })
    }

    /// Takes an observation in. False if that is not possible, and nothing has changed.
    pub(super) fn correct(&mut self, time: NodeTime, seen: &Observation, acceleration: f64) -> bool {
        self.correct_by(time, seen, acceleration, 1.0)
    }

    /// The same, of an observation whose covariance is taken for so many times what it says.
    pub(super) fn correct_by(&mut self, time: NodeTime, seen: &Observation, acceleration: f64, times: f64) -> bool {
        let ahead = time >= self.time;
        let prior = if ahead {
            self.at(time, acceleration)
        } else {
            self.clone()
        };
        let back_s = time.seconds_since(prior.time);
        let (back, wander) = (transition(back_s), wandering(back_s, acceleration));
        let mut state = prior.state;
        let mut covariance = prior.covariance;
        for _ in 0..STEPS {
            let then: Vector3<f64> = (back * state).fixed_rows::<3>(0).into();
            let Some(left) = residual(&then, seen) else {
                return false;
            };
            let place = back.fixed_view::<3, 6>(0, 0);
            let by_state = &left.by_place * place;
            let wander_place: Matrix3<f64> = wander.fixed_view::<3, 3>(0, 0).into();
            let noise = &left.noise * times + &left.by_place * wander_place * left.by_place.transpose();
            let Some(whole) = (&by_state * prior.covariance * by_state.transpose() + &noise).cholesky() else {
                return false;
            };
            let gain = prior.covariance * by_state.transpose() * whole.inverse();
            let next = prior.state + &gain * (&left.off - &by_state * (prior.state - state));
            let step = (next - state).norm();
            state = next;
            let keeps = Matrix6::identity() - &gain * &by_state;
            // Joseph's form: it stays a covariance.
            covariance = keeps * prior.covariance * keeps.transpose() + &gain * noise * gain.transpose();
            if step < 1e-3 {
                break;
            }
        }
        let next = Self {
            time: prior.time,
            state,
            covariance: (covariance + covariance.transpose()) * 0.5,
        };
        let sound = next.is_sound();
        if sound {
            *self = next;
        }
        sound
    }
}

fn transition(since_s: f64) -> Matrix6<f64> {
    let mut step = Matrix6::identity();
    for axis in 0..3 {
        step[(axis, axis + 3)] = since_s;
    }
    step
}

/// What an unknown, white acceleration adds to the covariance in that time.
fn wandering(since_s: f64, density: f64) -> Matrix6<f64> {
    let (t, mut added) = (since_s.abs(), Matrix6::zeros());
    for axis in 0..3 {
        added[(axis, axis)] = density * t.powi(3) / 3.0;
        added[(axis, axis + 3)] = density * t * since_s / 2.0;
        added[(axis + 3, axis)] = density * t * since_s / 2.0;
        added[(axis + 3, axis + 3)] = density * t;
    }
    added
}

/// What is left of an observation when the thing is at this place; `None` if it cannot be there.
fn residual(place: &Vector3<f64>, seen: &Observation) -> Option<Residual> {
    match seen {
        Observation::Position { position, covariance } => Some(Residual {
            off: DVector::from_column_slice((position - place).as_slice()),
            by_place: DMatrix::identity(3, 3),
            noise: DMatrix::from_column_slice(3, 3, covariance.as_slice()),
        }),
        Observation::Bearing {
            origin,
            origin_error_m,
            direction,
            error_rad,
        } => {
            let Compared { off, by_place, along_m } = compare(&(place - origin), direction)?;
            let error_rad = error_rad.hypot(origin_error_m / along_m);
            let noise = Matrix2::from_diagonal_element(error_rad * error_rad);
            Some(Residual {
                off: DVector::from_column_slice(off.as_slice()),
                by_place: DMatrix::from_column_slice(2, 3, by_place.as_slice()),
                noise: DMatrix::from_column_slice(2, 2, noise.as_slice()),
            })
        }
    }
}

/// How far a place is off a direction, on the plane that touches the unit sphere there.
pub(super) struct Compared {
    /// Seen less expected.
    pub(super) off: Vector2<f64>,
    /// How what is expected changes with the place.
    pub(super) by_place: Matrix2x3<f64>,
    /// How far away the place is, along the direction.
    pub(super) along_m: f64,
}

/// Compares the way to a place with the direction in which it was seen; `None` behind, or so near that a direction means nothing.
pub(super) fn compare(way: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Compared> {
    let along_m = way.dot(direction);
    if along_m < NEAREST_M {
        return None;
    }
    let across = across(direction);
    Some(Compared {
        off: Vector2::from_fn(|row, _| -across[row].dot(way) / along_m),
        by_place: Matrix2x3::from_fn(|row, axis| {
            across[row][axis] / along_m - across[row].dot(way) * direction[axis] / (along_m * along_m)
        }),
        along_m,
    })
}

/// Two unit vectors across a direction and each other.
pub(super) fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let helper = if direction.z.abs() < 0.9 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let first = direction.cross(&helper).normalize();
    [first, direction.cross(&first)]
}
