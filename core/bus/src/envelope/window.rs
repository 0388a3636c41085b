//! Which numbers of one run of a sender were there before.
//!
//! Must never do: say of a number that was there, or may have been, that it was not.

/// How far back numbers are remembered one by one: datagrams of several classes overtake each other by less.
const REACH: u64 = 1024;
const WORDS: usize = (REACH / 64) as usize;

/// A sliding window over the numbers of one run (as of RFC 4303, appendix A2).
#[derive(Debug, Clone)]
pub struct Window {
    /// Nothing up to this number is taken.
    floor: u64,
    newest: u64,
    seen: [u64; WORDS],
}

impl Window {
    /// One that takes only numbers after `floor`.
    pub fn after(floor: u64) -> Self {
        Self {
            floor,
            newest: floor,
            seen: [0; WORDS],
        }
    }

    /// Whether this number is taken: it is new. It is not new any more from then on.
    pub fn take(&mut self, number: u64) -> bool {
        if number <= self.floor || self.newest.saturating_sub(number) >= REACH {
            return false;
        }
        if number > self.newest {
            // The places of the numbers that have been passed over are taken again by newer ones.
            for passed in (self.newest + 1..=number).rev().take(REACH as usize) {
                self.put(passed, false);
            }
            self.newest = number;
        }
        let new = !self.seen(number);
        self.put(number, true);
        new
    }

    fn seen(&self, number: u64) -> bool {
        let word = self
            .seen
            .get((number / 64) as usize % WORDS)
            .copied()
            .unwrap_or(u64::MAX);
        word >> (number % 64) & 1 == 1
    }

    fn put(&mut self, number: u64, seen: bool) {
        if let Some(word) = self.seen.get_mut((number / 64) as usize % WORDS) {
            *word = *word & !(1 << (number % 64)) | u64::from(seen) << (number % 64);
        }
    }
}

#[cfg(test)]
mod tests {
    //! Against the plainest account of it: the set of all that was taken.

    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn nothing_is_taken_twice_and_what_is_new_and_near_is_taken(steps in prop::collection::vec((any::<bool>(), 0_u64..1500), 1..400)) {
            let mut window = Window::after(100);
            let mut taken = BTreeSet::new();
            let mut newest = 100_u64;
            for (forward, by) in steps {
                let number = if forward { newest + by } else { newest.saturating_sub(by) };
                let should = number > 100 && newest.saturating_sub(number) < REACH && !taken.contains(&number);
                prop_assert_eq!(window.take(number), should, "{} at {}", number, newest);
                if should { taken.insert(number); }
                newest = newest.max(number);
            }
        }
    }

    #[test]
    fn numbers_at_the_end_do_not_wrap() {
        let mut window = Window::after(u64::MAX - 2);
        assert!(window.take(u64::MAX - 1) && window.take(u64::MAX) && !window.take(u64::MAX));
        assert!(!window.take(0));
    }
}
