//! `skein run`: one node until Ctrl-C or SIGTERM.

use crate::args::RunArguments;
use crate::versions::{self, Kept};
use crate::{exit, service};
use skein_config::{NodeConfig, Overlay};
use skein_node::{Running, build, stop_asked, tell};
use skein_upgrade::Swap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Runs a node until it is told to stop.
///
/// # Errors
/// When the configuration is wrong, a plugin is missing or a port is not available.
pub async fn run(arguments: RunArguments) -> anyhow::Result<ExitCode> {
    let kept = versions::start(state_directory());
    if kept.as_ref().is_none_or(|kept| !kept.is_on_trial()) {
        return run_version(arguments, kept).await;
    }
    // Whatever keeps a version on trial from running, the one before is started again.
    let ended = run_version(arguments, kept).await;
    ended.or_else(|error| {
        eprintln!("skein: this version is on trial and goes back: {error:#}");
        Ok(ExitCode::from(exit::ANOTHER_VERSION))
    })
}

async fn run_version(arguments: RunArguments, kept: Option<Kept>) -> anyhow::Result<ExitCode> {
    let running = come_up(&arguments, kept.as_ref()).await.inspect_err(|error| {
        if let Some(kept) = &kept {
            kept.did_not_come_up(&format!("it did not come up: {error:#}"));
        }
    })?;
    say_where(&running);
    let node = running.handle();
    let watch = async {
        match kept {
            Some(kept) => kept.watch(&node).await,
            None => std::future::pending().await,
        }
    };
    let mut code = ExitCode::SUCCESS;
    tokio::select! {
        asked = stop_asked() => asked?,
        () = service::tell_of(&node) => {}
        swap = watch => {
            match swap {
                Swap::Next => tell("Another version is to be started: this one ends, for the service manager to start it again."),
                Swap::GoneBack(why) => tell(format_args!("This version goes back: {why}")),
            }
            code = ExitCode::from(exit::ANOTHER_VERSION);
        }
    }
    stop(running).await?;
    Ok(code)
}

/// From the configuration to a running node.
async fn come_up(arguments: &RunArguments, kept: Option<&Kept>) -> anyhow::Result<Running> {
    let overlay = Overlay {
        set: arguments.set.clone(),
        state: state_directory(),
    };
    let mut config = NodeConfig::load_with(&arguments.config, &overlay)?;
    let alone = config.swarm.id.is_none();
    if config.hears_nobody() && alone {
        tell(format_args!(
            "No [[endpoints]] in {}: no vehicle will be heard.",
            arguments.config.display()
        ));
    }
    if config.adopt.is_empty() && alone {
        tell(format_args!(
            "No [[adopt]] rule in {}: vehicles are shown, not flown.",
            arguments.config.display()
        ));
    }
    #[cfg(feature = "zenoh")]
    crate::swarm::with_threads_enough(&config.swarm)?;
    if let Some(kept) = kept {
        kept.use_own_plugins(&mut config);
    }
    Ok(build(config).await?)
}

fn say_where(running: &Running) {
    if let Some(address) = running.web_address() {
        tell(format_args!("Dashboard: http://{address}"));
    }
    if let Some(swarm) = running.handle().swarm() {
        tell(format_args!("Swarm:     node {} of {}", swarm.node, swarm.swarm));
    }
    for (name, address) in running.handle().endpoint_addresses() {
        tell(format_args!("Endpoint:  {name} receives on {address}"));
    }
    tell("Stop with Ctrl-C.");
}

async fn stop(running: Running) -> anyhow::Result<()> {
    service::tell_of_stop();
    tell("Stopping. Ctrl-C again ends at once.");
    let stopped = async {
        running.handle().part(|line| tell(line)).await;
        running.stop().await;
    };
    tokio::select! {
        () = stopped => {}
        asked = stop_asked() => {
            asked?;
            tell("Ending at once.");
        }
    }
    Ok(())
}

/// Where systemd and the containers let a service write (`StateDirectory=`); none means beside the configuration.
#[must_use]
pub fn state_directory() -> Option<PathBuf> {
    let directories = std::env::var("STATE_DIRECTORY").ok()?;
    directories
        .split(':')
        .next()
        .filter(|first| !first.is_empty())
        .map(PathBuf::from)
}
