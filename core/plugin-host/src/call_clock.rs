//! How long a call of a plugin has lasted, for threads of this process and for child processes alike.
//!
//! Must never do: blame a call for time in which it could not run.

use std::time::Duration;
use tokio::time::Instant;

/// How many times a call is seen before it can be given up: with a look every quarter of a deadline, one that lasts a whole one.
pub(crate) const LOOKS_PER_DEADLINE: u32 = 4;
/// However starved its thread was, a call is given up after so many deadlines.
const LONGEST_GRACE: u32 = 20;
/// At which look it is noted how starved the thread had been before: nearly all calls are over by then, and cost nothing.
const NOTED_AT: u32 = 1;

/// How long a call has lasted, as far as it can be blamed for it. From one look to the next a quarter of its deadline counts at most: where
/// whoever looks was kept from it for longer, the call was too, or may have been. Of what counts, the time is taken off in which its thread
/// was ready to run and waited for a processor.
#[derive(Debug)]
pub(crate) struct CallClock {
    deadline: Duration,
    looked: Instant,
    looks: u32,
    counted: Duration,
    starved_before: Option<Duration>,
}

impl CallClock {
    /// Of a call that begins now.
    pub(crate) fn new(now: Instant, deadline: Duration) -> Self {
        Self {
            deadline,
            looked: now,
            looks: 0,
            counted: Duration::ZERO,
            starved_before: None,
        }
    }

    /// A look at the call: whether it is over its deadline. `starved` tells how long its thread has waited for a processor, in all its life.
    pub(crate) fn is_over(&mut self, now: Instant, starved: impl FnOnce() -> Option<Duration>) -> bool {
        let gap = now.saturating_duration_since(self.looked);
        self.looked = now;
        self.looks = self.looks.saturating_add(1);
        self.counted += gap.min(self.deadline / LOOKS_PER_DEADLINE);
        if self.looks == NOTED_AT {
            self.starved_before = starved();
            return false;
        }
        if self.counted < self.deadline {
            return false;
        }
        let since = starved().and_then(|starved| starved.checked_sub(self.starved_before?));
        let blamed = self.counted.saturating_sub(since.unwrap_or_default());
        blamed >= self.deadline || self.counted >= self.deadline.saturating_mul(LONGEST_GRACE)
    }
}

#[cfg(test)]
mod tests {
    //! What a call is blamed for.

    use super::*;

    const DEADLINE: Duration = Duration::from_millis(100);
    const LOOK: Duration = Duration::from_millis(25);

    /// After how long a call is given up that is looked at with these pauses; `starved` in all its life by then, of the time since it began.
    fn given_up(
        pauses: impl IntoIterator<Item = Duration>,
        starved: fn(Duration) -> Option<Duration>,
    ) -> Option<Duration> {
        let begun = Instant::now();
        let mut clock = CallClock::new(begun, DEADLINE);
        let mut now = begun;
        for pause in pauses {
            now += pause;
            if clock.is_over(now, || starved(now - begun)) {
                return Some(now - begun);
            }
        }
        None
    }

    #[test]
    fn a_call_that_only_lasts_is_given_up_after_its_deadline() {
        let no_word: fn(Duration) -> Option<Duration> = |_| None;
        assert_eq!(given_up([LOOK; 10], |_| Some(Duration::ZERO)), Some(DEADLINE));
        assert_eq!(
            given_up([LOOK; 10], no_word),
            Some(DEADLINE),
            "where the system tells nothing"
        );
    }

    #[test]
    fn a_machine_that_stands_still_counts_as_one_look() {
        let stop = Duration::from_secs(2);
        let pauses = [LOOK, stop, LOOK, LOOK, LOOK];
        assert_eq!(given_up(pauses, |_| None), Some(stop + 3 * LOOK));
        assert_eq!(given_up([stop; 3], |_| None), None);
    }

    #[test]
    fn what_its_thread_waited_for_a_processor_is_taken_off_for_a_while() {
        assert_eq!(given_up([LOOK; 6], |since| Some(since / 2)), None);
        assert_eq!(given_up([LOOK; 7], |since| Some(since / 2)), Some(7 * LOOK));
        let for_ever = given_up(std::iter::repeat_n(LOOK, 1_000), Some);
        assert_eq!(for_ever, Some(DEADLINE * LONGEST_GRACE));
    }
}
