//! The `skein` program: reads the arguments, starts logging and the runtime, runs one command, gives an exit code. Nothing else.
#![forbid(unsafe_code)]

use clap::Parser;
use skein::args::{Arguments, Command};
use skein::{exit, init, log, logging, manual, replay_seed, report};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // Until the end of the program: what is still to be sent then is.
    let _export = match logging::start(arguments.log_format, &arguments.log) {
        Ok(export) => export,
        Err(error) => {
            eprintln!("skein: {error:#}");
            return ExitCode::from(2);
        }
    };
    exit::quietly_without_reader();
    // Actors and plugins are caught where they run; what comes through to here is a fault of the program itself.
    match std::panic::catch_unwind(|| execute(arguments.command)) {
        Ok(Ok(code)) => code,
        Ok(Err(error)) => {
            eprintln!("skein: {error:#}");
            exit::code(&error)
        }
        Err(fault) if exit::is_without_reader(&*fault) => ExitCode::SUCCESS,
        Err(_) => {
            eprintln!("skein: this is a fault of the program; please report it with the lines above");
            ExitCode::from(exit::INTERNAL)
        }
    }
}

fn execute(command: Command) -> anyhow::Result<ExitCode> {
    match command {
        #[cfg(feature = "bench")]
        Command::Bench(arguments) => return skein::bench::bench(arguments.what),
        Command::Init(arguments) => return init::init(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Log(arguments) => return log::log(arguments),
        Command::Completions { shell } => return Ok(manual::completions(shell)),
        Command::Man { directory } => return manual::man_pages(&directory).map(|()| ExitCode::SUCCESS),
        Command::ReplaySeed { seed, trace } => return Ok(replay_seed::replay_seed(seed, trace)),
        Command::Report(arguments) => return report::report(&arguments).map(|()| ExitCode::SUCCESS),
        // Without a runtime: it is one plugin and a socket.
        Command::PluginHost => return plugin_host(),
        _ => {}
    }
    let actors = std::thread::available_parallelism().map_or(2, usize::from);
    if matches!(command, Command::Demo(_) | Command::Run(_) | Command::Sim(_)) {
        skein_realtime::want();
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .worker_threads(actors)
        .on_thread_start(skein_realtime::ask_on_start_of(actors))
        .build()?;
    runtime.block_on(skein::in_runtime(command))
}

/// Serves one plugin instance until its node ends it.
fn plugin_host() -> anyhow::Result<ExitCode> {
    skein_plugin_host::child::serve()?;
    Ok(ExitCode::SUCCESS)
}
