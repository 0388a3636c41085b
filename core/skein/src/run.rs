//! `skein run`: one node until Ctrl-C or SIGTERM.

use crate::args::RunArguments;
use crate::{service, swarm};
use skein_config::{NodeConfig, Overlay};
use skein_node::{build, stop_asked};
use std::path::PathBuf;

/// Runs a node until it is told to stop.
///
/// # Errors
/// When the configuration is wrong, a plugin is missing or a port is not available.
pub async fn run(arguments: RunArguments) -> anyhow::Result<()> {
    let overlay = Overlay {
        set: arguments.set,
        state: state_directory(),
    };
    let config = NodeConfig::load_with(&arguments.config, &overlay)?;
    let alone = config.swarm.id.is_none();
    if config.hears_nobody() && alone {
        println!(
            "No [[endpoints]] in {}: no vehicle will be heard.",
            arguments.config.display()
        );
    }
    if config.adopt.is_empty() && alone {
        println!(
            "No [[adopt]] rule in {}: vehicles are shown, not flown.",
            arguments.config.display()
        );
    }
    swarm::with_threads_enough(&config.swarm)?;
    let running = build(config).await?;
    if let Some(address) = running.web_address() {
        println!("Dashboard: http://{address}");
    }
    if let Some(swarm) = running.handle().swarm() {
        println!("Swarm:     node {} of {}", swarm.node, swarm.swarm);
    }
    for (name, address) in running.handle().endpoint_addresses() {
        println!("Endpoint:  {name} receives on {address}");
    }
    println!("Stop with Ctrl-C.");
    let node = running.handle();
    tokio::select! {
        asked = stop_asked() => asked?,
        () = service::tell_of(&node) => {}
    }
    service::tell_of_stop();
    println!("Stopping. Ctrl-C again ends at once.");
    let stopped = async {
        running.handle().part(|line| println!("{line}")).await;
        running.stop().await;
    };
    tokio::select! {
        () = stopped => {}
        asked = stop_asked() => {
            asked?;
            println!("Ending at once.");
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
