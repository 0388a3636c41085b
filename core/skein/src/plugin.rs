//! `skein plugin …`: what the author of a plugin and whoever takes one in need at the command line.
//!
//! Must never do: judge by itself. What is right and what is not is the host's word, the same as in a node.

#[cfg(feature = "bench")]
mod bench;
mod check;
mod list;
mod new;
mod node;

use clap::{Args, Subcommand};
use std::process::ExitCode;

#[cfg(feature = "bench")]
pub use bench::BenchArguments;
pub use check::CheckArguments;
pub use list::ListArguments;
pub use new::NewArguments;
pub use node::{NodeArguments, NodeCommand};

/// `skein plugin`
#[derive(Debug, Clone, Args)]
pub struct PluginArguments {
    /// What to do.
    #[command(subcommand)]
    pub what: PluginCommand,
}

/// What can be done with plugins.
#[derive(Debug, Clone, Subcommand)]
pub enum PluginCommand {
    /// Write a new plugin: a whole crate that builds, with tests.
    New(NewArguments),
    /// Load libraries as a node does, make an instance, call it, and say what is wrong.
    Check(CheckArguments),
    /// Say which plugins are in the directories.
    List(ListArguments),
    /// Measure what one call into a plugin costs, in the process and in a child process.
    #[cfg(feature = "bench")]
    Bench(BenchArguments),
    /// The plugins of a running node: upgrade, roll back, restart, attach, command.
    Node(NodeArguments),
}

/// Runs one of them.
pub async fn plugin(arguments: PluginArguments) -> anyhow::Result<ExitCode> {
    match arguments.what {
        PluginCommand::New(arguments) => new::new(&arguments),
        PluginCommand::Check(arguments) => check::check(&arguments).await,
        PluginCommand::List(arguments) => list::list(&arguments),
        PluginCommand::Node(arguments) => node::node(&arguments).await,
        // It makes a runtime of its own.
        #[cfg(feature = "bench")]
        PluginCommand::Bench(arguments) => tokio::task::spawn_blocking(move || bench::bench(&arguments)).await?,
    }
}
