//! The figures of a bench, units in the names; as JSON and as a table.

use crate::process::Scheduling;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Time between two setpoints of a vehicle, over all vehicles of a window.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Gaps {
    /// Half of all gaps are no longer.
    pub p50_ms: f64,
    /// 99 % are no longer.
    pub p99_ms: f64,
    /// 99.9 % are no longer.
    pub p99_9_ms: f64,
    /// The longest.
    pub max_ms: f64,
    /// How many were over 60 ms.
    pub over_60_ms: usize,
    /// The largest 99th percentile of any single vehicle.
    pub worst_vehicle_p99_ms: f64,
}

/// What the load generator saw in one window.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LoadFigures {
    /// Length of the window.
    pub window_s: f64,
    /// Telemetry messages sent per second and vehicle.
    pub telemetry_hz_per_vehicle: f64,
    /// Setpoints received per second and vehicle.
    pub setpoint_hz_per_vehicle: f64,
    /// Vehicles that got setpoints at all.
    pub vehicles_streaming: usize,
    /// Messages that came to a vehicle but were addressed to another.
    pub misaddressed: u64,
    /// Messages the system did not take.
    pub not_sent: u64,
    /// Share of the 1 ms ticks that came more than 1 ms late (what was due was sent at once then).
    pub late_ticks_percent: f64,
    /// Gaps between setpoints.
    pub gaps: Gaps,
}

/// One window of one side.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WindowFigures {
    /// Processor time over the window, 100 = one core.
    pub cpu_percent: f64,
    /// Resident memory at the window's end.
    pub rss_mib: f64,
    /// Threads at the window's end.
    pub threads: u32,
    /// Processor time of the load generator.
    pub generator_cpu_percent: f64,
    /// What was recorded in the window, in bytes per second and vehicle.
    pub recorded_bytes_per_s_per_vehicle: f64,
    /// Processor time of everything else on the machine.
    pub other_cpu_percent: f64,
    /// Datagrams that the system dropped because a receive buffer was full, on the whole machine.
    pub dropped_datagrams: u64,
    /// What the load generator saw.
    pub load: LoadFigures,
}

/// Smallest, median and largest value over the windows.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// Smallest.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of these values; all zero for none.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else {
            return Self::default();
        };
        let at = |index: usize| sorted.get(index).copied().unwrap_or(min);
        let median = 0.5 * (at((sorted.len() - 1) / 2) + at(sorted.len() / 2));
        Self { min, median, max }
    }
}

/// One side over all its windows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SideFigures {
    /// Processor time, 100 = one core.
    pub cpu_percent: Spread,
    /// The same per vehicle.
    pub cpu_percent_per_vehicle: Spread,
    /// Resident memory.
    pub rss_mib: Spread,
    /// The same per vehicle.
    pub rss_mib_per_vehicle: f64,
    /// Setpoints per second and vehicle.
    pub setpoint_hz_per_vehicle: Spread,
    /// 99th percentile of the gaps between setpoints.
    pub gap_p99_ms: Spread,
    /// 99.9th percentile.
    pub gap_p99_9_ms: Spread,
    /// Longest gap.
    pub gap_max_ms: Spread,
    /// Gaps over 60 ms in all windows.
    pub gaps_over_60_ms: usize,
    /// Every window.
    pub windows: Vec<WindowFigures>,
}

impl SideFigures {
    /// Of these windows with so many vehicles.
    #[must_use]
    pub fn of(windows: Vec<WindowFigures>, vehicles: u16) -> Self {
        let spread = |value: fn(&WindowFigures) -> f64| Spread::of(windows.iter().map(value));
        let count = f64::from(vehicles.max(1));
        let cpu = spread(|w| w.cpu_percent);
        let rss_mib = spread(|w| w.rss_mib);
        Self {
            cpu_percent: cpu,
            cpu_percent_per_vehicle: Spread {
                min: cpu.min / count,
                median: cpu.median / count,
                max: cpu.max / count,
            },
            rss_mib,
            rss_mib_per_vehicle: rss_mib.median / count,
            setpoint_hz_per_vehicle: spread(|w| w.load.setpoint_hz_per_vehicle),
            gap_p99_ms: spread(|w| w.load.gaps.p99_ms),
            gap_p99_9_ms: spread(|w| w.load.gaps.p99_9_ms),
            gap_max_ms: spread(|w| w.load.gaps.max_ms),
            gaps_over_60_ms: windows.iter().map(|w| w.load.gaps.over_60_ms).sum(),
            windows,
        }
    }
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FleetBenchReport {
    /// How many vehicles.
    pub vehicles: u16,
    /// Length of each window.
    pub window_s: f64,
    /// Processors of the machine.
    pub processors: usize,
    /// How all processes were scheduled.
    pub scheduling: Scheduling,
    /// The program.
    pub program: SideFigures,
    /// The program while it records.
    pub recording: SideFigures,
    /// The bare loop.
    pub bare: SideFigures,
    /// Processor time of the program while it records over that without, by the medians.
    pub recording_cpu_ratio: f64,
    /// What it records, in bytes per second and vehicle.
    pub recorded_bytes_per_s_per_vehicle: Spread,
    /// Processor time of the program over that of the bare loop, by the medians.
    pub cpu_ratio: f64,
    /// The same per pair of windows.
    pub cpu_ratio_of_rounds: Spread,
}

impl FleetBenchReport {
    /// From the windows of all sides in the order in which they were taken.
    #[must_use]
    pub fn of(
        vehicles: u16,
        window_s: f64,
        program: Vec<WindowFigures>,
        recording: Vec<WindowFigures>,
        bare: Vec<WindowFigures>,
    ) -> Self {
        let ratio = |of: f64, to: f64| if to > 0.0 { of / to } else { 0.0 };
        let rounds = program
            .iter()
            .zip(&bare)
            .map(|(p, b)| ratio(p.cpu_percent, b.cpu_percent));
        let cpu_ratio_of_rounds = Spread::of(rounds.collect::<Vec<_>>());
        let recorded = recording.iter().map(|window| window.recorded_bytes_per_s_per_vehicle);
        let recorded = Spread::of(recorded.collect::<Vec<_>>());
        let (program, bare) = (SideFigures::of(program, vehicles), SideFigures::of(bare, vehicles));
        let recording = SideFigures::of(recording, vehicles);
        Self {
            vehicles,
            window_s,
            processors: std::thread::available_parallelism().map_or(0, usize::from),
            scheduling: Scheduling::default(),
            cpu_ratio: ratio(program.cpu_percent.median, bare.cpu_percent.median),
            cpu_ratio_of_rounds,
            recording_cpu_ratio: ratio(recording.cpu_percent.median, program.cpu_percent.median),
            recorded_bytes_per_s_per_vehicle: recorded,
            recording,
            program,
            bare,
        }
    }
}

impl fmt::Display for FleetBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounds = self.program.windows.len();
        writeln!(
            f,
            "{} vehicles, 115 telemetry messages/s in and 50 setpoints/s out each; {rounds} x {:.0} s a side, {} processors",
            self.vehicles, self.window_s, self.processors
        )?;
        writeln!(
            f,
            "{:<34} {:>24} {:>24} {:>24}",
            "median [smallest .. largest]", "program", "while it records", "bare loop"
        )?;
        let mut row = |name: &str, pick: fn(&SideFigures) -> Spread, digits: usize| {
            let cell = |side: &SideFigures| {
                let Spread { min, median, max } = pick(side);
                format!("{median:.digits$} [{min:.digits$} .. {max:.digits$}]")
            };
            writeln!(
                f,
                "{name:<34} {:>24} {:>24} {:>24}",
                cell(&self.program),
                cell(&self.recording),
                cell(&self.bare)
            )
        };
        row("processor time, % of a core", |s| s.cpu_percent, 1)?;
        row("  per vehicle", |s| s.cpu_percent_per_vehicle, 3)?;
        row("memory, MiB", |s| s.rss_mib, 1)?;
        row("setpoints per second and vehicle", |s| s.setpoint_hz_per_vehicle, 1)?;
        row("setpoint gap p99, ms", |s| s.gap_p99_ms, 1)?;
        row("setpoint gap p99.9, ms", |s| s.gap_p99_9_ms, 1)?;
        row("longest setpoint gap, ms", |s| s.gap_max_ms, 1)?;
        writeln!(
            f,
            "{:<34} {:>24} {:>24} {:>24}",
            "gaps over 60 ms", self.program.gaps_over_60_ms, self.recording.gaps_over_60_ms, self.bare.gaps_over_60_ms
        )?;
        writeln!(
            f,
            "processor time, recording over not: {:.2}; recorded, bytes per second and vehicle: {:.0}",
            self.recording_cpu_ratio, self.recorded_bytes_per_s_per_vehicle.median
        )?;
        let Spread { min, max, .. } = self.cpu_ratio_of_rounds;
        write!(
            f,
            "processor time, program over bare loop: {:.2} [{min:.2} .. {max:.2}]",
            self.cpu_ratio
        )
    }
}
