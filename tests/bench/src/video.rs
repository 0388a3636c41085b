//! What it takes to relay live video: cameras of RTP in, viewers over WebSockets out, beside `ffmpeg -c copy` from RTP to RTP and beside the
//! same flight without a camera.
//!
//! Must never do: decode. What a picture takes to become pixels is the viewer's affair.

mod clip;
mod report;
#[cfg(test)]
mod tests;
mod viewer;

use crate::error::BenchError;
use crate::fleet::{self, FleetBenchArgs};
use crate::process::{Part, Usage};
use crate::program::{Program, Setup};
use crate::report::WindowFigures;
use clip::{Clip, Port};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};
use viewer::{VideoViewerSettings, ViewerFigures};

pub use report::VideoBenchReport;
pub use viewer::run_video_viewer;

/// Each vehicle has a camera.
const CAMERAS: u16 = 8;
/// So many cameras each viewer looks at: a wall of all, and a second screen with two.
const VIEWERS: [u16; 2] = [CAMERAS, 2];

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoBenchArgs {
    /// The flight: as many vehicles as cameras.
    pub fleet: FleetBenchArgs,
    /// The program that sends the cameras' streams, and relays them beside ours.
    pub ffmpeg: PathBuf,
}

impl VideoBenchArgs {
    /// With a program that is its own helper and has its plugins beside it.
    #[must_use]
    pub fn new(ffmpeg: PathBuf, seconds: u32, program: PathBuf) -> Self {
        Self {
            fleet: FleetBenchArgs::new(CAMERAS, seconds, program),
            ffmpeg,
        }
    }
}

/// What one round gave.
#[derive(Debug, Clone, PartialEq)]
struct Round {
    without: WindowFigures,
    with: WindowFigures,
    viewers: Vec<ViewerFigures>,
    /// Processor time of all of FFmpeg's relays together, 100 = one core.
    ffmpeg_cpu_percent: f64,
}

/// Runs the bench. Progress goes to standard error.
///
/// # Errors
/// When a child process cannot be started, ends, or the fleet does not get into the air.
pub fn run_video_bench(args: &VideoBenchArgs) -> Result<VideoBenchReport, BenchError> {
    args.fleet.check()?;
    let clip = Clip::make(&args.ffmpeg)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    runtime.block_on(async {
        let mut rounds = Vec::new();
        for round in 1..=args.fleet.rounds {
            eprintln!("round {round} of {}: without cameras", args.fleet.rounds);
            let setup = Setup::plain(&args.fleet.program, &args.fleet.plugins, args.fleet.scheduling);
            let without = flight(args, &setup).await?.0;
            eprintln!("round {round} of {}: with {CAMERAS} cameras", args.fleet.rounds);
            let ports = Port::free(usize::from(CAMERAS))?;
            let _sender = clip.send(&args.ffmpeg, &ports)?;
            let cameras: Vec<u16> = ports.iter().map(|port| port.number).collect();
            drop(ports);
            let setup = Setup {
                cameras: &cameras,
                ..setup
            };
            let (with, viewers) = flight(args, &setup).await?;
            eprintln!("round {round} of {}: FFmpeg", args.fleet.rounds);
            rounds.push(Round {
                without,
                with,
                viewers,
                ffmpeg_cpu_percent: relayed_by_ffmpeg(args, &clip).await?,
            });
        }
        Ok(VideoBenchReport::of(
            CAMERAS,
            VIEWERS.iter().sum(),
            args.fleet.seconds,
            &rounds,
        ))
    })
}

/// One window of the program in flight; with viewers where it has cameras.
async fn flight(args: &VideoBenchArgs, setup: &Setup<'_>) -> Result<(WindowFigures, Vec<ViewerFigures>), BenchError> {
    let program = Program::start(setup).await?;
    let mut generator = fleet::start_generator(&args.fleet, program.endpoint)?;
    program.take_off(CAMERAS).await?;
    let mut viewers = Vec::new();
    if !setup.cameras.is_empty() {
        for cameras in VIEWERS {
            viewers.push(viewer::start(
                &args.fleet,
                &VideoViewerSettings {
                    target: program.web,
                    cameras: (1..=cameras).collect(),
                },
            )?);
        }
        for viewer in &mut viewers {
            // It has had a picture of each.
            viewer.line().await?;
        }
    }
    for viewer in &mut viewers {
        viewer.tell(b"b").await?;
    }
    let window = fleet::window(&args.fleet, &program.part, &mut generator).await;
    let mut seen = Vec::new();
    for viewer in &mut viewers {
        viewer.tell(b"e").await?;
        let line = viewer.line().await?;
        let figures = serde_json::from_str(&line).map_err(|_| BenchError::Child {
            part: viewer::NAME,
            detail: format!("said `{line}`"),
        })?;
        seen.push(figures);
    }
    for part in viewers.into_iter().chain([program.part, generator]) {
        part.stop().await;
    }
    Ok((window?, seen))
}

/// The same streams relayed by FFmpeg, one process each: percent of a core that all take together.
async fn relayed_by_ffmpeg(args: &VideoBenchArgs, clip: &Clip) -> Result<f64, BenchError> {
    let (from, to) = (Port::free(usize::from(CAMERAS))?, Port::free(usize::from(CAMERAS))?);
    let sender = clip.send(&args.ffmpeg, &from)?;
    let numbers: Vec<u16> = from.iter().map(|port| port.number).collect();
    drop(from);
    let relays = numbers
        .iter()
        .zip(&to)
        .map(|(from, to)| clip.relay(&args.ffmpeg, *from, to.number));
    let relays: Vec<Part> = relays.collect::<Result<_, _>>()?;
    let begun = Instant::now();
    while !to.iter().all(Port::hears) {
        if begun.elapsed() > clip::PATIENCE {
            return Err(BenchError::Child {
                part: clip::RELAY,
                detail: format!("sent nothing within {} s", clip::PATIENCE.as_secs()),
            });
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    tokio::time::sleep(Duration::from_secs_f64(args.fleet.settle_s)).await;
    let all = || {
        relays
            .iter()
            .map(|relay| relay.usage().map(|usage: Usage| usage.cpu_s))
            .sum()
    };
    let (begun, before): (_, Result<f64, _>) = (Instant::now(), all());
    tokio::time::sleep(Duration::from_secs(u64::from(args.fleet.seconds))).await;
    let (window_s, after): (_, Result<f64, _>) = (begun.elapsed().as_secs_f64(), all());
    for part in relays.into_iter().chain([sender]) {
        part.stop().await;
    }
    Ok(100.0 * (after? - before?) / window_s)
}

/// What a helper writes to its standard error is shown.
fn errors() -> Stdio {
    Stdio::inherit()
}
