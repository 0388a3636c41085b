//! From which slots a camera looks out of the formation without another vehicle in its picture.

use skein_domain::OffsetFrd;
use std::f64::consts::PI;

/// Half the opening of the cone that must be free, in radians (30 degrees): a camera of 60 degrees sees nobody.
pub const VIEW_HALF_ANGLE_RAD: f64 = PI / 6.0;

/// Where a vehicle in a slot can look without another slot in the cone of [`VIEW_HALF_ANGLE_RAD`], however far away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum View {
    /// Along the formation's heading, which is where its vehicles look.
    Ahead,
    /// Not ahead, but away from the middle of the formation: a camera that turns sees out.
    Outward,
    /// Neither.
    Blocked,
}

/// The view from each slot. Both directions are level; a slot in the very middle has no outward one.
#[must_use]
pub fn views(slots: &[OffsetFrd]) -> Vec<View> {
    let centre = slots.iter().map(OffsetFrd::vector).sum::<nalgebra::Vector3<f64>>() / slots.len().max(1) as f64;
    let cos_half = VIEW_HALF_ANGLE_RAD.cos();
    let view = |(i, slot): (usize, &OffsetFrd)| {
        let own = slot.vector();
        let free = |forward: f64, right: f64| {
            slots.iter().enumerate().filter(|(j, _)| *j != i).all(|(_, other)| {
                let to = other.vector() - own;
                to.x * forward + to.y * right < cos_half * to.norm()
            })
        };
        let out = own - centre;
        let out_m = out.x.hypot(out.y);
        if free(1.0, 0.0) {
            View::Ahead
        } else if out_m > MIDDLE_M && free(out.x / out_m, out.y / out_m) {
            View::Outward
        } else {
            View::Blocked
        }
    };
    slots.iter().enumerate().map(view).collect()
}

/// Nearer to the middle than this there is no outside, in metres.
const MIDDLE_M: f64 = 0.1;
