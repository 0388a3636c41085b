//! `skein demo`: simulated vehicles and a node in one process, joined by real MAVLink over real sockets. A director gives the
//! commands an operator would give; a referee watches the simulator's truth, not what the node believes.

mod director;
mod drills;
mod fleet;
mod layout;
mod referee;
pub mod report;

use crate::args::DemoArguments;
use crate::build::{Running, build, plugins_beside_program};
use crate::run::stop_asked;
use anyhow::{Context, bail};
use director::Director;
use drills::Drills;
use layout::Layout;
use referee::Referee;
use skein_config::{EndpointSettings, NodeConfig, PluginSettings};
use skein_sim::{PayloadPlan, PortPlan, SimSettings, Simulation};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Name of the demo's one endpoint.
const ENDPOINT: &str = "simulation";

/// Runs the demonstration.
///
/// # Errors
/// When the node or the simulation cannot be started, or the flight breaks off.
pub async fn demo(arguments: DemoArguments) -> anyhow::Result<ExitCode> {
    let layout = Layout::plan(usize::from(arguments.vehicles), arguments.seconds.map(f64::from));
    let running = build(configuration(&arguments, &layout)).await?;
    let simulation = simulate(&arguments, &running)?;
    println!("Dashboard: http://{}", running.web_address());
    let outcome = if arguments.manual {
        println!(
            "{} simulated vehicles are yours to fly. Stop with Ctrl-C.",
            arguments.vehicles
        );
        stop_asked().await.map(|()| ExitCode::SUCCESS)
    } else {
        tokio::select! {
            flown = fly(&arguments, &layout, &running, &simulation) => flown,
            asked = stop_asked() => asked.and_then(|()| bail!("stopped before the flight was over")),
        }
    };
    let outcome = match outcome {
        Ok(code) if !arguments.headless && !arguments.manual => {
            println!("The dashboard stays open: the vehicles are yours to fly. Stop with Ctrl-C.");
            stop_asked().await.map(|()| code)
        }
        other => other,
    };
    simulation.stop();
    running.stop().await;
    outcome
}

fn configuration(arguments: &DemoArguments, layout: &Layout) -> NodeConfig {
    let port = arguments.port;
    let mut config = NodeConfig {
        endpoints: vec![EndpointSettings {
            name: Some(ENDPOINT.into()),
            address: "udp-listen://127.0.0.1:0".into(),
        }],
        adopt: fleet::rules(arguments.vehicles, arguments.model.as_deref(), arguments.faults),
        plugins: PluginSettings {
            directories: plugin_directories(&arguments.plugins),
            ..PluginSettings::default()
        },
        ..NodeConfig::default()
    };
    config.node.name = "demo".into();
    config.web.listen = SocketAddr::from(([127, 0, 0, 1], port));
    config.coordinator.take_off_stagger_s = layout.take_off_stagger_s;
    config.coordinator.transition_speed_m_s = layout::TRANSITION_SPEED_M_S;
    config.faults.enabled = arguments.faults.is_some() || arguments.manual;
    config
}

/// Those asked for, and the one beside the program if it is not among them.
fn plugin_directories(asked: &[PathBuf]) -> Vec<PathBuf> {
    let shipped = plugins_beside_program();
    let is_shipped = |directory: &PathBuf| directory.canonicalize().ok() == shipped.canonicalize().ok();
    let mut directories = asked.to_vec();
    if !directories.iter().any(is_shipped) {
        directories.push(shipped);
    }
    directories
}

fn simulate(arguments: &DemoArguments, running: &Running) -> anyhow::Result<Simulation> {
    let address = running.handle().endpoint_addresses().get(ENDPOINT).copied();
    let address = address.context("the demo's endpoint is not bound")?;
    let settings = SimSettings {
        vehicles: usize::from(arguments.vehicles),
        seed: arguments.seed,
        spacing_m: layout::SPACING_M,
        ports: PortPlan::SendTo(address),
        payloads: PayloadPlan::all(),
        ..SimSettings::default()
    };
    Ok(Simulation::start(settings)?)
}

async fn fly(
    arguments: &DemoArguments,
    layout: &Layout,
    running: &Running,
    simulation: &Simulation,
) -> anyhow::Result<ExitCode> {
    println!("{}", layout.describe());
    let referee = Referee::watch(simulation, running.handle())?;
    let drills = arguments
        .faults
        .map(|plan| Drills::start(plan, running.handle(), arguments.seed));
    let mut director = Director::new(running.handle(), layout, &referee);
    let flown = director.fly().await;
    let faults_injected = drills.map_or(0, Drills::stop);
    // The last frames of the truth are in when the referee has seen one more.
    tokio::time::sleep(Duration::from_millis(100)).await;
    let report = report::make(arguments, &director, &referee, faults_injected, flown.as_ref().err());
    if let Some(file) = &arguments.report {
        let json = serde_json::to_string_pretty(&report)?;
        std::fs::write(file, json + "\n").with_context(|| format!("cannot write the report to {}", file.display()))?;
        println!("Report: {}", file.display());
    }
    print!("{}", report.describe());
    Ok(if report.passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(crate::exit::FAILED)
    })
}
