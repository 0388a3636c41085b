//! What a coordinator decides, as told by another node's clock.
//!
//! Must never do: change anything but moments.

use crate::formation::Formation;
use crate::state::Coordination;

impl Coordination {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        if let Some(formation) = &mut self.formation {
            formation.put_on_clock_ahead_by(ahead_us);
        }
        for flight in self.flights.values_mut() {
            flight.trajectory.put_on_clock_ahead_by(ahead_us);
        }
    }
}

impl Formation {
    fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.decided = self.decided.on_clock_ahead_by(ahead_us);
        self.settled_at = self.settled_at.on_clock_ahead_by(ahead_us);
        for slot in self.slots.values_mut() {
            slot.put_on_clock_ahead_by(ahead_us);
        }
        for keeping in self.keeping.values_mut() {
            keeping.put_on_clock_ahead_by(ahead_us);
        }
        if let Some(anchor) = &mut self.anchor {
            anchor.put_on_clock_ahead_by(ahead_us);
        }
    }
}
