//! Where a box is and how it moves: a Kalman filter for each axis of its middle, and a slowly changing size.

use crate::{Bounds, Turn};

/// Pairs of a track and a box that are farther from each other than this do not belong together: 99.9 % of four squared deviations.
pub(super) const FARTHEST: f64 = 18.5;
/// How much the logarithm of a side may differ from one box to the next.
const SIDE_ERROR: f64 = 0.25;
/// How quickly the logarithm of a side changes, per square root of a second.
const SIDE_DRIFT: f64 = 0.5;
/// A new track may move as quickly as this, in its own sizes per second.
const FIRST_SPEED_SIZES_S: f64 = 6.0;
/// Boxes are whole pixels at best.
const LEAST_ERROR_PX: f64 = 0.7;

/// How things move and how well they are found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    pub(super) acceleration_sizes_s2: f64,
    pub(super) center_error_sizes: f64,
}

impl Noise {
    fn center_error_px(self, size_px: f64) -> f64 {
        (self.center_error_sizes * size_px).max(LEAST_ERROR_PX)
    }
}

/// Place and velocity along one axis, with their covariance.
#[derive(Debug, Clone, Copy)]
struct Axis {
    at: f64,
    speed: f64,
    var_at: f64,
    cov: f64,
    var_speed: f64,
}

impl Axis {
    fn advance(&mut self, since_s: f64, moved: f64, acceleration: f64) {
        self.at += self.speed * since_s + moved;
        self.var_at += since_s * (2.0 * self.cov + since_s * self.var_speed);
        self.cov += since_s * self.var_speed;
        // White acceleration that holds for the time of a picture.
        let var = (acceleration * since_s).powi(2);
        self.var_at += 0.25 * var * since_s * since_s;
        self.cov += 0.5 * var * since_s;
        self.var_speed += var;
    }

    fn correct(&mut self, seen: f64, var: f64) {
        let whole = self.var_at + var;
        let (gain_at, gain_speed) = (self.var_at / whole, self.cov / whole);
        let off = seen - self.at;
        self.at += gain_at * off;
        self.speed += gain_speed * off;
        self.var_speed -= gain_speed * self.cov;
        self.cov *= 1.0 - gain_at;
        self.var_at *= 1.0 - gain_at;
    }
}

/// A logarithm of a side.
#[derive(Debug, Clone, Copy)]
struct Side {
    ln_px: f64,
    var: f64,
}

impl Side {
    fn correct(&mut self, px: f64) {
        let gain = self.var / (self.var + SIDE_ERROR * SIDE_ERROR);
        self.ln_px += gain * (px.ln() - self.ln_px);
        self.var *= 1.0 - gain;
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct BoxFilter {
    x: Axis,
    y: Axis,
    width: Side,
    height: Side,
}

impl BoxFilter {
    pub(super) fn new(bounds: Bounds, noise: &Noise) -> Self {
        let size_px = bounds.area().sqrt();
        let axis = |at: f64| Axis {
            at,
            speed: 0.0,
            var_at: noise.center_error_px(size_px).powi(2),
            cov: 0.0,
            var_speed: (FIRST_SPEED_SIZES_S * size_px).powi(2),
        };
        let side = |px: f64| Side {
            ln_px: px.ln(),
            var: SIDE_ERROR * SIDE_ERROR,
        };
        Self {
            x: axis(bounds.center_x_px),
            y: axis(bounds.center_y_px),
            width: side(bounds.width_px),
            height: side(bounds.height_px),
        }
    }

    fn size_px(&self) -> f64 {
        (0.5 * (self.width.ln_px + self.height.ln_px)).exp()
    }

    /// To the next picture.
    pub(super) fn advance(&mut self, since_s: f64, turn: &Turn, noise: &Noise) {
        let (moved_x_px, moved_y_px) = turn.at(self.x.at, self.y.at);
        let acceleration = noise.acceleration_sizes_s2 * self.size_px();
        self.x.advance(since_s, moved_x_px, acceleration);
        self.y.advance(since_s, moved_y_px, acceleration);
        for side in [&mut self.width, &mut self.height] {
            side.var = (side.var + SIDE_DRIFT * SIDE_DRIFT * since_s).min(1.0);
        }
    }

    pub(super) fn correct(&mut self, seen: &Bounds, noise: &Noise) {
        let var = noise.center_error_px(seen.area().sqrt()).powi(2);
        self.x.correct(seen.center_x_px, var);
        self.y.correct(seen.center_y_px, var);
        self.width.correct(seen.width_px);
        self.height.correct(seen.height_px);
    }

    /// How far a box is from this one, in squared standard deviations; `None` if it cannot be the same.
    pub(super) fn distance(&self, seen: &Bounds, noise: &Noise) -> Option<f64> {
        let var = noise.center_error_px(seen.area().sqrt()).powi(2);
        let off = |axis: &Axis, at: f64| (at - axis.at).powi(2) / (axis.var_at + var);
        let size = |side: &Side, px: f64| (px.ln() - side.ln_px).powi(2) / (side.var + SIDE_ERROR * SIDE_ERROR);
        let distance = off(&self.x, seen.center_x_px)
            + off(&self.y, seen.center_y_px)
            + size(&self.width, seen.width_px)
            + size(&self.height, seen.height_px);
        (distance < FARTHEST).then_some(distance)
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds {
            center_x_px: self.x.at,
            center_y_px: self.y.at,
            width_px: self.width.ln_px.exp(),
            height_px: self.height.ln_px.exp(),
        }
    }

    pub(super) fn velocity_px_s(&self) -> (f64, f64) {
        (self.x.speed, self.y.speed)
    }

    pub(super) fn error_px(&self) -> f64 {
        self.x.var_at.max(self.y.var_at).sqrt()
    }
}
