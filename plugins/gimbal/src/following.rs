//! Whether a gimbal follows: looks where it is wanted, or is on its way there. Pure.

use minicbor::{Decode, Encode};
use nalgebra::Vector3;
use skein_domain::NodeTime;

/// So far behind a direction that moves, in seconds, a gimbal that follows may be: PX4 filters servos with 0.3 s, and the way there and
/// back takes time.
const LAG_S: f64 = 0.5;

/// What counts as apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Radians.
    pub(crate) tolerance_rad: f64,
    /// Seconds.
    pub(crate) after_s: f64,
}

/// One look at it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Look {
    /// Where it is wanted, as seen from the vehicle.
    pub(crate) wanted: Vector3<f64>,
    /// How far off it looks, in radians.
    pub(crate) off_rad: f64,
}

/// What changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    Stays,
    Follows,
}

/// Whether a gimbal follows, by all looks so far.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub(crate) struct Following {
    #[n(0)]
    apart: Option<Apart>,
    #[n(1)]
    stays: bool,
    /// When and where it was last wanted.
    #[n(2)]
    before: Option<(NodeTime, [f64; 3])>,
}

/// How long it has been apart without coming nearer.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
struct Apart {
    #[n(0)]
    since: NodeTime,
    #[n(1)]
    farthest_rad: f64,
}

impl Following {
    /// It does not follow.
    pub(crate) fn stays(&self) -> bool {
        self.stays
    }

    /// Something else is wanted of it: it gets its time anew.
    pub(crate) fn restart(&mut self) {
        (self.apart, self.before) = (None, None);
    }

    /// Looks at it. `None` where nothing is wanted of it, or cannot be seen or reached.
    pub(crate) fn look(&mut self, now: NodeTime, look: Option<Look>, bounds: Bounds) -> Option<Change> {
        let Some(Look { wanted, off_rad }) = look else {
            *self = Self::default();
            return None;
        };
        let moves_rad_s = self.before.map_or(0.0, |(when, before)| {
            let dt_s = now.seconds_since(when).max(1e-3);
            wanted.angle(&Vector3::from(before)) / dt_s
        });
        self.before = Some((now, wanted.into()));
        if off_rad <= bounds.tolerance_rad {
            self.apart = None;
            return std::mem::take(&mut self.stays).then_some(Change::Follows);
        }
        if off_rad <= bounds.tolerance_rad + moves_rad_s * LAG_S {
            self.apart = None;
            return None;
        }
        let apart = self.apart.get_or_insert(Apart {
            since: now,
            farthest_rad: off_rad,
        });
        if off_rad <= apart.farthest_rad - bounds.tolerance_rad {
            // On its way.
            *apart = Apart {
                since: now,
                farthest_rad: off_rad,
            };
        }
        apart.farthest_rad = apart.farthest_rad.max(off_rad);
        let stays = now.seconds_since(apart.since) >= bounds.after_s;
        (stays && !std::mem::replace(&mut self.stays, true)).then_some(Change::Stays)
    }
}

#[cfg(test)]
mod tests;
