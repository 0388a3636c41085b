//! The bench as a whole: rounds of a window of the program and a window of the bare loop, each under the same load.

use crate::bare::BareLoopSettings;
use crate::error::BenchError;
use crate::generator::LoadGeneratorSettings;
use crate::process::{Machine, Part, Scheduling};
use crate::program::{Program, Setup};
use crate::report::{FleetBenchReport, LoadFigures, WindowFigures};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct FleetBenchArgs {
    /// How many vehicles.
    pub vehicles: u16,
    /// Length of each window in seconds.
    pub seconds: u32,
    /// Windows of each side.
    pub rounds: u32,
    /// How long both sides run undisturbed before a window, in seconds.
    pub settle_s: f64,
    /// The program under test.
    pub program: PathBuf,
    /// Where its plugins are.
    pub plugins: PathBuf,
    /// How all processes are scheduled.
    pub scheduling: Scheduling,
    /// The program with the commands `bench load-generator` and `bench bare-loop`.
    pub helper: PathBuf,
}

impl FleetBenchArgs {
    /// Three rounds with a program that is its own helper and has its plugins beside it.
    #[must_use]
    pub fn new(vehicles: u16, seconds: u32, program: PathBuf) -> Self {
        let plugins = program.parent().unwrap_or(Path::new(".")).join("plugins");
        Self {
            vehicles,
            seconds,
            rounds: 3,
            settle_s: 3.0,
            scheduling: Scheduling::Ordinary,
            helper: program.clone(),
            program,
            plugins,
        }
    }
}

impl FleetBenchArgs {
    /// Whether anything would be measured.
    pub(crate) fn check(&self) -> Result<(), BenchError> {
        if self.seconds == 0 || self.rounds == 0 {
            return Err(BenchError::Argument(
                "a window of at least one second and at least one round are needed".into(),
            ));
        }
        Ok(())
    }
}

/// The identity of the program on the wire, and of the bare loop.
const OWN_SYSTEM_ID: u8 = 245;

/// Runs the bench. Progress goes to standard error.
///
/// # Errors
/// When a child process cannot be started, ends, or the fleet does not get into the air.
pub fn run_fleet_bench(args: &FleetBenchArgs) -> Result<FleetBenchReport, BenchError> {
    args.check()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    runtime.block_on(async {
        let (mut program, mut recording, mut bare) = (Vec::new(), Vec::new(), Vec::new());
        for round in 1..=args.rounds {
            eprintln!(
                "round {round} of {}: the program with {} vehicles",
                args.rounds, args.vehicles
            );
            program.push(program_window(args, false).await?);
            eprintln!("round {round} of {}: the same while it records", args.rounds);
            recording.push(program_window(args, true).await?);
            eprintln!("round {round} of {}: the bare loop", args.rounds);
            bare.push(bare_window(args).await?);
        }
        Ok(FleetBenchReport {
            scheduling: args.scheduling,
            ..FleetBenchReport::of(args.vehicles, f64::from(args.seconds), program, recording, bare)
        })
    })
}

async fn program_window(args: &FleetBenchArgs, recorder: bool) -> Result<WindowFigures, BenchError> {
    let setup = Setup {
        recorder,
        ..Setup::plain(&args.program, &args.plugins, args.scheduling)
    };
    let program = Program::start(&setup).await?;
    let mut generator = start_generator(args, program.endpoint)?;
    program.take_off(args.vehicles).await?;
    let (before, began) = (program.recorded_bytes(), Instant::now());
    let figures = window(args, &program.part, &mut generator).await;
    let recorded = program.recorded_bytes().saturating_sub(before) as f64;
    let per_s = recorded / began.elapsed().as_secs_f64() / f64::from(args.vehicles.max(1));
    program.part.stop().await;
    generator.stop().await;
    figures.map(|figures| WindowFigures {
        recorded_bytes_per_s_per_vehicle: per_s,
        ..figures
    })
}

async fn bare_window(args: &FleetBenchArgs) -> Result<WindowFigures, BenchError> {
    let settings = BareLoopSettings {
        own_system_id: OWN_SYSTEM_ID,
        ..BareLoopSettings::default()
    };
    let settings = serde_json::to_string(&settings).map_err(BenchError::Settings)?;
    let mut bare = Part::start(
        "bare loop",
        &args.helper,
        &["bench", "bare-loop", &settings],
        args.scheduling,
        Stdio::inherit(),
    )?;
    let line = bare.line().await?;
    let target = line.trim().parse();
    let target = target.map_err(|_| BenchError::Child {
        part: "bare loop",
        detail: format!("said `{line}`"),
    })?;
    let mut generator = start_generator(args, target)?;
    let figures = window(args, &bare, &mut generator).await;
    bare.stop().await;
    generator.stop().await;
    figures
}

pub(crate) fn start_generator(args: &FleetBenchArgs, target: SocketAddr) -> Result<Part, BenchError> {
    let settings = LoadGeneratorSettings {
        vehicles: args.vehicles,
        target,
        reserved_system_ids: vec![OWN_SYSTEM_ID],
    };
    let settings = serde_json::to_string(&settings).map_err(BenchError::Settings)?;
    Part::start(
        "load generator",
        &args.helper,
        &["bench", "load-generator", &settings],
        args.scheduling,
        Stdio::inherit(),
    )
}

/// One window of a side that is under load already.
pub(crate) async fn window(
    args: &FleetBenchArgs,
    side: &Part,
    generator: &mut Part,
) -> Result<WindowFigures, BenchError> {
    tokio::time::sleep(Duration::from_secs_f64(args.settle_s)).await;
    generator.tell(b"b").await?;
    let (begun, machine) = (Instant::now(), Machine::now());
    let (side_before, generator_before) = (side.usage()?, generator.usage()?);
    tokio::time::sleep(Duration::from_secs(u64::from(args.seconds))).await;
    let window_s = begun.elapsed().as_secs_f64();
    let (side_after, generator_after, machine_after) = (side.usage()?, generator.usage()?, Machine::now());
    generator.tell(b"e").await?;
    let line = generator.line().await?;
    let load: LoadFigures = serde_json::from_str(&line).map_err(|_| BenchError::Child {
        part: "load generator",
        detail: format!("said `{line}`"),
    })?;
    let percent = |seconds: f64| 100.0 * seconds / window_s;
    let cpu_percent = percent(side_after.cpu_s - side_before.cpu_s);
    let generator_cpu_percent = percent(generator_after.cpu_s - generator_before.cpu_s);
    let busy_percent = percent(machine_after.busy_s - machine.busy_s);
    if load.vehicles_streaming < usize::from(args.vehicles) {
        let detail = format!(
            "{} of {} vehicles got setpoints",
            load.vehicles_streaming, args.vehicles
        );
        return Err(BenchError::Program(detail));
    }
    Ok(WindowFigures {
        recorded_bytes_per_s_per_vehicle: 0.0,
        cpu_percent,
        rss_mib: side_after.rss_mib,
        threads: side_after.threads,
        generator_cpu_percent,
        other_cpu_percent: (busy_percent - cpu_percent - generator_cpu_percent).max(0.0),
        dropped_datagrams: machine_after
            .dropped_datagrams
            .saturating_sub(machine.dropped_datagrams),
        load,
    })
}

#[cfg(test)]
mod tests;
