//! The clock that a vehicle's stamps are on, seen from the node's.
//!
//! Must never do: take samples that were held up on the way for a clock that was set back.
//!
//! PX4 stamps with the time since it started, and, once it is synchronised with its agent, with the agent's time since 1970. Either way what
//! comes back to it is stamped on the same clock, so that only the difference to the node's clock matters.
//!
//! What PX4 adds to its clock says nothing of a restart: when the agent's clock was set, or its own goes at another pace, PX4 drops what it knew,
//! stamps without it for a moment, and finds another one. Only the time since its start tells, which goes back when PX4 starts anew and never else.

mod trend;

use skein_domain::NodeTime;
use trend::Trend;

/// A sample this far off the difference is late, or of a clock that was set, in microseconds.
const OFF_US: i64 = 250_000;
/// Samples of a clock that was set agree this well, in microseconds; those that were held up do not, for they come all at once.
const AGREE_US: i64 = 100_000;
/// For how long and how often they have to agree.
const SETTLED_S: f64 = 0.4;
const SETTLED_SAMPLES: u32 = 5;
/// Stamps from here on count from 1970.
const SINCE_1970_US: i64 = 1_000_000_000_000_000;
/// A clock that counts from the start and goes back by more than this was started anew, in seconds.
const RESTART_S: f64 = 2.0;
/// So did one that falls behind by this share of the time for which nothing was heard of it, and by the above; a simulation's falls behind by less.
const BEHIND_SHARE: f64 = 0.25;

/// What stamps tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tick {
    /// Nothing new.
    Steady,
    /// The clock was set by this many seconds.
    Jumped {
        /// Forward positive.
        by_s: f64,
    },
    /// The autopilot started anew.
    Restarted,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    ahead_us: i64,
    since: NodeTime,
    samples: u32,
}

/// One vehicle's clock.
#[derive(Debug, Default)]
pub struct WireClock {
    /// How far its stamps are ahead of the node's time.
    stamps: Trend,
    /// How far the time since its start is ahead of the node's time. While PX4 has no agent it stamps with this.
    since_start: Trend,
    candidate: Option<Candidate>,
    doubted: bool,
    /// The time since its start in microseconds, and when that was heard.
    up: Option<(NodeTime, i64)>,
    round_trip_s: Option<f64>,
}

impl WireClock {
    /// The stamp of a sample that was just heard.
    pub fn on_stamp(&mut self, now: NodeTime, stamp_us: u64) -> Tick {
        let ahead_us = difference_us(stamp_us, now);
        let Some(known) = self.stamps.ahead_us(now) else {
            self.begin(now, ahead_us);
            return Tick::Steady;
        };
        if (ahead_us - known).abs() <= OFF_US {
            (self.candidate, self.doubted) = (None, false);
            self.stamps.take(now, ahead_us);
            self.note_since_start(now, ahead_us);
            return Tick::Steady;
        }
        let candidate = match &mut self.candidate {
            Some(candidate) if (ahead_us - candidate.ahead_us).abs() <= AGREE_US => candidate,
            other => other.insert(Candidate {
                ahead_us,
                since: now,
                samples: 0,
            }),
        };
        candidate.samples += 1;
        // A simulation's clock falls behind while it is waited for.
        candidate.ahead_us = ahead_us;
        if candidate.samples < SETTLED_SAMPLES || now.seconds_since(candidate.since) < SETTLED_S {
            return Tick::Steady;
        }
        let settled = candidate.ahead_us;
        let was = known.saturating_add_unsigned(now.0);
        let (counted_from_1970, counts_from_1970) = (was >= SINCE_1970_US, stamp_us as i64 >= SINCE_1970_US);
        self.begin(now, settled);
        let by_s = (settled - known) as f64 * 1e-6;
        match (counted_from_1970, counts_from_1970) {
            // It was synchronised with its agent.
            (false, true) => Tick::Steady,
            // It is not any more, which alone is no restart.
            (true, false) if self.up.is_some() && !self.is_up(now, stamp_us as i64) => Tick::Steady,
            (true, false) => Tick::Restarted,
            (false, false) if by_s < -RESTART_S => Tick::Restarted,
            _ => Tick::Jumped { by_s },
        }
    }

    /// What PX4 says of its clock and its agent's, with the stamp of that. True if it must have started anew.
    pub fn on_sync(&mut self, now: NodeTime, stamp_us: u64, offset_us: i64, round_trip_us: u32) -> bool {
        self.round_trip_s = Some(f64::from(round_trip_us) * 1e-6);
        let stamp_us = i64::try_from(stamp_us).unwrap_or(i64::MAX);
        // The offset is PX4's clock minus its agent's.
        let up_us = match stamp_us {
            SINCE_1970_US.. => stamp_us.saturating_add(offset_us),
            _ => stamp_us,
        };
        // One of them may be older than the other.
        let is_plausible = (0..SINCE_1970_US).contains(&up_us);
        if is_plausible {
            self.note_since_start(now, up_us.saturating_sub_unsigned(now.0));
        }
        is_plausible && self.is_up(now, up_us)
    }

    /// Takes in a difference that is of the time since its start; one of the time since 1970 is passed over.
    fn note_since_start(&mut self, now: NodeTime, ahead_us: i64) {
        if ahead_us < SINCE_1970_US / 2 {
            self.since_start.take_any(now, ahead_us, OFF_US);
        }
    }

    /// It is up for so long. True if it was up for longer before, or for so long that it cannot be the same start.
    fn is_up(&mut self, now: NodeTime, up_us: i64) -> bool {
        let Some((heard, before_us)) = self.up.replace((now, up_us)) else {
            return false;
        };
        let (passed_s, by_s) = (now.seconds_since(heard), (up_us - before_us) as f64 * 1e-6);
        by_s < -RESTART_S || passed_s - by_s > RESTART_S + BEHIND_SHARE * passed_s
    }

    fn begin(&mut self, now: NodeTime, ahead_us: i64) {
        (self.candidate, self.doubted) = (None, false);
        self.stamps = Trend::new(now, ahead_us);
        self.note_since_start(now, ahead_us);
    }

    /// The vehicle's time since its start minus the node's time, in seconds, as over MAVLink. It stays the same when PX4 finds or loses its agent
    /// and stamps with another time from then on.
    #[must_use]
    pub fn offset_s(&self, now: NodeTime) -> Option<f64> {
        self.since_start.ahead_us(now).map(|us| us as f64 * 1e-6)
    }

    /// Round trip between PX4 and its agent in seconds.
    #[must_use]
    pub fn round_trip_s(&self) -> Option<f64> {
        self.round_trip_s
    }

    /// When something was measured that has this stamp and was heard at `heard`; never later than that.
    #[must_use]
    pub fn measured(&self, heard: NodeTime, stamp_us: u64) -> NodeTime {
        let Some(ahead) = self.stamps.ahead_us(heard) else {
            return heard;
        };
        let at = i64::try_from(stamp_us).unwrap_or(i64::MAX).saturating_sub(ahead);
        let at = NodeTime(u64::try_from(at).unwrap_or(0));
        // By more than that it is another clock's stamp, not one of long ago.
        if heard.seconds_since(at) > 1.0 {
            heard
        } else {
            at.min(heard)
        }
    }

    /// Whoever is heard next may have another clock.
    pub fn doubt(&mut self) {
        self.doubted = true;
    }

    /// The stamp for a message that is sent now; 0, which PX4 takes for the time of receipt, as long as its clock is not known or may be another.
    #[must_use]
    pub fn stamp_us(&self, now: NodeTime) -> u64 {
        let sure = !self.doubted && self.candidate.is_none();
        let Some(ahead) = self.stamps.ahead_us(now).filter(|_| sure) else {
            return 0;
        };
        now.0.saturating_add_signed(ahead)
    }
}

fn difference_us(stamp_us: u64, now: NodeTime) -> i64 {
    let signed = |us: u64| i64::try_from(us).unwrap_or(i64::MAX);
    signed(stamp_us).saturating_sub(signed(now.0))
}

#[cfg(test)]
mod tests {
    //! Drift, delay, steps and restarts.

    use super::*;

    fn at(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    /// 50 Hz from one moment to another, stamped `ahead_s` before or after; what was told.
    fn hear(clock: &mut WireClock, from_s: f64, to_s: f64, ahead_s: f64) -> Vec<Tick> {
        let steps = ((to_s - from_s) * 50.0) as u32;
        let mut told: Vec<_> = (0..steps)
            .map(|i| {
                let now = from_s + f64::from(i) * 0.02;
                let delay = 0.001 + f64::from(i % 7) * 0.002;
                clock.on_stamp(at(now), at(now + ahead_s - delay).0)
            })
            .collect();
        told.retain(|tick| *tick != Tick::Steady);
        told
    }

    #[test]
    fn the_shortest_way_gives_the_difference() {
        let mut clock = WireClock::default();
        assert_eq!(clock.stamp_us(at(10.0)), 0, "not known yet");
        assert_eq!(hear(&mut clock, 10.0, 30.0, 3.0), []);
        assert!(
            (clock.offset_s(at(30.0)).unwrap() - 2.999).abs() < 1e-3,
            "{:?}",
            clock.offset_s(at(30.0))
        );
        let measured = clock.measured(at(30.0), at(32.9).0);
        assert!((measured.as_seconds() - 29.901).abs() < 2e-3, "{measured:?}");
        assert_eq!(clock.measured(at(30.0), at(40.0).0), at(30.0), "never in the future");
    }

    #[test]
    fn samples_that_were_held_up_are_no_step() {
        let mut clock = WireClock::default();
        assert_eq!(hear(&mut clock, 10.0, 12.0, 3.0), []);
        for i in 0..100 {
            // Two seconds of samples at once.
            assert_eq!(clock.on_stamp(at(14.0), at(15.0 + f64::from(i) * 0.02).0), Tick::Steady);
        }
        assert_eq!(hear(&mut clock, 14.0, 16.0, 3.0), []);
        assert!((clock.offset_s(at(16.0)).unwrap() - 2.999).abs() < 1e-3);
    }

    #[test]
    fn a_simulations_pace_is_no_step_and_makes_no_position_old() {
        for pace in [0.5, 0.98, 1.5] {
            let mut clock = WireClock::default();
            for i in 0..1000 {
                let now_s = 10.0 + f64::from(i) * 0.02;
                let stamp = at(3.0 + f64::from(i) * 0.02 * pace).0;
                assert_eq!(clock.on_stamp(at(now_s + 0.002), stamp), Tick::Steady, "{i} at {pace}");
                let age_s = now_s - clock.measured(at(now_s + 0.002), stamp).as_seconds();
                assert!(age_s < if i < 50 { 0.25 } else { 0.02 }, "{age_s} s at {pace}");
            }
        }
    }

    #[test]
    fn a_clock_that_may_be_another_stamps_nothing() {
        let mut clock = WireClock::default();
        assert_eq!(hear(&mut clock, 10.0, 12.0, 3.0), []);
        assert_ne!(clock.stamp_us(at(12.0)), 0);
        clock.doubt();
        assert_eq!(clock.stamp_us(at(14.0)), 0);
        clock.on_stamp(at(14.0), at(16.995).0);
        assert_ne!(clock.stamp_us(at(14.0)), 0, "it is the same");
        clock.on_stamp(at(14.1), at(1.0).0);
        assert_eq!(clock.stamp_us(at(14.1)), 0);
        assert_eq!(hear(&mut clock, 14.1, 15.0, -13.1), [Tick::Restarted]);
        assert!((clock.stamp_us(at(15.0)) as f64 * 1e-6 - 1.9).abs() < 0.01);
    }

    #[test]
    fn steps_restarts_and_the_agents_clock_are_told_apart() {
        let mut clock = WireClock::default();
        assert_eq!(hear(&mut clock, 10.0, 12.0, 3.0), []);
        let told = hear(&mut clock, 12.0, 14.0, 4.0);
        assert!(
            matches!(told[..], [Tick::Jumped { by_s }] if (by_s - 1.0).abs() < 0.02),
            "{told:?}"
        );
        assert_eq!(hear(&mut clock, 14.0, 16.0, -10.0), [Tick::Restarted]);
        assert_eq!(hear(&mut clock, 16.0, 18.0, 1.7e9), [], "synchronised with its agent");
        assert!((clock.stamp_us(at(18.0)) as f64 * 1e-6 - 1.7e9 - 18.0).abs() < 0.1);
        assert_eq!(hear(&mut clock, 18.0, 20.0, -17.0), [Tick::Restarted]);
    }

    /// The agent's clock minus the node's, in seconds.
    const AGENT_S: f64 = 1.7e9;

    /// What PX4 says once a second of its clock, which is up for `up_s` at first and goes at a pace of its own; true if it is taken for a restart.
    fn sync(clock: &mut WireClock, from_s: f64, for_s: u32, up_s: f64, pace: f64) -> bool {
        (0..for_s).any(|i| {
            let (now, up) = (from_s + f64::from(i), at(up_s + f64::from(i) * pace).0);
            let stamp = at(now + AGENT_S).0;
            clock.on_sync(at(now), stamp, up as i64 - stamp as i64, 900)
        })
    }

    #[test]
    fn a_restart_is_told_by_the_time_since_the_start_alone() {
        let mut clock = WireClock::default();
        assert!(!sync(&mut clock, 10.0, 20, 100.0, 1.0));
        // Of a simulation that cannot keep up.
        assert!(!sync(&mut clock, 30.0, 60, 120.0, 0.8));
        // PX4 has dropped its estimate: for a moment the offset is nothing and the stamp without it; then there is another one.
        assert!(!clock.on_sync(at(90.0), at(168.0).0, 0, 900));
        assert!(!sync(&mut clock, 91.0, 10, 169.0, 1.0));
        // Once more, and the stamp was not yet without it.
        assert!(!clock.on_sync(at(101.0), at(101.0 + AGENT_S).0, 0, 900));
        assert!(!sync(&mut clock, 102.0, 10, 180.0, 1.0));
        // Not heard for half a minute.
        assert!(!sync(&mut clock, 141.0, 10, 219.0, 1.0));
        assert!(sync(&mut clock, 151.0, 1, 3.0, 1.0));
        assert!(!sync(&mut clock, 152.0, 10, 4.0, 1.0));
        // Not heard for a minute, up for longer than before and yet not since then.
        assert!(sync(&mut clock, 221.0, 1, 30.0, 1.0));
    }

    #[test]
    fn the_offset_is_that_of_the_time_since_its_start_whatever_it_stamps_with() {
        let near = |clock: &WireClock, now_s: f64, offset_s: f64| {
            let found_s = clock.offset_s(at(now_s)).unwrap();
            assert!((found_s - offset_s).abs() < 0.01, "{found_s} s, not {offset_s}");
        };
        let mut clock = WireClock::default();
        assert_eq!(hear(&mut clock, 10.0, 12.0, 90.0), []);
        near(&clock, 12.0, 90.0);
        // It finds its agent.
        assert_eq!(hear(&mut clock, 12.0, 14.0, AGENT_S), []);
        assert!(!sync(&mut clock, 14.0, 1, 104.0, 1.0));
        near(&clock, 14.0, 90.0);
        // It loses it for a moment.
        assert_eq!(hear(&mut clock, 15.0, 17.0, 90.0), []);
        near(&clock, 17.0, 90.0);
        assert_eq!(hear(&mut clock, 17.0, 19.0, AGENT_S), []);
        assert!(!sync(&mut clock, 19.0, 1, 109.0, 1.0));
        near(&clock, 19.0, 90.0);
        // Set by hand: what it adds changes by as much.
        assert!(matches!(
            hear(&mut clock, 20.0, 22.0, AGENT_S + 7.0)[..],
            [Tick::Jumped { .. }]
        ));
        let stamp = at(22.0 + AGENT_S + 7.0).0;
        assert!(!clock.on_sync(at(22.0), stamp, at(112.0).0 as i64 - stamp as i64, 900));
        near(&clock, 22.0, 90.0);
    }

    #[test]
    fn one_that_has_lost_its_agents_clock_has_not_started_anew() {
        let mut clock = WireClock::default();
        assert_eq!(hear(&mut clock, 10.0, 20.0, AGENT_S), []);
        assert!(!sync(&mut clock, 20.0, 1, 100.0, 1.0));
        assert_eq!(
            hear(&mut clock, 20.0, 25.0, 80.0),
            [],
            "it stamps with the time since its start"
        );
        assert_eq!(hear(&mut clock, 25.0, 30.0, AGENT_S + 0.1), []);
        assert!(!sync(&mut clock, 30.0, 1, 110.0, 1.0));
        assert_eq!(hear(&mut clock, 30.0, 35.0, -29.0), [Tick::Restarted]);
    }
}
