//! The command line. Its help text is what a person sees first.

use clap::{Args, Parser, Subcommand, ValueEnum};
use skein_demo::{DemoArguments, SimulatedKind};
use std::path::PathBuf;

/// Skein flies mixed UAV swarms: formations behind a leader over MAVLink, watched in a browser.
#[derive(Debug, Parser)]
#[command(name = "skein", version, about, after_help = AFTER_HELP)]
pub struct Arguments {
    /// How log lines are written to standard error.
    #[arg(long, value_enum, default_value_t = LogFormat::Text, global = true)]
    pub log_format: LogFormat,
    /// What is logged: a level, or filters such as `info,skein_link_mavlink=debug`.
    #[arg(long, default_value = "warn", global = true, value_name = "FILTER")]
    pub log: String,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Start here:
  skein demo                        a simulated swarm flies a demonstration; watch it in the browser
  skein sim --vehicles 6            only simulated vehicles, on the ports of PX4's own simulation
  skein init                        a configuration for this computer, by five questions
  skein run --config node.toml      a node for real or simulated vehicles
  skein doctor --config node.toml   what is wrong on this machine, and how to mend it

Exit codes: 0 done · 1 failed, or the demo did not meet its criteria · 2 wrong arguments ·
  64 wrong configuration or a missing plugin · 69 a port or device is not available · 70 fault of the program ·
  75 another version is to be started";

/// Shape of log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line, for machines.
    Json,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a demonstration: simulated vehicles take off, form up, follow a leader along a route and land.
    Demo(DemoArguments),
    /// Run a node: take in vehicles, fly them, serve dashboard and API.
    Run(RunArguments),
    /// Start simulated vehicles only; any MAVLink ground station can fly them.
    Sim(SimArguments),
    /// Make a configuration: five questions, or their answers as arguments.
    Init(crate::init::InitArguments),
    /// Check ports, plugins, configuration and clock, or a node that runs, and say how to mend what is wrong.
    Doctor(DoctorArguments),
    /// What nodes of one swarm need to find and trust each other.
    Swarm(SwarmArguments),
    /// Recordings of flights: list, look into, check, cut, merge, write in the formats of other programs.
    Log(crate::log::LogArguments),
    /// What happened in a recorded flight: one page of HTML that says what went wrong.
    Report(crate::report::ReportArguments),
    /// Give the nodes of a swarm another version of the program, or the one before.
    Upgrade(crate::upgrade::UpgradeArguments),
    /// Write, check and list plugins.
    Plugin(crate::plugin::PluginArguments),
    /// How well a detector sees, on clips whose truth is known.
    Vision(crate::vision::VisionArguments),
    /// Measure what the program costs.
    #[cfg(feature = "bench")]
    Bench(BenchArguments),
    /// Show a recorded flight again in a browser: slower, quicker, from any moment on.
    Replay(crate::replay::ReplayArguments),
    /// Fly a drawn flight of the tests again and tell what happens in it: a swarm in simulated time, judged by the truth.
    ReplaySeed {
        /// The seed, as the tests print it.
        seed: u64,
        /// Print every vehicle's state twice a second.
        #[arg(long)]
        trace: bool,
    },
    /// Print the completions of a shell: `skein completions bash > /etc/bash_completion.d/skein`.
    Completions {
        /// Which shell.
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Write the man pages into a directory.
    Man {
        /// It must be there.
        directory: PathBuf,
    },
    /// Runs one plugin instance for a node, which starts it with a socket as its standard input.
    #[command(hide = true)]
    PluginHost,
}

/// `skein run`
#[derive(Debug, Clone, Args)]
pub struct RunArguments {
    /// The configuration; see `default.toml` for every key.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Sets a key over the file, for example `swarm.node=3`: many computers share one file. Can be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `skein sim`
#[derive(Debug, Clone, Args)]
pub struct SimArguments {
    /// How many vehicles.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u8).range(1..=250))]
    pub vehicles: u8,
    /// System id of the first.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=255))]
    pub first_system_id: u8,
    /// Send all onboard links to this address instead of PX4's ports.
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub send_to: Option<std::net::SocketAddr>,
    /// Seed of wind and sensor noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What kind of vehicles they are.
    #[arg(long, value_enum, default_value_t = SimulatedKind::Quadrotor, value_name = "KIND")]
    pub airframe: SimulatedKind,
    /// Distance between the vehicles on the ground in metres.
    #[arg(long, default_value_t = 5.0)]
    pub spacing_m: f64,
    /// Where the field's origin lies, in degrees and metres above the sea; simulations on several computers that share one field share it.
    #[arg(long, value_name = "LAT,LON,ALT", value_parser = origin, allow_hyphen_values = true)]
    pub origin: Option<skein_domain::Geodetic>,
    /// Where on the field the first vehicle stands, in metres about the origin. Vehicles of two simulations must not stand on one spot.
    #[arg(long, value_name = "NORTH,EAST", value_parser = place, default_value = "0,0", allow_hyphen_values = true)]
    pub at: skein_domain::PositionNed,
    /// Write what really happens to this file, twenty times a second a line of JSON, for a referee.
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// End after so many seconds [default: at Ctrl-C].
    #[arg(long, value_name = "S")]
    pub seconds: Option<f64>,
}

/// `skein swarm`
#[derive(Debug, Clone, Args)]
pub struct SwarmArguments {
    /// What to do.
    #[command(subcommand)]
    pub command: SwarmCommand,
}

/// What `skein swarm` does.
#[derive(Debug, Clone, Subcommand)]
pub enum SwarmCommand {
    /// Make the secret that all nodes of a swarm share.
    NewSecret {
        /// The file to be made; it must not be there yet.
        file: PathBuf,
    },
}

/// Reads so many finite numbers.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let found = parsed.ok().filter(|all| all.iter().all(|n| n.is_finite()));
    found
        .and_then(|all| <[f64; N]>::try_from(all).ok())
        .ok_or_else(|| format!("{N} numbers are needed, with commas between them"))
}

fn origin(text: &str) -> Result<skein_domain::Geodetic, String> {
    let [latitude_deg, longitude_deg, altitude_amsl_m] = numbers(text)?;
    if latitude_deg.abs() > 90.0 || longitude_deg.abs() > 180.0 {
        return Err("there is no such place".into());
    }
    Ok(skein_domain::Geodetic {
        latitude_deg,
        longitude_deg,
        altitude_amsl_m,
    })
}

fn place(text: &str) -> Result<skein_domain::PositionNed, String> {
    let [north_m, east_m] = numbers(text)?;
    Ok(skein_domain::PositionNed::new(north_m, east_m, 0.0))
}

/// `skein doctor`
#[derive(Debug, Clone, Args)]
pub struct DoctorArguments {
    /// Check this configuration too.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Sets a key over the file, as `skein run` does.
    #[arg(long, value_name = "KEY=VALUE", requires = "config")]
    pub set: Vec<String>,
    /// Look at the node that runs at this address instead: actors, links, clocks, preflight report.
    #[arg(long, value_name = "URL", conflicts_with_all = ["config", "plugins"])]
    pub node: Option<reqwest::Url>,
    /// Of that node only whether it is well: a health check.
    #[arg(long, requires = "node")]
    pub brief: bool,
    /// Compare the parameters of this vehicle of that node with a file.
    #[arg(long, value_name = "ID", requires_all = ["node", "parameters"])]
    pub vehicle: Option<u16>,
    /// The file, as QGroundControl saves it; those of classes of vehicles are in deploy/vehicles.
    #[arg(long, value_name = "FILE", requires = "vehicle")]
    pub parameters: Option<PathBuf>,
    /// Directory of the plugins, without a configuration [default: `plugins` beside this program].
    #[arg(long, value_name = "DIR")]
    pub plugins: Option<PathBuf>,
}

/// `skein bench`
#[cfg(feature = "bench")]
#[derive(Debug, Clone, Args)]
pub struct BenchArguments {
    /// What is measured.
    #[command(subcommand)]
    pub what: Bench,
}

/// The benches.
#[cfg(feature = "bench")]
#[derive(Debug, Clone, Subcommand)]
pub enum Bench {
    /// The whole program against a load generator, beside a bare loop in the same run.
    Fleet {
        /// How many vehicles.
        #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u8).range(1..=250))]
        vehicles: u8,
        /// Length of each measuring window in seconds.
        #[arg(long, default_value_t = 10)]
        seconds: u32,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Assignments of vehicles to slots, beside SciPy's `linear_sum_assignment` in the same run.
    Assignment {
        /// A Python that has SciPy (`python3 -m venv DIR && DIR/bin/pip install scipy`, then `DIR/bin/python`).
        #[arg(long, default_value = "python3", value_name = "PROGRAM")]
        python: PathBuf,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// A long recording opened and wound back and forth, beside reading it once from its beginning to its end.
    Replay {
        /// How many vehicles.
        #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=250))]
        vehicles: u16,
        /// How long the flight is, in minutes.
        #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=600))]
        minutes: u32,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// A whole swarm's decisions in one process: a change of formation planned, the separation filter, a leader replaced.
    Swarm {
        /// How many vehicles.
        #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u16).range(2..=1000))]
        vehicles: u16,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// The swarm's bus over each of its transports, the same traffic in the same run: bytes, processor time, latencies.
    Bus {
        /// How many nodes.
        #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(2..=12))]
        nodes: u16,
        /// For how long each transport is measured, in seconds.
        #[arg(long, default_value_t = 10)]
        seconds: u32,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Latencies through ROS 2 and DDS beside rclpy programs in the same run; what ROS 2 takes with 1, 10 and 50 vehicles.
    Ros2 {
        /// The Python of an environment with rclpy, `bin/python` in it; `cargo xtask bench ros2` makes one.
        #[arg(long, value_name = "PROGRAM")]
        python: PathBuf,
        /// Length of the window of latencies in seconds; costs take a third of it each.
        #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(3..))]
        seconds: u32,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Eight cameras over RTP relayed to two viewers in flight, beside `ffmpeg -c copy` and the same flight without them, in the same run.
    Video {
        /// FFmpeg with libx264.
        #[arg(long, default_value = "ffmpeg", value_name = "PROGRAM")]
        ffmpeg: PathBuf,
        /// Length of each measuring window in seconds.
        #[arg(long, default_value_t = 15)]
        seconds: u32,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// What a detector takes for a picture, part by part, on one core: beside FFmpeg's decoding and onnxruntime in the same run.
    Vision {
        /// A folder of labelled clips, as `skein vision evaluate` takes it; the first clip of each camera is shown.
        #[arg(long, value_name = "DIR")]
        clips: PathBuf,
        /// A Python that has onnxruntime (`python3 -m venv DIR && DIR/bin/pip install onnxruntime`, then `DIR/bin/python`).
        #[arg(long, default_value = "python3", value_name = "PROGRAM")]
        python: PathBuf,
        /// FFmpeg.
        #[arg(long, default_value = "ffmpeg", value_name = "PROGRAM")]
        ffmpeg: PathBuf,
        /// The folder of the detector's own models.
        #[arg(long, default_value = "plugins/detector/models", value_name = "DIR")]
        models: PathBuf,
        /// Print the report as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Part of `video`: a viewer, as its own process.
    #[command(hide = true)]
    VideoViewer {
        /// Its settings as JSON.
        settings: String,
    },
    /// Part of `fleet`: the load generator, as its own process.
    #[command(hide = true)]
    LoadGenerator {
        /// Its settings as JSON.
        settings: String,
    },
    /// Part of `fleet`: the bare loop, as its own process.
    #[command(hide = true)]
    BareLoop {
        /// Its settings as JSON.
        settings: String,
    },
}
