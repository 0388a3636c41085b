//! The figures of ROS 2 and DDS, units in the names; as a table.

use super::cost::{CostFigures, Shown};
use super::marks::Marked;
use super::peers::Asked;
use crate::gaps::percentile_ms;
use crate::program::VehicleLink;
use serde::Serialize;
use std::fmt;

/// One latency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Latency {
    /// From what to what.
    pub what: &'static str,
    /// How often it was taken.
    pub samples: usize,
    /// The median in milliseconds.
    pub p50_ms: f64,
    /// What one in a hundred takes longer than, in milliseconds.
    pub p99_ms: f64,
    /// Which of them it is a multiple of; none for those that others are compared with.
    pub beside: Option<&'static str>,
    /// The median as a multiple of that one's.
    pub p50_ratio: Option<f64>,
    /// The 99th percentile as a multiple of that one's.
    pub p99_ratio: Option<f64>,
}

impl Latency {
    fn of(what: &'static str, mut times_us: Vec<u32>) -> Self {
        times_us.sort_unstable();
        Self {
            what,
            samples: times_us.len(),
            p50_ms: percentile_ms(&times_us, 0.5),
            p99_ms: percentile_ms(&times_us, 0.99),
            beside: None,
            p50_ratio: None,
            p99_ratio: None,
        }
    }

    fn beside(self, other: &Self) -> Self {
        let ratio = |of: f64, to: f64| (to > 0.0 && self.samples > 0).then(|| of / to);
        Self {
            beside: Some(other.what),
            p50_ratio: ratio(self.p50_ms, other.p50_ms),
            p99_ratio: ratio(self.p99_ms, other.p99_ms),
            ..self
        }
    }
}

/// All latencies of a window: each of Skein's after that of rclpy which it is a multiple of.
pub(crate) fn latencies(asked: &Asked, marked: &Marked) -> Vec<Latency> {
    let one_way = Latency::of("rclpy > rclpy", asked.one_way_us.clone());
    let there_and_back = Latency::of("rclpy > rclpy > rclpy", asked.there_and_back_us.clone());
    let by_timer = Latency::of("the same, answered by a 50 Hz timer", asked.by_timer_us.clone());
    let call = Latency::of("call rclpy > rclpy > rclpy", asked.rclpy_call_us.clone());
    let ages = asked.pose_age_us.iter();
    let ages = ages
        .map(|age| u32::try_from((*age).max(0)).unwrap_or(u32::MAX))
        .collect();
    let pose = Latency::of("PX4's position > Skein > rclpy", ages).beside(&one_way);
    let hold = Latency::of("call rclpy > Skein > rclpy: hold", asked.skein_call_us.clone()).beside(&call);
    let reactions = marked.reactions_us.clone();
    let reaction = Latency::of("PX4's position > Skein > PX4's setpoint", reactions.clone()).beside(&there_and_back);
    let reaction_by_timer = Latency::of("  beside the 50 Hz timer", reactions).beside(&by_timer);
    let poses = Latency::of("between two poses", asked.pose_every_us.clone());
    let setpoints = Latency::of("between two setpoints", marked.intervals_us.clone());
    vec![
        one_way,
        there_and_back,
        by_timer,
        call,
        pose,
        hold,
        reaction,
        reaction_by_timer,
        poses,
        setpoints,
    ]
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ros2BenchReport {
    /// Length of the window of latencies.
    pub seconds: u32,
    /// Processors of the machine.
    pub processors: usize,
    /// Those of rclpy alone, then those through Skein.
    pub latencies: Vec<Latency>,
    /// Calls that Skein refused.
    pub refused: usize,
    /// Calls that nobody answered.
    pub unanswered: usize,
    /// Questions of rclpy to rclpy that got no answer at once.
    pub lost_questions: usize,
    /// Marks that showed in no setpoint within a second.
    pub lost_marks: usize,
    /// Processor time of the whole machine in that window, 100 = one core.
    pub busy_percent: f64,
    /// What the program takes.
    pub costs: Vec<CostFigures>,
}

impl Ros2BenchReport {
    /// The same vehicles without ROS 2.
    fn without(&self, of: &CostFigures) -> Option<&CostFigures> {
        let same =
            |other: &&CostFigures| (other.link, other.vehicles, other.ros2) == (of.link, of.vehicles, Shown::Off);
        self.costs.iter().find(same)
    }
}

impl fmt::Display for Ros2BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "ROS 2 (Jazzy, Fast DDS), loopback, {} s, {} processors of which {:.0} % of one were busy",
            self.seconds, self.processors, self.busy_percent
        )?;
        writeln!(
            f,
            "{:<42} {:>7} {:>9} {:>9}   {:>6} {:>6}   of rclpy beside rclpy",
            "latency", "samples", "p50 ms", "p99 ms", "p50", "p99"
        )?;
        let times = |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}x"));
        for of in &self.latencies {
            writeln!(
                f,
                "{:<42} {:>7} {:>9.2} {:>9.2}   {:>6} {:>6}   {}",
                of.what,
                of.samples,
                of.p50_ms,
                of.p99_ms,
                times(of.p50_ratio),
                times(of.p99_ratio),
                of.beside.unwrap_or_default()
            )?;
        }
        writeln!(
            f,
            "{} calls refused, {} not answered; {} questions of rclpy to rclpy lost; {} marks not seen in a setpoint",
            self.refused, self.unanswered, self.lost_questions, self.lost_marks
        )?;
        writeln!(
            f,
            "\n{:<8} {:>8} {:<8} {:>12} {:>9} {:>8} {:>10} {:>8} {:>8}   (without ROS 2 = 1)",
            "link", "vehicles", "ROS 2", "% of a core", "MiB", "threads", "poses/s", "CPU", "memory"
        )?;
        for of in &self.costs {
            let without = self.without(of).filter(|_| of.ros2 != Shown::Off);
            let link = match of.link {
                VehicleLink::Mavlink => "MAVLink",
                VehicleLink::Dds => "DDS",
            };
            let shown = match of.ros2 {
                Shown::Off => "off",
                Shown::Unheard => "unheard",
                Shown::Heard => "heard",
            };
            writeln!(
                f,
                "{link:<8} {:>8} {shown:<8} {:>12.1} {:>9.1} {:>8} {:>10} {:>8} {:>8}",
                of.vehicles,
                of.cpu_percent,
                of.rss_mib,
                of.threads,
                of.poses_hz.map_or("-".to_owned(), |hz| format!("{hz:.1}")),
                times(without.map(|without| of.cpu_percent / without.cpu_percent.max(0.1))),
                times(without.map(|without| of.rss_mib / without.rss_mib.max(0.1)))
            )?;
        }
        Ok(())
    }
}
