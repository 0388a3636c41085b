//! `cargo xtask`: one ladder of checks and builds, the same at the desk and in CI. Here: arguments and dispatch only.
//!
//! Must never do: keep a rule of its own beside the ones in `tidy`, or a way to test that CI does not use.
#![forbid(unsafe_code)]

mod artifacts;
mod bench;
mod browser;
mod debian;
mod demo;
mod docs;
mod failures;
mod fast;
mod images;
mod lints;
mod long_runs;
mod namespaces;
mod output;
mod packages;
mod plugins;
mod processes;
mod px4;
mod px4_messages;
mod report;
mod screenshot;
mod step;
mod tally;
mod tidy;
mod tiers;
mod ui;
mod unsteady;
mod workspace;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::process::ExitCode;
use workspace::Workspace;

/// Builds, checks and flies Skein from its source tree.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", disable_version_flag = true)]
struct Arguments {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// About a minute: formatting, lints, tidy, and the tests of the crates you changed, and of the dashboard if you changed that.
    Fast {
        /// Compare with this revision (default: where this branch left main).
        #[arg(long, value_name = "REVISION")]
        since: Option<String>,
    },
    /// Everything CI runs, or the tiers named. Sets up what they need.
    Test {
        /// Tiers: static, unit, wire, integration, plugin-boundary, faults, seeded, e2e, multihost, interop, ui, ui-soak. None: all of them,
        /// without what takes long.
        #[arg(value_parser = tiers::parse)]
        tiers: Vec<tiers::Tier>,
        /// Also the long ones: soak flights, an hour of the dashboard, and fuzzing.
        #[arg(long)]
        all: bool,
    },
    /// Compiles the plugins and copies them to where the program looks for them.
    BuildPlugins {
        /// With optimisation, for the release program.
        #[arg(long)]
        release: bool,
    },
    /// Builds the dashboard (skipped if its sources have not changed).
    BuildUi,
    /// Builds everything and flies the demo; arguments go on to `skein demo`.
    Demo {
        /// For example `--vehicles 20 --headless`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Builds everything and flies the demo with instances of your own build of PX4, in the simulation that PX4 carries.
    Px4(px4::Px4Arguments),
    /// Compares the messages that the link over DDS knows with a source tree of PX4, and takes over what a release changed.
    Px4Messages(px4_messages::MessagesArguments),
    /// Measures the program beside plain loops, SciPy and rclpy; arguments go on to `skein bench fleet`. `bench ros2` measures ROS 2 alone.
    Bench {
        /// For example `--vehicles 100 --seconds 10`, or `ros2 --seconds 30`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Builds Debian packages for amd64 and arm64; with `--check`, installs, upgrades, removes and purges each in a Debian of its own.
    Packages(packages::PackagesArguments),
    /// Builds the container images for amd64 and arm64 by buildah, without an engine or a registry, and starts each.
    Images(images::ImagesArguments),
    /// Checks the habits of the house that neither rustc nor clippy can check.
    Tidy,
    /// Builds the documentation as a site, with mdBook, and says where to open it.
    Docs,
    /// Flies the demo's vehicles and takes pictures of every panel of the dashboard, at three widths, light and dark.
    #[command(alias = "screenshot")]
    Screenshots(screenshot::ScreenshotArguments),
}

fn main() -> ExitCode {
    let ended = run(Arguments::parse().command);
    processes::wait_if_interrupted();
    match ended {
        Ok(code) => code,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Result<ExitCode> {
    if matches!(task, Task::Fast { .. } | Task::Test { .. }) {
        processes::end_all_when_interrupted(namespaces::clear);
    }
    let workspace = Workspace::load()?;
    match task {
        Task::Fast { since } => fast::run(&workspace, since.as_deref()),
        Task::Test { tiers, all } => tiers::run(&workspace, &tiers, all),
        Task::BuildPlugins { release } => {
            let folder = plugins::build(&workspace, plugins::Profile::from_release(release))?;
            println!("plugins are in {}", folder.display());
            Ok(ExitCode::SUCCESS)
        }
        Task::BuildUi => ui::build(&workspace).map(|()| ExitCode::SUCCESS),
        Task::Demo { arguments } => demo::run(&workspace, &arguments),
        Task::Px4(arguments) => px4::run(&workspace, &arguments),
        Task::Px4Messages(arguments) => px4_messages::run(&workspace, &arguments),
        Task::Bench { arguments } => bench::run(&workspace, &arguments),
        Task::Images(arguments) => images::run(&workspace, &arguments),
        Task::Packages(arguments) => packages::run(&workspace, &arguments),
        Task::Tidy => tidy::run(&workspace),
        Task::Docs => docs::run(&workspace),
        Task::Screenshots(arguments) => screenshot::take(&workspace, arguments).map(|()| ExitCode::SUCCESS),
    }
}
