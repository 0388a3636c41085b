//! The program: from a configuration to a running node with its dashboard, and the commands a person starts it with.
//!
//! Must never do: fly anything by itself; the demo flight gives the same commands an operator would give.
#![forbid(unsafe_code)]

pub mod args;
#[cfg(feature = "bench")]
pub mod bench;
pub mod doctor;
pub mod exit;
pub mod init;
pub mod log;
pub mod logging;
pub mod manual;
pub mod plugin;
pub mod replay;
pub mod replay_seed;
pub mod report;
pub mod run;
pub mod service;
pub mod simulate;
pub mod swarm;
pub mod upgrade;
pub mod versions;
pub mod vision;

use args::Command;
use std::pin::Pin;
use std::process::ExitCode;

/// The commands that need a runtime; the others are carried out before there is one, and do nothing here.
///
/// No `async fn`: the compiler makes the code of one in every crate that awaits it.
#[must_use]
pub fn in_runtime(command: Command) -> Pin<Box<dyn Future<Output = anyhow::Result<ExitCode>>>> {
    let done = |()| ExitCode::SUCCESS;
    Box::pin(async move {
        match command {
            Command::Demo(arguments) => skein_demo::demo(arguments).await,
            Command::Run(arguments) => run::run(arguments).await,
            Command::Sim(arguments) => simulate::simulate(arguments).await.map(done),
            Command::Doctor(arguments) => doctor::doctor(&arguments).await,
            Command::Upgrade(arguments) => upgrade::upgrade(arguments).await,
            Command::Replay(arguments) => replay::replay(&arguments).await.map(done),
            Command::Swarm(arguments) => swarm::swarm(&arguments).map(done),
            Command::Plugin(arguments) => plugin::plugin(arguments).await,
            Command::Vision(arguments) => vision::vision(arguments).await,
            #[cfg(feature = "bench")]
            Command::Bench(_) => Ok(ExitCode::SUCCESS),
            Command::Init(_)
            | Command::Log(_)
            | Command::Completions { .. }
            | Command::Man { .. }
            | Command::ReplaySeed { .. }
            | Command::Report(_)
            | Command::PluginHost => Ok(ExitCode::SUCCESS),
        }
    })
}
