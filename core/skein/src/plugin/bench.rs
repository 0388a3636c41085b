//! `skein plugin bench`: hands over to the bench library.

use anyhow::{Context, ensure};
use clap::Args;
use skein_bench::{PluginBenchArgs, run_plugin_bench};
use std::path::PathBuf;
use std::process::ExitCode;

/// `skein plugin bench`
#[derive(Debug, Clone, Args)]
pub struct BenchArguments {
    /// A library that answers received bytes with as many [default: `libbench_echo.so` beside this program].
    #[arg(long, value_name = "FILE")]
    pub plugin: Option<PathBuf>,
    /// Print the report as JSON.
    #[arg(long)]
    pub json: bool,
}

pub(super) fn bench(arguments: &BenchArguments) -> anyhow::Result<ExitCode> {
    let program = std::env::current_exe()?;
    let plugin = match &arguments.plugin {
        Some(plugin) => plugin.clone(),
        None => program
            .parent()
            .context("this program is in no folder")?
            .join("libbench_echo.so"),
    };
    ensure!(
        plugin.exists(),
        "{} is not there: build it with `cargo build --release -p bench-echo`, or run `cargo xtask bench`",
        plugin.display()
    );
    let report = run_plugin_bench(&PluginBenchArgs::new(plugin, program))?;
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        println!("{report}");
    }
    Ok(ExitCode::SUCCESS)
}
