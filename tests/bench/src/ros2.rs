//! What ROS 2 and DDS cost: latencies between real rclpy programs, through Skein, and from PX4's side of DDS to a setpoint, all in one run at the same time;
//! processor time and memory of the program with and without ROS 2.
//!
//! Must never do: judge. Times hang on the machine; the ratios to rclpy beside rclpy in the same run say more.

use crate::error::BenchError;
use crate::process::{Machine, Scheduling};
use crate::program::{Program, Setup, VehicleLink};
use cost::Costs;
use marks::Marked;
use peers::{Asked, Ros2Python};
use px4_side::Px4Side;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

mod cost;
mod marks;
mod peers;
mod px4_side;
mod report;

pub use cost::{CostFigures, Shown};
pub use report::{Latency, Ros2BenchReport};

/// Vehicles over DDS while latencies are measured: the first one's samples are marked, the second one is commanded and looked at.
const VEHICLES: u16 = 2;
const COMMANDED: &str = "uav_2";
/// How long everything runs undisturbed before a window.
const SETTLE: Duration = Duration::from_secs(3);

/// What to run.
#[derive(Debug, Clone, PartialEq)]
pub struct Ros2BenchArgs {
    /// A Python with rclpy, in a virtual environment as `tests/interop` makes it.
    pub python: PathBuf,
    /// Length of the window of latencies in seconds; costs take a third of it each.
    pub seconds: u32,
    /// How many vehicles costs are measured with, over MAVLink.
    pub vehicles: Vec<u16>,
    /// And over DDS.
    pub dds_vehicles: Vec<u16>,
    /// The program under test.
    pub program: PathBuf,
    /// Where its plugins are.
    pub plugins: PathBuf,
    /// The program with the command `bench load-generator`.
    pub helper: PathBuf,
}

impl Ros2BenchArgs {
    /// With a program that is its own helper and has its plugins beside it.
    #[must_use]
    pub fn new(python: PathBuf, seconds: u32, program: PathBuf) -> Self {
        Self {
            python,
            seconds,
            vehicles: vec![1, 10, 50],
            dds_vehicles: vec![1, 10],
            plugins: program.parent().unwrap_or(Path::new(".")).join("plugins"),
            helper: program.clone(),
            program,
        }
    }

    fn setup(&self, link: VehicleLink, dds_domain: u16, ros2: bool) -> Setup<'_> {
        Setup {
            link,
            dds_domain,
            ros2,
            ..Setup::plain(&self.program, &self.plugins, Scheduling::Ordinary)
        }
    }
}

/// One that no other part of this run has: what has ended in a domain is remembered there for a minute. Also hardly one of another run.
fn fresh_domain() -> u16 {
    static GIVEN: AtomicU16 = AtomicU16::new(0);
    let number = std::process::id() % 100 + u32::from(GIVEN.fetch_add(1, Ordering::Relaxed));
    u16::try_from(number % 100).unwrap_or_default() + 1
}

/// Runs the bench. Progress goes to standard error.
///
/// # Errors
/// When a child process cannot be started, ends, or does not find the others, or the vehicles do not get into the air.
pub fn run_ros2_bench(args: &Ros2BenchArgs) -> Result<Ros2BenchReport, BenchError> {
    if args.seconds < 3 {
        return Err(BenchError::Argument(
            "a window of at least three seconds is needed".to_owned(),
        ));
    }
    let ros2 = Ros2Python::at(&args.python)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    runtime.block_on(async {
        let window = latencies(args, &ros2).await?;
        let costs = Costs::new(args, &ros2).measure().await?;
        Ok(Ros2BenchReport {
            seconds: args.seconds,
            processors: std::thread::available_parallelism().map_or(0, usize::from),
            latencies: report::latencies(&window.asked, &window.marked),
            refused: window.asked.refused,
            unanswered: window.asked.unanswered,
            lost_questions: window
                .asked
                .questions
                .saturating_sub(window.asked.there_and_back_us.len()),
            lost_marks: window.marked.lost,
            busy_percent: window.busy_percent,
            costs,
        })
    })
}

/// What the window of latencies held.
struct Window {
    asked: Asked,
    marked: Marked,
    busy_percent: f64,
}

/// All latencies at once, under the same load.
async fn latencies(args: &Ros2BenchArgs, ros2: &Ros2Python) -> Result<Window, BenchError> {
    let domain = fresh_domain();
    eprintln!("latencies: rclpy, and the program with {VEHICLES} vehicles over DDS");
    let px4 = Px4Side::start(VEHICLES, domain)?;
    let program = Program::start(&args.setup(VehicleLink::Dds, domain, true)).await?;
    let answers = ros2.start("answer", &[], domain)?;
    let mut asks = ros2.start("ask", &[COMMANDED.to_owned()], domain)?;
    program.take_off(VEHICLES).await?;
    peers::ready(&mut asks).await?;
    tokio::time::sleep(SETTLE).await;
    let (begun, before) = (Instant::now(), Machine::now());
    px4.begin()?;
    asks.tell(b"b\n").await?;
    tokio::time::sleep(Duration::from_secs(args.seconds.into())).await;
    asks.tell(b"e\n").await?;
    let marked = px4.end();
    let busy_s = Machine::now().busy_s - before.busy_s;
    let busy_percent = 100.0 * busy_s / begun.elapsed().as_secs_f64();
    let asked = peers::told::<Asked>(&mut asks).await?;
    for part in [asks, answers, program.part] {
        part.stop().await;
    }
    Ok(Window {
        asked,
        marked,
        busy_percent,
    })
}

#[cfg(test)]
mod tests;
