//! Offset between the autopilot's clock and the node's, and the round trip, by TIMESYNC.
//!
//! The autopilot's clock may run at another pace (a simulation slower than real time does): the offset is followed by an
//! alpha-beta filter, so that a steady drift leaves no lag. Its gains begin as those of the straight line through all samples since
//! the start, so that a pace of one half is known after two of them.

use mavlink::dialects::common::TIMESYNC_DATA;
use skein_domain::NodeTime;

/// Samples at the start are taken this fast, per second, until the filter has settled.
const SETTLING_HZ: f64 = 5.0;
/// How many samples that takes.
const SETTLING_SAMPLES: u32 = 8;
/// A simulation's pace changes with what else its computer does: it is asked this often, per second.
const SIMULATED_HZ: f64 = 5.0;
/// A round trip over this multiple of the usual one, plus [`SLACK_S`], says little about the offset.
const OUTLIER_FACTOR: f64 = 3.0;
const SLACK_S: f64 = 0.01;
/// After so many refused samples in a row the line has become slow for good.
const REFUSALS_MAX: u32 = 5;
/// An offset this far from the expected one is a new clock, in seconds.
const NEW_CLOCK_S: f64 = 1.0;
/// An offset this much further from the expected one than the round trip can explain is a step of the clock, in seconds.
const JUMP_S: f64 = 0.05;
/// Two measurements of the same step agree this well, in seconds; one alone may be a stamp that had waited.
const AGREE_S: f64 = 0.02;
/// How soon the second one is asked for, in seconds.
const CONFIRM_S: f64 = 0.1;
const ALPHA: f64 = 0.35;
const BETA: f64 = 0.1;
/// The offset drifts at most this much, in seconds per second: from a clock that stands to one twice as fast as ours.
const DRIFT_MAX: f64 = 1.0;
const ROUND_TRIP_ALPHA: f64 = 0.2;
/// An answer older than this is not one to us any more, in seconds.
const ANSWER_MAX_S: f64 = 2.0;

/// Whether a measurement of the offset tells of a step of the clock.
enum ClockStep {
    /// No.
    None,
    /// It may; it must not be used until the next one is there.
    Suspected,
    /// It does.
    Made { by_s: f64 },
}

/// Clock offset and round trip of one vehicle.
#[derive(Debug, Default)]
pub struct ClockSync {
    next_request: NodeTime,
    /// Time stamps of requests that may still be answered, newest last.
    asked: [i64; 4],
    samples: u32,
    refused: u32,
    /// Autopilot time minus node time in seconds, at `at`.
    offset_s: f64,
    at: NodeTime,
    drift: f64,
    round_trip_s: Option<f64>,
    /// The offset that a step would have led to, and when, if one is suspected.
    suspected: Option<(f64, NodeTime)>,
}

impl ClockSync {
    /// A request if one is due.
    pub fn poll(&mut self, now: NodeTime, rate_hz: f64, simulated: bool, target: (u8, u8)) -> Option<TIMESYNC_DATA> {
        if rate_hz <= 0.0 || now < self.next_request {
            return None;
        }
        let rate_hz = if simulated { rate_hz.max(SIMULATED_HZ) } else { rate_hz };
        let rate_hz = if self.samples < SETTLING_SAMPLES {
            rate_hz.max(SETTLING_HZ)
        } else {
            rate_hz
        };
        self.next_request = now.plus_seconds(1.0 / rate_hz);
        // Zero would mean "not asked".
        let ts1 = nanoseconds(now).max(1);
        self.asked.rotate_left(1);
        self.asked[3] = ts1;
        Some(TIMESYNC_DATA {
            tc1: 0,
            ts1,
            target_system: target.0,
            target_component: target.1,
        })
    }

    /// When the next request is due.
    #[must_use]
    pub fn due(&self) -> NodeTime {
        self.next_request
    }

    /// Takes in an answer; anything else is passed over. Gives by how much the autopilot's clock was found to have stepped, in
    /// seconds, if it was. A step is found with the second answer after it. One that is smaller than half of the round trip cannot
    /// be told from a line that is slower one way than the other.
    pub fn on_answer(&mut self, now: NodeTime, answer: &TIMESYNC_DATA) -> Option<f64> {
        let asked = self
            .asked
            .iter_mut()
            .find(|asked| **asked == answer.ts1 && answer.tc1 > 0 && answer.ts1 > 0)?;
        *asked = 0;
        let round_trip_s = (nanoseconds(now) - answer.ts1) as f64 * 1e-9;
        if !(0.0..=ANSWER_MAX_S).contains(&round_trip_s) {
            return None;
        }
        let usual = self.round_trip_s.unwrap_or(round_trip_s);
        if round_trip_s > usual * OUTLIER_FACTOR + SLACK_S && self.refused < REFUSALS_MAX {
            self.refused += 1;
            return None;
        }
        self.refused = 0;
        self.round_trip_s = Some(usual + ROUND_TRIP_ALPHA * (round_trip_s - usual));
        let middle_ns = answer.ts1 + (nanoseconds(now) - answer.ts1) / 2;
        let measured_s = (answer.tc1 - middle_ns) as f64 * 1e-9;
        match self.look_for_step(now, measured_s, 0.5 * round_trip_s) {
            ClockStep::None => self.update(now, measured_s),
            ClockStep::Suspected => {}
            ClockStep::Made { by_s } => return Some(by_s),
        }
        None
    }

    fn look_for_step(&mut self, now: NodeTime, measured_s: f64, doubt_s: f64) -> ClockStep {
        if self.samples < SETTLING_SAMPLES {
            return ClockStep::None;
        }
        let by_s = measured_s - (self.offset_s + self.drift * now.seconds_since(self.at));
        let is_far = by_s.abs() > JUMP_S + doubt_s;
        let drift = self.drift;
        let agrees = |(suspected_s, at): (f64, NodeTime)| {
            let expected_s = suspected_s + drift * now.seconds_since(at);
            (measured_s - expected_s).abs() <= AGREE_S + doubt_s
        };
        match self.suspected.take() {
            _ if !is_far => ClockStep::None,
            Some(suspected) if agrees(suspected) => {
                // What stood still for a moment goes on at its old pace.
                (self.offset_s, self.at, self.samples) = (measured_s, now, 1);
                ClockStep::Made { by_s }
            }
            _ => {
                self.suspected = Some((measured_s, now));
                self.next_request = self.next_request.min(now.plus_seconds(CONFIRM_S));
                ClockStep::Suspected
            }
        }
    }

    fn update(&mut self, now: NodeTime, measured_s: f64) {
        let elapsed_s = now.seconds_since(self.at);
        let expected_s = self.offset_s + self.drift * elapsed_s;
        if self.samples == 0 || (measured_s - expected_s).abs() > NEW_CLOCK_S {
            self.drift = 0.0;
            self.offset_s = measured_s;
            self.samples = 1;
        } else {
            let error_s = measured_s - expected_s;
            self.samples = self.samples.saturating_add(1);
            let (alpha, beta) = gains(self.samples);
            self.offset_s = expected_s + alpha * error_s;
            if elapsed_s > 0.05 {
                self.drift = (self.drift + beta * error_s / elapsed_s).clamp(-DRIFT_MAX, DRIFT_MAX);
            }
        }
        self.at = now;
    }

    /// Autopilot time minus node time in seconds, as expected now.
    #[must_use]
    pub fn offset_s(&self, now: NodeTime) -> Option<f64> {
        (self.samples > 0).then(|| self.offset_s + self.drift * now.seconds_since(self.at))
    }

    /// Round trip in seconds, smoothed.
    #[must_use]
    pub fn round_trip_s(&self) -> Option<f64> {
        self.round_trip_s
    }

    /// Node time of a stamp of the autopilot, if the offset is known and the result makes sense for something just heard.
    #[must_use]
    pub fn node_time(&self, now: NodeTime, stamp_ms: u32) -> Option<NodeTime> {
        let measured_s = f64::from(stamp_ms) * 1e-3 - self.offset_s(now)?;
        let age_s = now.as_seconds() - measured_s;
        (-0.1..=1.0)
            .contains(&age_s)
            .then(|| NodeTime::from_seconds(measured_s).min(now))
    }
}

/// Of the straight line through `samples` evenly spaced ones, until the filter's own are greater.
fn gains(samples: u32) -> (f64, f64) {
    let n = f64::from(samples);
    let line = n * (n + 1.0);
    (
        (2.0 * (2.0 * n - 1.0) / line).clamp(ALPHA, 1.0),
        (6.0 / line).clamp(BETA, 1.0),
    )
}

fn nanoseconds(time: NodeTime) -> i64 {
    i64::try_from(time.0).unwrap_or(i64::MAX / 1000).saturating_mul(1000)
}

#[cfg(test)]
mod tests {
    //! Offset, drift, outliers and answers that are not ours.

    use super::*;

    /// Exchanges TIMESYNC for `seconds` with an autopilot whose clock is `offset_s` ahead and runs at `rate`.
    fn exchange(
        sync: &mut ClockSync,
        from_s: f64,
        seconds: f64,
        offset_s: f64,
        rate: f64,
        delay_s: impl Fn(u32) -> f64,
    ) {
        let mut t = from_s;
        let mut count = 0;
        while t < from_s + seconds {
            let now = NodeTime::from_seconds(t);
            if let Some(request) = sync.poll(now, 1.0, false, (1, 1)) {
                let delay = delay_s(count);
                count += 1;
                let tc1 = (((t + delay / 2.0) * rate + offset_s) * 1e9) as i64;
                sync.on_answer(now.plus_seconds(delay), &TIMESYNC_DATA { tc1, ..request });
            }
            t += 0.02;
        }
    }

    #[test]
    fn a_steady_clock_is_found_within_a_millisecond() {
        let mut sync = ClockSync::default();
        assert_eq!(sync.offset_s(NodeTime::from_seconds(1.0)), None);
        exchange(&mut sync, 10.0, 10.0, 55.0, 1.0, |i| 0.004 + 0.002 * f64::from(i % 3));
        let now = NodeTime::from_seconds(20.0);
        assert!((sync.offset_s(now).unwrap() - 55.0).abs() < 0.001);
        assert!((sync.round_trip_s().unwrap() - 0.006).abs() < 0.002);
        let measured = sync.node_time(now, 74_950).unwrap();
        assert!((measured.as_seconds() - 19.95).abs() < 0.001);
        assert_eq!(
            sync.node_time(now, 60_000),
            None,
            "fifteen seconds ago is no stamp of something just heard"
        );
    }

    #[test]
    fn a_clock_two_percent_slow_leaves_no_lag() {
        let mut sync = ClockSync::default();
        exchange(&mut sync, 10.0, 60.0, 5.0, 0.98, |_| 0.005);
        let now = NodeTime::from_seconds(70.0);
        let truth = 70.0 * 0.98 + 5.0 - 70.0;
        assert!(
            (sync.offset_s(now).unwrap() - truth).abs() < 0.003,
            "{:?} {truth}",
            sync.offset_s(now)
        );
    }

    #[test]
    fn a_pace_of_half_or_one_and_a_half_is_followed_and_is_no_step() {
        for rate in [0.5, 1.5] {
            let mut sync = ClockSync::default();
            let mut t = 10.0;
            let mut steps = 0;
            while t < 30.0 {
                let now = NodeTime::from_seconds(t);
                if let Some(request) = sync.poll(now, 1.0, true, (1, 1)) {
                    let tc1 = (((t + 0.002) * rate + 5.0) * 1e9) as i64;
                    let answer = TIMESYNC_DATA { tc1, ..request };
                    steps += u32::from(sync.on_answer(now.plus_seconds(0.004), &answer).is_some());
                    let truth_s = (t + 0.002) * rate + 5.0 - (t + 0.002);
                    let found_s = sync.offset_s(now).unwrap();
                    assert!(
                        t < 10.5 || (found_s - truth_s).abs() < 0.01,
                        "{found_s} for {truth_s} at {t}"
                    );
                }
                t += 0.02;
            }
            assert_eq!(steps, 0);
        }
    }

    #[test]
    fn a_pace_that_changes_is_found_again_and_a_stall_leaves_the_pace() {
        let mut sync = ClockSync::default();
        exchange(&mut sync, 10.0, 20.0, 5.0, 0.98, |_| 0.004);
        // It stood still for 0.3 s, and goes on at its old pace.
        let offset_s = 5.0 - 0.3 + 30.0 * 0.98 - 30.0;
        let mut stepped = None;
        for i in 0..10 {
            let t = 30.0 + 0.21 * f64::from(i);
            let there_s = offset_s - 0.02 * (t - 30.0);
            stepped = once(&mut sync, t, there_s, 0.002, 0.002).or(stepped);
        }
        assert!((stepped.expect("told") + 0.3).abs() < 0.02, "{stepped:?}");
        let now = NodeTime::from_seconds(33.0);
        let truth_s = offset_s - 0.02 * 3.0;
        assert!((sync.offset_s(now).unwrap() - truth_s).abs() < 0.01);
    }

    #[test]
    fn slow_answers_do_not_move_the_offset_and_a_line_slow_for_good_is_followed() {
        let mut sync = ClockSync::default();
        exchange(&mut sync, 10.0, 20.0, 5.0, 1.0, |_| 0.004);
        // One answer in ten sits 300 ms in a queue on its way back: halving the round trip would be wrong by 150 ms.
        let mut t = 30.0;
        for i in 0..30 {
            let now = NodeTime::from_seconds(t);
            if let Some(request) = sync.poll(now, 1.0, false, (1, 1)) {
                let tc1 = ((t + 0.002 + 5.0) * 1e9) as i64;
                let delay = if i % 10 == 0 { 0.3 } else { 0.004 };
                sync.on_answer(now.plus_seconds(delay), &TIMESYNC_DATA { tc1, ..request });
            }
            t += 1.0;
        }
        assert!((sync.offset_s(NodeTime::from_seconds(t)).unwrap() - 5.0).abs() < 0.001);
        exchange(&mut sync, 100.0, 60.0, 5.0, 1.0, |_| 0.4);
        assert!(sync.round_trip_s().unwrap() > 0.3);
    }

    /// Exchanges one TIMESYNC at `t` with an autopilot whose clock is `offset_s` ahead; the way there takes `there_s`.
    fn once(sync: &mut ClockSync, t: f64, offset_s: f64, there_s: f64, back_s: f64) -> Option<f64> {
        let request = sync.poll(NodeTime::from_seconds(t), 1.0, false, (1, 1))?;
        let tc1 = ((t + there_s + offset_s) * 1e9) as i64;
        sync.on_answer(
            NodeTime::from_seconds(t + there_s + back_s),
            &TIMESYNC_DATA { tc1, ..request },
        )
    }

    #[test]
    fn a_step_is_told_once_it_was_seen_twice_and_a_single_late_stamp_is_none() {
        let mut sync = ClockSync::default();
        exchange(&mut sync, 10.0, 20.0, 5.0, 1.0, |_| 0.004);
        // Sim or autopilot stood still for a moment: one stamp is behind.
        assert_eq!(once(&mut sync, 31.0, 4.8, 0.002, 0.002), None);
        assert_eq!(once(&mut sync, 31.2, 5.0, 0.002, 0.002), None);
        for (t, step_s) in [(35.0, 0.08), (45.0, -0.6), (55.0, 30.0)] {
            let offset_s = sync.offset_s(NodeTime::from_seconds(t)).unwrap() + step_s;
            assert_eq!(once(&mut sync, t, offset_s, 0.002, 0.002), None, "not sure yet");
            let by_s = once(&mut sync, t + 0.11, offset_s, 0.002, 0.002).expect("asked again soon, and sure");
            assert!((by_s - step_s).abs() < 0.005, "{by_s} for {step_s}");
            for i in 1..30 {
                assert_eq!(
                    once(&mut sync, t + 0.11 + 0.25 * f64::from(i), offset_s, 0.002, 0.002),
                    None
                );
            }
            let now = NodeTime::from_seconds(t + 8.0);
            assert!((sync.offset_s(now).unwrap() - offset_s).abs() < 0.002);
        }
    }

    #[test]
    fn a_line_that_is_slow_one_way_is_no_step() {
        let mut sync = ClockSync::default();
        exchange(&mut sync, 10.0, 20.0, 5.0, 1.0, |_| 0.4);
        for i in 0..10 {
            assert_eq!(once(&mut sync, 31.0 + f64::from(i), 5.0, 0.01, 0.39), None);
        }
    }

    #[test]
    fn answers_that_are_not_ours_are_passed_over() {
        let mut sync = ClockSync::default();
        let now = NodeTime::from_seconds(3.0);
        let request = sync.poll(now, 1.0, false, (1, 1)).unwrap();
        sync.on_answer(now, &TIMESYNC_DATA { tc1: 0, ..request });
        sync.on_answer(
            now,
            &TIMESYNC_DATA {
                tc1: 7,
                ts1: request.ts1 + 1,
                ..request
            },
        );
        sync.on_answer(
            now,
            &TIMESYNC_DATA {
                tc1: 7,
                ts1: 0,
                ..request
            },
        );
        assert_eq!(sync.offset_s(now), None);
        sync.on_answer(
            now,
            &TIMESYNC_DATA {
                tc1: 7_000_000_000,
                ..request
            },
        );
        assert!(sync.offset_s(now).is_some());
    }
}
