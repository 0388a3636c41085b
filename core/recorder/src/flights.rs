//! When one file ends and the next begins: a file for each flight, from before it is armed until after all have landed.
//!
//! Must never do: end a file in flight.

use skein_domain::NodeTime;

/// A flight is over when nobody has been armed for so long, in seconds.
const OVER_AFTER_S: f64 = 10.0;
/// A file of vehicles that stand is ended after so long, in seconds.
const STANDING_S: f64 = 3_600.0;

/// What the present file is of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flights {
    begun: Option<NodeTime>,
    /// Last time that somebody was armed, in this file.
    armed: Option<NodeTime>,
}

impl Flights {
    /// Whether somebody was armed in the present file.
    #[must_use]
    pub fn has_flown(&self) -> bool {
        self.armed.is_some()
    }

    /// Whether a flight is under way.
    #[must_use]
    pub fn is_under_way(&self, now: NodeTime) -> bool {
        self.armed.is_some_and(|armed| now.seconds_since(armed) < OVER_AFTER_S)
    }

    /// What is seen now; whether the present file is to be ended before it is recorded.
    pub fn see(&mut self, now: NodeTime, anybody_armed: bool) -> bool {
        let begun = *self.begun.get_or_insert(now);
        let over = self.has_flown() && !self.is_under_way(now);
        let stood = !self.has_flown() && now.seconds_since(begun) >= STANDING_S;
        let ends = over || stood;
        if ends {
            *self = Self {
                begun: Some(now),
                armed: None,
            };
        }
        if anybody_armed {
            self.armed = Some(now);
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn second(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    #[test]
    fn a_file_holds_one_flight_and_what_was_before_it() {
        let mut flights = Flights::default();
        assert!(!flights.see(second(0.0), false) && !flights.see(second(100.0), false));
        for s in 100..400 {
            assert!(!flights.see(second(f64::from(s)), true));
        }
        assert!(!flights.see(second(405.0), false) && flights.is_under_way(second(405.0)));
        // Armed again within a moment: the same flight.
        assert!(!flights.see(second(408.0), true));
        assert!(!flights.see(second(417.0), false));
        assert!(flights.see(second(418.0), false));
        assert!(!flights.has_flown());
        assert!(!flights.see(second(419.0), false));
    }

    #[test]
    fn who_arms_in_the_moment_a_flight_ends_is_in_the_next_file() {
        let mut flights = Flights::default();
        flights.see(second(1.0), true);
        assert!(flights.see(second(50.0), true));
        assert!(flights.has_flown() && !flights.see(second(51.0), true));
    }

    #[test]
    fn standing_vehicles_fill_a_file_an_hour_and_flying_ones_one_however_long() {
        let mut flights = Flights::default();
        assert!(!flights.see(second(0.0), false));
        assert!(flights.see(second(3_600.0), false));
        for s in 3_601..20_000 {
            assert!(!flights.see(second(f64::from(s)), true));
        }
    }
}
