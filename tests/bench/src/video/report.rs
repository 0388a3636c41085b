//! The figures of the bench of video, units in the names; as JSON and as a table.

use super::Round;
use crate::report::{SideFigures, Spread};
use serde::Serialize;
use std::fmt;

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VideoBenchReport {
    /// Cameras, each on a vehicle in flight; 640x480, 30 pictures and about a megabit a second.
    pub cameras: u16,
    /// Streams that are relayed to viewers, several of one camera counted each.
    pub relayed: u16,
    /// Length of each window.
    pub window_s: f64,
    /// Processors of the machine.
    pub processors: usize,
    /// The flight without cameras.
    pub without: SideFigures,
    /// The same flight with cameras and viewers.
    pub with: SideFigures,
    /// Processor time for video, receiving it among it, for each stream that is relayed; 100 = one core.
    pub cpu_percent_per_relayed: Spread,
    /// The same of `ffmpeg -c copy` from RTP to RTP, one process a stream.
    pub ffmpeg_cpu_percent_per_relayed: Spread,
    /// Ours over FFmpeg's, by the medians.
    pub cpu_ratio: f64,
    /// The same per round.
    pub cpu_ratio_of_rounds: Spread,
    /// Pictures a second and stream, as the viewers counted them.
    pub pictures_hz: Spread,
    /// The longest time without a picture of a stream.
    pub longest_without_picture_ms: Spread,
}

impl VideoBenchReport {
    pub(super) fn of(cameras: u16, relayed: u16, seconds: u32, rounds: &[Round]) -> Self {
        let ours = |round: &Round| (round.with.cpu_percent - round.without.cpu_percent) / f64::from(relayed);
        let theirs = |round: &Round| round.ffmpeg_cpu_percent / f64::from(cameras);
        let ratio = |of: f64, to: f64| if to > 0.0 { of / to } else { 0.0 };
        let cpu = Spread::of(rounds.iter().map(ours));
        let ffmpeg = Spread::of(rounds.iter().map(theirs));
        let viewers = || rounds.iter().flat_map(|round| &round.viewers);
        let side = |pick: fn(&Round) -> crate::report::WindowFigures| {
            SideFigures::of(rounds.iter().map(pick).collect(), cameras)
        };
        Self {
            cameras,
            relayed,
            window_s: f64::from(seconds),
            processors: std::thread::available_parallelism().map_or(0, usize::from),
            without: side(|round| round.without),
            with: side(|round| round.with),
            cpu_percent_per_relayed: cpu,
            ffmpeg_cpu_percent_per_relayed: ffmpeg,
            cpu_ratio: ratio(cpu.median, ffmpeg.median),
            cpu_ratio_of_rounds: Spread::of(rounds.iter().map(|round| ratio(ours(round), theirs(round)))),
            pictures_hz: Spread::of(viewers().flat_map(|viewer| viewer.rates_hz.clone())),
            longest_without_picture_ms: Spread::of(viewers().map(|viewer| viewer.longest_gap_ms)),
        }
    }
}

impl fmt::Display for VideoBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cell = |Spread { min, median, max }: Spread, digits: usize| {
            format!("{median:.digits$} [{min:.digits$} .. {max:.digits$}]")
        };
        writeln!(
            f,
            "{} cameras over RTP, {} streams to two viewers, {} vehicles in flight; {} x {:.0} s, {} processors",
            self.cameras,
            self.relayed,
            self.cameras,
            self.with.windows.len(),
            self.window_s,
            self.processors
        )?;
        writeln!(
            f,
            "{:<34} {:>24} {:>24}",
            "median [smallest .. largest]", "with video", "without"
        )?;
        let mut row = |name: &str, pick: fn(&SideFigures) -> Spread, digits: usize| {
            let (with, without) = (cell(pick(&self.with), digits), cell(pick(&self.without), digits));
            writeln!(f, "{name:<34} {with:>24} {without:>24}")
        };
        row("processor time, % of a core", |s| s.cpu_percent, 1)?;
        row("memory, MiB", |s| s.rss_mib, 1)?;
        row("setpoint gap p99, ms", |s| s.gap_p99_ms, 1)?;
        row("longest setpoint gap, ms", |s| s.gap_max_ms, 1)?;
        writeln!(
            f,
            "{:<34} {:>24} {:>24}",
            "gaps over 60 ms", self.with.gaps_over_60_ms, self.without.gaps_over_60_ms
        )?;
        writeln!(f, "pictures a second and stream: {}", cell(self.pictures_hz, 1))?;
        let longest = cell(self.longest_without_picture_ms, 0);
        writeln!(f, "longest time without a picture, ms: {longest}")?;
        writeln!(
            f,
            "processor time per relayed stream, % of a core: {}; ffmpeg -c copy from RTP to RTP: {}",
            cell(self.cpu_percent_per_relayed, 2),
            cell(self.ffmpeg_cpu_percent_per_relayed, 2)
        )?;
        let rounds = self.cpu_ratio_of_rounds;
        write!(
            f,
            "ours over ffmpeg's: {:.2} [{:.2} .. {:.2}]",
            self.cpu_ratio, rounds.min, rounds.max
        )
    }
}
