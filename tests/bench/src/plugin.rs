//! What one call of a plugin costs: an event with some bytes in, an effect with the same bytes out, encoding included. Without the boundary,
//! over it in this process, over it into a child process, and as a node makes it with its threads.

use crate::error::BenchError;
use crate::report::Spread;
use bench_echo::Echo;
use serde::{Deserialize, Serialize};
use skein_domain::exchange::{Create, Effect, Event, EventBatch};
use skein_domain::{Incarnation, NodeTime, VehicleId};
use skein_plugin_host::{ChildLimits, DirectInstance, Isolation, Plugin, PluginError, RunnerSettings, Runners};
use skein_plugin_sdk::{Effects, Payload};
use std::fmt;
use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct PluginBenchArgs {
    /// The library: `bench-echo`, or any other that answers received bytes with bytes to transmit.
    pub plugin: PathBuf,
    /// The program that a child runs with the argument `plugin-host`.
    pub host_program: PathBuf,
    /// Bytes of the event and of the effect.
    pub payload_bytes: usize,
    /// How often every way is measured, one after the other.
    pub rounds: u32,
    /// For how long a way is measured in one round.
    pub time: Duration,
}

impl PluginBenchArgs {
    /// Five rounds with 100 bytes.
    #[must_use]
    pub fn new(plugin: PathBuf, host_program: PathBuf) -> Self {
        Self {
            plugin,
            host_program,
            payload_bytes: 100,
            rounds: 5,
            time: Duration::from_millis(500),
        }
    }
}

/// What a call costs in one way.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CallFigures {
    /// The median of a round, over the rounds.
    pub p50_ns: Spread,
    /// 99 % of a round were no slower, over the rounds. Calls of under a microsecond are measured by the hundred.
    pub p99_ns: Spread,
    /// How many direct calls take as long, by the medians.
    pub ratio_to_direct: f64,
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PluginBenchReport {
    /// Name and version of the plugin.
    pub plugin: String,
    /// Bytes of the event and of the effect.
    pub payload_bytes: usize,
    /// How often every way was measured.
    pub rounds: u32,
    /// Processors of the machine.
    pub processors: usize,
    /// The echo called as a function, with no boundary.
    pub direct: CallFigures,
    /// Over the boundary in this process, on the calling thread.
    pub in_process: CallFigures,
    /// The same, with the snapshot that a node takes with every call.
    pub in_process_with_snapshot: CallFigures,
    /// Over the boundary in a child process, on the calling thread.
    pub child: CallFigures,
    /// The same, with the snapshot.
    pub child_with_snapshot: CallFigures,
    /// As a node calls in this process: through a watched thread, with the snapshot.
    pub runner_in_process: CallFigures,
    /// As a node calls in a child process: through the child's thread, with the snapshot.
    pub runner_child: CallFigures,
}

/// Medians and tails of one way, a pair per round, in nanoseconds.
type Rounds = Vec<(f64, f64)>;

/// Runs the bench on the calling thread.
///
/// # Errors
/// When the library is not taken, or does not answer as an echo does.
pub fn run_plugin_bench(args: &PluginBenchArgs) -> Result<PluginBenchReport, BenchError> {
    if args.rounds == 0 || args.time.is_zero() {
        return Err(BenchError::Argument("at least one round of some time is needed".into()));
    }
    let plugin =
        Plugin::load(&args.plugin).map_err(|e| BenchError::Program(format!("{}: {e}", args.plugin.display())))?;
    let bench = Bench::new(args, Arc::clone(&plugin));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    let mut ways: [Rounds; 7] = Default::default();
    for _ in 0..args.rounds {
        let [direct, here, here_kept, child, child_kept, runner_here, runner_child] = &mut ways;
        direct.push(bench.direct()?);
        here.push(bench.alone(Isolation::InProcess, 100, false)?);
        here_kept.push(bench.alone(Isolation::InProcess, 100, true)?);
        child.push(bench.alone(CHILD, 1, false)?);
        child_kept.push(bench.alone(CHILD, 1, true)?);
        runner_here.push(runtime.block_on(bench.runner(Isolation::InProcess))?);
        runner_child.push(runtime.block_on(bench.runner(CHILD))?);
    }
    let direct_ns = figures(&ways[0], 0.0).p50_ns.median;
    let [direct, here, here_kept, child, child_kept, runner_here, runner_child] =
        ways.map(|rounds| figures(&rounds, direct_ns));
    Ok(PluginBenchReport {
        plugin: format!("{} {}", plugin.manifest().name, plugin.manifest().version),
        payload_bytes: args.payload_bytes,
        rounds: args.rounds,
        processors: std::thread::available_parallelism().map_or(0, usize::from),
        direct,
        in_process: here,
        in_process_with_snapshot: here_kept,
        child,
        child_with_snapshot: child_kept,
        runner_in_process: runner_here,
        runner_child,
    })
}

/// A child may use whole cores here, so that no round ends at a limit.
const CHILD: Isolation = Isolation::Child(ChildLimits {
    memory_mib: 256,
    cpu_share: 2.0,
    open_files: 64,
});

fn figures(rounds: &Rounds, direct_ns: f64) -> CallFigures {
    let p50_ns = Spread::of(rounds.iter().map(|(median, _)| *median));
    CallFigures {
        p50_ns,
        p99_ns: Spread::of(rounds.iter().map(|(_, tail)| *tail)),
        ratio_to_direct: if direct_ns > 0.0 {
            p50_ns.median / direct_ns
        } else {
            1.0
        },
    }
}

/// What all ways have in common.
struct Bench<'a> {
    args: &'a PluginBenchArgs,
    plugin: Arc<Plugin>,
    settings: RunnerSettings,
    batch: EventBatch,
}

impl<'a> Bench<'a> {
    fn new(args: &'a PluginBenchArgs, plugin: Arc<Plugin>) -> Self {
        let bytes = (0..args.payload_bytes).map(|i| i as u8).collect();
        Self {
            args,
            plugin,
            settings: RunnerSettings {
                call_deadline: Duration::from_secs(5),
                create_deadline: Duration::from_secs(5),
                ..RunnerSettings::default()
            },
            batch: EventBatch {
                now: NodeTime(1),
                events: vec![Event::Received { bytes }],
            },
        }
    }

    fn direct(&self) -> Result<(f64, f64), BenchError> {
        let mut echo = Echo::default();
        self.measure(1_000, || {
            let mut effects = Effects::default();
            echo.handle(black_box(self.batch.now), black_box(&self.batch.events), &mut effects);
            Ok(black_box(effects).take())
        })
    }

    fn alone(&self, isolation: Isolation, block: u32, with_snapshot: bool) -> Result<(f64, f64), BenchError> {
        let plugin = Arc::clone(&self.plugin);
        let program = &self.args.host_program;
        let mut instance =
            DirectInstance::create(plugin, isolation, program, self.settings, &create()).map_err(failed)?;
        self.measure(block, || {
            let batch = black_box(&self.batch);
            if with_snapshot {
                instance.call(batch).map(|answer| answer.effects).map_err(failed)
            } else {
                instance.handle(batch).map(|(effects, _)| effects).map_err(failed)
            }
        })
    }

    async fn runner(&self, isolation: Isolation) -> Result<(f64, f64), BenchError> {
        let runners = Runners::with_settings(self.settings);
        runners.set_host_program(self.args.host_program.clone());
        let instance = runners
            .create(Arc::clone(&self.plugin), isolation, create())
            .await
            .map_err(failed)?;
        let (mut times_ns, began) = (Vec::new(), Instant::now());
        while began.elapsed() < self.args.time {
            let batch = self.batch.clone();
            let asked = Instant::now();
            let answer = instance.call(batch, &[]).await.map_err(failed)?;
            times_ns.push(asked.elapsed().as_nanos() as f64);
            self.check(&answer.effects)?;
        }
        Ok(quantiles(times_ns))
    }

    /// Makes calls for the time of a round; gives median and tail of one.
    fn measure(
        &self,
        block: u32,
        mut call: impl FnMut() -> Result<Vec<Effect>, BenchError>,
    ) -> Result<(f64, f64), BenchError> {
        for _ in 0..block {
            self.check(&call()?)?;
        }
        let (mut times_ns, began) = (Vec::new(), Instant::now());
        while began.elapsed() < self.args.time {
            let asked = Instant::now();
            for _ in 0..block {
                drop(black_box(call()?));
            }
            times_ns.push(asked.elapsed().as_nanos() as f64 / f64::from(block));
        }
        Ok(quantiles(times_ns))
    }

    fn check(&self, effects: &[Effect]) -> Result<(), BenchError> {
        match (effects, self.batch.events.as_slice()) {
            ([Effect::Transmit { bytes }], [Event::Received { bytes: sent }]) if bytes == sent => Ok(()),
            _ => Err(BenchError::Program(format!(
                "the plugin is no echo: it answered {effects:?}"
            ))),
        }
    }
}

fn create() -> Create {
    Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot: None,
        now: NodeTime(0),
        payload: Some("echo".to_owned()),
        system_id: None,
    }
}

fn failed(error: PluginError) -> BenchError {
    BenchError::Program(error.to_string())
}

fn quantiles(mut times_ns: Vec<f64>) -> (f64, f64) {
    times_ns.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (times_ns.len() as f64 * share) as usize;
        times_ns.get(index).or(times_ns.last()).copied().unwrap_or(0.0)
    };
    (at(0.5), at(0.99))
}

impl fmt::Display for PluginBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: one event in, one effect out, {} bytes each, encoding included; {} rounds, {} processors",
            self.plugin, self.payload_bytes, self.rounds, self.processors
        )?;
        writeln!(
            f,
            "{:<46} {:>28} {:>14} {:>10}",
            "ns per call: median [smallest .. largest]", "p50", "p99", "x direct"
        )?;
        let rows = [
            ("a direct call, no boundary", &self.direct),
            ("in this process", &self.in_process),
            ("  with snapshot", &self.in_process_with_snapshot),
            ("in a child process", &self.child),
            ("  with snapshot", &self.child_with_snapshot),
            ("through a node's thread, in this process", &self.runner_in_process),
            ("through a node's thread, in a child process", &self.runner_child),
        ];
        for (i, (name, figures)) in rows.iter().enumerate() {
            let Spread { min, median, max } = figures.p50_ns;
            let cell = format!("{median:.0} [{min:.0} .. {max:.0}]");
            let (tail, ratio) = (figures.p99_ns.median, figures.ratio_to_direct);
            write!(f, "{name:<46} {cell:>28} {tail:>14.0} {ratio:>10.1}")?;
            if i + 1 < rows.len() {
                writeln!(f)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
