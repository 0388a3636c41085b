//! A bound to a velocity along one direction: what fences and other vehicles ask of it.

use nalgebra::Vector3;

/// A half of all velocities: those that are no faster along `normal` than the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Where to, north, east and down; of length one, pointing out of what is allowed.
    pub normal: Vector3<f64>,
    /// `normal · velocity` may be at most this, in metres per second.
    pub limit_m_s: f64,
}

impl HalfSpace {
    /// Whether a velocity in metres per second is within it.
    #[must_use]
    pub fn contains(&self, velocity_m_s: &Vector3<f64>) -> bool {
        self.normal.dot(velocity_m_s) <= self.limit_m_s
    }
}
