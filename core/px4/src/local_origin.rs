//! Where a vehicle's own frame has its origin: as the autopilot says (GPS_GLOBAL_ORIGIN), or from pairs of a place on Earth
//! and a local position of the same moment. Pairs are compared with it all the time: an estimator may move its origin.

use skein_domain::{Geodetic, LocalFrame, LocalPositionNed, VelocityNed};
use std::collections::VecDeque;

/// Local positions kept to find one near a global position's time.
const LOCALS_MAX: usize = 8;
/// A pair may be this far apart in time, in milliseconds; the rest is bridged with the velocity.
const PAIR_MAX_MS: i64 = 60;
/// Pairs averaged before an origin is derived from them.
const PAIRS: usize = 5;
/// An origin that is this far from where the pairs say is wrong or has been moved, in metres.
const MOVED_M: f64 = 1.5;

#[derive(Debug, Clone, Copy)]
struct LocalSample {
    stamp_ms: u32,
    position: LocalPositionNed,
    velocity: VelocityNed,
}

/// What came of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OriginChange {
    /// Nothing new.
    None,
    /// The origin is known now.
    Found,
    /// The estimator has moved its origin; it was derived anew.
    Moved,
}

/// Finds and watches the origin of one vehicle's frame.
#[derive(Debug, Default)]
pub struct LocalOrigin {
    frame: Option<LocalFrame>,
    locals: VecDeque<LocalSample>,
    /// Origins that the last pairs gave.
    pairs: VecDeque<Geodetic>,
}

impl LocalOrigin {
    /// The frame, once known.
    #[must_use]
    pub fn frame(&self) -> Option<LocalFrame> {
        self.frame
    }

    /// Forgets everything: the autopilot restarted.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// What the autopilot says.
    pub fn on_said(&mut self, origin: Geodetic) -> OriginChange {
        if !origin.is_valid() || (origin.latitude_deg == 0.0 && origin.longitude_deg == 0.0) {
            return OriginChange::None;
        }
        let new = LocalFrame { origin };
        match self.frame {
            None => {
                self.frame = Some(new);
                OriginChange::Found
            }
            Some(old) if distance_m(&old, &origin) < MOVED_M => {
                // The word is exact to the last digit, the pairs are means.
                self.frame = Some(new);
                OriginChange::None
            }
            Some(_) => {
                self.frame = Some(new);
                self.pairs.clear();
                OriginChange::Moved
            }
        }
    }

    /// A local position.
    pub fn on_local(&mut self, stamp_ms: u32, position: LocalPositionNed, velocity: VelocityNed) {
        if self.locals.len() >= LOCALS_MAX {
            self.locals.pop_front();
        }
        self.locals.push_back(LocalSample {
            stamp_ms,
            position,
            velocity,
        });
    }

    /// A global position: makes a pair with the local position nearest to it in time.
    pub fn on_global(&mut self, stamp_ms: u32, place: &Geodetic) -> OriginChange {
        let apart = |sample: &LocalSample| i64::from(stamp_ms.wrapping_sub(sample.stamp_ms).cast_signed());
        let Some(local) = self.locals.iter().min_by_key(|sample| apart(sample).abs()) else {
            return OriginChange::None;
        };
        let apart_ms = apart(local);
        if apart_ms.abs() > PAIR_MAX_MS {
            return OriginChange::None;
        }
        let position = local.position.vector() + local.velocity.vector() * (apart_ms as f64 * 1e-3);
        let pair = LocalFrame::from_pair(place, &position.into()).origin;
        if !pair.is_valid() {
            return OriginChange::None;
        }
        if self.pairs.len() >= PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back(pair);
        if self.pairs.len() < PAIRS {
            return OriginChange::None;
        }
        match self.frame {
            None => {
                self.frame = self.mean();
                OriginChange::Found
            }
            // Every single pair must disagree: a jump in the middle of them would give a mean that never was.
            Some(frame) if self.pairs.iter().all(|pair| distance_m(&frame, pair) > MOVED_M) => {
                self.frame = self.mean();
                OriginChange::Moved
            }
            Some(_) => OriginChange::None,
        }
    }

    fn mean(&self) -> Option<LocalFrame> {
        let about = LocalFrame {
            origin: *self.pairs.front()?,
        };
        let sum = self
            .pairs
            .iter()
            .map(|pair| about.position(pair).vector())
            .sum::<nalgebra::Vector3<f64>>();
        let origin = about.geodetic(&(sum / self.pairs.len() as f64).into());
        Some(LocalFrame { origin })
    }
}

fn distance_m(frame: &LocalFrame, place: &Geodetic) -> f64 {
    frame.position(place).norm()
}

#[cfg(test)]
mod tests {
    //! Derived, told, moved: and never half-way between two origins.

    use super::*;

    const ORIGIN: Geodetic = Geodetic {
        latitude_deg: 47.397_743_3,
        longitude_deg: 8.545_594_2,
        altitude_amsl_m: 489.443,
    };

    /// A global position as the autopilot sends it: in whole 1e-7 degrees and millimetres.
    fn sent(place: Geodetic) -> Geodetic {
        Geodetic {
            latitude_deg: (place.latitude_deg * 1e7).round() * 1e-7,
            longitude_deg: (place.longitude_deg * 1e7).round() * 1e-7,
            altitude_amsl_m: (place.altitude_amsl_m * 1e3).round() * 1e-3,
        }
    }

    /// Flies a circle about `origin` from `from_ms` on and gives what changed.
    fn fly(local_origin: &mut LocalOrigin, origin: Geodetic, from_ms: u32, pairs: u32) -> Vec<OriginChange> {
        let frame = LocalFrame { origin };
        let at = |ms: u32| {
            let angle = f64::from(ms) * 1e-3 / 5.0;
            (
                LocalPositionNed::new(50.0 * angle.cos(), 50.0 * angle.sin(), -10.0),
                VelocityNed::new(-10.0 * angle.sin(), 10.0 * angle.cos(), 0.0),
            )
        };
        let mut changes = Vec::new();
        for i in 0..pairs * 10 {
            let ms = from_ms + i * 20;
            let (position, velocity) = at(ms);
            local_origin.on_local(ms, position, velocity);
            if i % 10 == 9 {
                changes.push(local_origin.on_global(ms - 8, &sent(frame.geodetic(&at(ms - 8).0))));
            }
        }
        changes.retain(|&change| change != OriginChange::None);
        changes
    }

    #[test]
    fn pairs_give_the_origin_within_two_centimetres() {
        let mut local_origin = LocalOrigin::default();
        assert_eq!(fly(&mut local_origin, ORIGIN, 1000, 20), [OriginChange::Found]);
        assert!(distance_m(&local_origin.frame().unwrap(), &ORIGIN) < 0.02);
    }

    #[test]
    fn what_the_autopilot_says_wins_over_pairs_that_agree_and_loses_to_ones_that_do_not() {
        let mut local_origin = LocalOrigin::default();
        assert_eq!(
            local_origin.on_said(Geodetic::default()),
            OriginChange::None,
            "not set yet"
        );
        assert_eq!(local_origin.on_said(ORIGIN), OriginChange::Found);
        assert_eq!(fly(&mut local_origin, ORIGIN, 1000, 20), []);
        assert_eq!(local_origin.frame().unwrap().origin, ORIGIN);
        let moved = LocalFrame { origin: ORIGIN }.geodetic(&LocalPositionNed::new(30.0, -4.0, 1.0));
        assert_eq!(fly(&mut local_origin, moved, 9000, 20), [OriginChange::Moved]);
        assert!(distance_m(&local_origin.frame().unwrap(), &moved) < 0.02);
    }

    #[test]
    fn global_positions_without_a_local_one_near_in_time_say_nothing() {
        let mut local_origin = LocalOrigin::default();
        local_origin.on_local(1000, LocalPositionNed::default(), VelocityNed::default());
        for _ in 0..10 {
            assert_eq!(local_origin.on_global(1200, &ORIGIN), OriginChange::None);
        }
        assert_eq!(local_origin.frame(), None);
    }
}
