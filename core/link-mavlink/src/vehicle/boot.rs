//! The autopilot's boot time as its stamps tell it: whether it restarted, and whether two autopilots speak at once.
//!
//! One stamp out of line is a late frame; two in a row on a new line are a restart; coming back to the old line after that
//! are two autopilots behind one address.

use skein_domain::NodeTime;

/// A stamp this much behind the newest one is not merely late, in milliseconds.
const BACK_JUMP_MS: i64 = 2_000;
/// How near a stamp must be to where a line of stamps should be by now to belong to it, in milliseconds.
const SAME_LINE_MS: i64 = 1_500;
/// How long the line before a restart is remembered, in seconds.
const REMEMBER_S: f64 = 5.0;

/// What a stamp means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stamp {
    /// It continues the boot we know.
    Fresh,
    /// Not clear yet, or late: do not use the message.
    Doubtful,
    /// The autopilot has restarted; the message is of the new boot.
    Rebooted,
    /// The boot we thought gone goes on: two autopilots are heard.
    Interleaved,
}

/// A line of stamps: the newest, and when it was heard.
#[derive(Debug, Clone, Copy)]
struct Line {
    stamp_ms: u32,
    heard: NodeTime,
}

impl Line {
    /// How far `stamp_ms` is ahead of where this line's newest was; right across the wrap after 49 days.
    fn ahead_ms(&self, stamp_ms: u32) -> i64 {
        i64::from(stamp_ms.wrapping_sub(self.stamp_ms).cast_signed())
    }

    /// Whether `stamp_ms`, heard now, fits where this line should be by now.
    fn continues(&self, stamp_ms: u32, now: NodeTime) -> bool {
        let elapsed_ms = (now.seconds_since(self.heard) * 1e3) as i64;
        (self.ahead_ms(stamp_ms) - elapsed_ms).abs() <= SAME_LINE_MS
    }
}

/// A line of stamps that does not fit the present one.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    line: Line,
    /// Stamps on it since it was first seen, and in a row.
    seen: u32,
    in_a_row: u32,
    /// Stamps on the present line since then.
    present: u32,
}

/// Watches the stamps of one vehicle.
#[derive(Debug, Default)]
pub struct BootWatch {
    current: Option<Line>,
    candidate: Option<Candidate>,
    /// The line before the last restart.
    previous: Option<Line>,
}

impl BootWatch {
    /// Judges the stamp of a message that was just heard.
    pub fn judge(&mut self, now: NodeTime, stamp_ms: u32) -> Stamp {
        let line = Line { stamp_ms, heard: now };
        let Some(current) = &mut self.current else {
            self.current = Some(line);
            return Stamp::Fresh;
        };
        let ahead_ms = current.ahead_ms(stamp_ms);
        if ahead_ms < -BACK_JUMP_MS {
            return self.back_jump(now, line);
        }
        if let Some(previous) = self.previous {
            if now.seconds_since(previous.heard) > REMEMBER_S {
                self.previous = None;
            } else if ahead_ms > SAME_LINE_MS && previous.continues(stamp_ms, now) {
                self.previous = self.current.replace(line);
                self.candidate = None;
                return Stamp::Interleaved;
            }
        }
        if ahead_ms >= 0 {
            *current = line;
        }
        if let Some(candidate) = &mut self.candidate {
            candidate.present += 1;
            candidate.in_a_row = 0;
        }
        Stamp::Fresh
    }

    fn back_jump(&mut self, now: NodeTime, line: Line) -> Stamp {
        let candidate = match &mut self.candidate {
            Some(candidate) if candidate.line.continues(line.stamp_ms, now) => candidate,
            none_or_other => {
                *none_or_other = Some(Candidate {
                    line,
                    seen: 1,
                    in_a_row: 1,
                    present: 0,
                });
                return Stamp::Doubtful;
            }
        };
        candidate.line = line;
        candidate.seen += 1;
        candidate.in_a_row += 1;
        if candidate.in_a_row < 2 {
            // Both lines go on, one frame each in turn.
            return if candidate.seen > 2 && candidate.present > 2 {
                Stamp::Interleaved
            } else {
                Stamp::Doubtful
            };
        }
        let interleaved = self
            .previous
            .is_some_and(|previous| previous.continues(line.stamp_ms, now));
        self.previous = self.current.replace(line);
        self.candidate = None;
        if interleaved {
            Stamp::Interleaved
        } else {
            Stamp::Rebooted
        }
    }
}

#[cfg(test)]
mod tests {
    //! Restarts, late frames, the wrap and two autopilots at once.

    use super::*;

    fn at(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    #[test]
    fn a_late_frame_is_no_restart() {
        let mut boot = BootWatch::default();
        for i in 0..100_u32 {
            assert_eq!(boot.judge(at(f64::from(i) * 0.02), 60_000 + i * 20), Stamp::Fresh);
        }
        assert_eq!(boot.judge(at(2.0), 61_500), Stamp::Fresh, "slightly late");
        assert_eq!(boot.judge(at(2.0), 55_000), Stamp::Doubtful, "very late");
        assert_eq!(boot.judge(at(2.02), 62_000), Stamp::Fresh);
        assert_eq!(boot.current.map(|line| line.stamp_ms), Some(62_000));
    }

    #[test]
    fn two_frames_of_a_new_boot_are_a_restart() {
        let mut boot = BootWatch::default();
        assert_eq!(boot.judge(at(0.0), 60_000), Stamp::Fresh);
        assert_eq!(boot.judge(at(3.0), 900), Stamp::Doubtful);
        assert_eq!(boot.judge(at(3.02), 920), Stamp::Rebooted);
        assert_eq!(boot.judge(at(3.04), 940), Stamp::Fresh);
        assert_eq!(boot.judge(at(20.0), 17_900), Stamp::Fresh, "no echo of the old boot");
    }

    #[test]
    fn the_wrap_after_49_days_is_no_restart() {
        let mut boot = BootWatch::default();
        assert_eq!(boot.judge(at(0.0), u32::MAX - 5), Stamp::Fresh);
        assert_eq!(boot.judge(at(0.02), 14), Stamp::Fresh);
        assert_eq!(boot.current.map(|line| line.stamp_ms), Some(14));
    }

    #[test]
    fn two_autopilots_at_once_are_told_from_a_restart() {
        let mut boot = BootWatch::default();
        let mut seen = Vec::new();
        for i in 0..60_u32 {
            let now = at(f64::from(i) * 0.02);
            // Two frames each in turn, as two vehicles on one line would give.
            let stamp_ms = if i / 2 % 2 == 0 { 100_000 } else { 5_000 } + i * 20;
            seen.push(boot.judge(now, stamp_ms));
        }
        assert!(seen.contains(&Stamp::Interleaved), "{seen:?}");
        let restarts = seen.iter().filter(|&&stamp| stamp == Stamp::Rebooted).count();
        assert!(restarts <= 1, "{seen:?}");

        let mut boot = BootWatch::default();
        let mut seen = Vec::new();
        for i in 0..60_u32 {
            let stamp_ms = if i % 2 == 0 { 100_000 } else { 5_000 } + i * 20;
            seen.push(boot.judge(at(f64::from(i) * 0.02), stamp_ms));
        }
        assert!(
            seen.contains(&Stamp::Interleaved) && !seen.contains(&Stamp::Rebooted),
            "one each: {seen:?}"
        );
    }
}
