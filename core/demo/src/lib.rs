//! `skein demo`: simulated vehicles and a node in one process, joined by real MAVLink over real sockets. A director gives the
//! commands an operator would give; a referee watches the simulator's truth, not what the node believes. With `--listen` the vehicles are
//! autopilots that are there already, a real PX4 in its own simulation say; the referee then has their reports only. The three types to know:
//! [`DemoArguments`], `ScenarioRunner` (what a scenario flies on), `Referee` (what judges it).
//!
//! Must never do: fly anything by itself; a scenario gives the commands that an operator would give.
#![forbid(unsafe_code)]

mod args;
mod drills;
mod fleet;
mod layout;
mod link_cuts;
mod referee;
pub mod report;
mod reports;
mod scenario;
mod scenario_runner;
mod steps;

pub use args::{DemoArguments, DemoLink, FaultPlan, Scenario, SimulatedKind};

use anyhow::{Context, bail};
use drills::Drills;
use layout::Layout;
use link_cuts::LinkCuts;
use referee::Referee;
use scenario::{Chosen, Flight, Setup};
use scenario_runner::ScenarioRunner;
use skein_config::{EndpointSettings, NodeConfig, PluginSettings};
use skein_node::{Running, build, flights_of_user, plugins_beside_program, stop_asked, tell};
use skein_sim::{Faces, PayloadPlan, PortPlan, SimSettings, Simulation};
use skein_sim_dds::DdsSettings;
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::pin::Pin;
use std::process::ExitCode;
use std::time::Duration;

/// Name of the demo's one endpoint.
const ENDPOINT: &str = "simulation";

/// Runs the demonstration. No `async fn`: the compiler makes the code of one in every crate that awaits it.
///
/// # Errors
/// When the node or the simulation cannot be started, or the flight breaks off.
pub fn demo(arguments: DemoArguments) -> Pin<Box<dyn Future<Output = anyhow::Result<ExitCode>>>> {
    Box::pin(flown(arguments))
}

async fn flown(arguments: DemoArguments) -> anyhow::Result<ExitCode> {
    if arguments.faults == Some(FaultPlan::Links) && arguments.link != DemoLink::Both {
        bail!("--faults links cuts one of two links: add --link both");
    }
    let layout = Layout::plan(usize::from(arguments.count()), arguments.seconds.map(f64::from));
    let described = layout.describe();
    let mut setup = Setup {
        vehicles: arguments.count(),
        node: configuration(&arguments, &layout),
        simulation: simulation(&arguments),
    };
    let take_off_stagger_s = layout.take_off_stagger_s;
    let mut flight = Chosen::new(arguments.scenario, layout);
    flight.prepare(&mut setup);
    let domain_id = setup.node.dds.domain_id;
    let running = build(setup.node).await?;
    let simulation = if arguments.listen.is_empty() {
        Some(simulate(setup.simulation, &running, domain_id)?)
    } else {
        None
    };
    say_where(&arguments, &running, domain_id);
    let outcome = if arguments.manual {
        tell(format_args!(
            "{} vehicles are yours to fly. Stop with Ctrl-C.",
            arguments.count()
        ));
        Ok(stop_asked().await.map(|()| ExitCode::SUCCESS)?)
    } else {
        tokio::select! {
            flown = async {
                if arguments.scenario == Scenario::Tour {
                    tell(&described);
                }
                let (referee, reports) = referee(simulation.as_ref(), &running)?;
                let count = usize::from(arguments.count());
                let runner = ScenarioRunner::new(running.handle(), simulation.as_ref(), &referee, count, take_off_stagger_s);
                fly(&arguments, &mut flight, &runner, reports.as_ref()).await
            } => flown,
            asked = stop_asked() => asked.map_err(anyhow::Error::from).and_then(|()| bail!("stopped before the flight was over")),
        }
    };
    let outcome = match outcome {
        Ok(code) if !arguments.headless && !arguments.manual => {
            tell("The dashboard stays open: the vehicles are yours to fly. Stop with Ctrl-C.");
            Ok(stop_asked().await.map(|()| code)?)
        }
        other => other,
    };
    end(simulation, running).await;
    outcome
}

/// Where to look at it.
fn say_where(arguments: &DemoArguments, running: &Running, domain_id: u16) {
    if arguments.link != DemoLink::Mavlink {
        tell(format_args!(
            "The vehicles' topics are in DDS domain {domain_id}, on this computer alone."
        ));
    }
    if let Some(address) = running.web_address() {
        tell(format_args!(
            "Dashboard: http://{address}{}",
            why_not_usual(arguments, address)
        ));
    }
}

/// Ends what flies, and says where it was recorded.
async fn end(simulation: Option<Simulation>, running: Running) {
    let recorded = running.handle().config().recorder.folder.clone();
    match simulation {
        Some(simulation) => simulation.stop(),
        None => running.handle().part(|line| tell(line)).await,
    }
    running.stop().await;
    if let Some(folder) = recorded {
        tell(format_args!(
            "Recorded in {}: `skein log list` shows it, `skein report` makes a report of a flight.",
            folder.display()
        ));
    }
}

/// Who judges the flight, and what feeds it, if it is not the simulation itself.
fn referee(simulation: Option<&Simulation>, running: &Running) -> anyhow::Result<(Referee, Option<reports::Watch>)> {
    if let Some(simulation) = simulation {
        return Ok((Referee::watch(simulation, running.handle())?, None));
    }
    let referee = Referee::new(running.handle());
    let watch = reports::watch(&referee, running.handle())?;
    Ok((referee, Some(watch)))
}

/// The demonstration's one endpoint, or those where autopilots are heard.
fn endpoints(arguments: &DemoArguments) -> Vec<EndpointSettings> {
    if arguments.listen.is_empty() {
        return vec![EndpointSettings {
            name: Some(ENDPOINT.into()),
            address: "udp-listen://127.0.0.1:0".into(),
        }];
    }
    let heard = |address: &String| EndpointSettings {
        name: None,
        address: address.clone(),
    };
    arguments.listen.iter().map(heard).collect()
}

fn configuration(arguments: &DemoArguments, layout: &Layout) -> NodeConfig {
    let port = arguments.port.unwrap_or_else(|| usual_or_free(USUAL_PORT));
    let mut config = NodeConfig {
        endpoints: endpoints(arguments),
        adopt: fleet::rules(arguments),
        plugins: PluginSettings {
            directories: plugin_directories(&arguments.plugins),
            ..PluginSettings::default()
        },
        ..NodeConfig::default()
    };
    config.node.name = "demo".into();
    // Of autopilots that are there already only they themselves know.
    config.node.simulated = arguments.listen.is_empty();
    config.recorder.folder = arguments.record.clone().or_else(flights_of_user);
    config.dds.domain_id = own_domain();
    config.web.listen = SocketAddr::from(([127, 0, 0, 1], port));
    config.coordinator.take_off_stagger_s = layout.take_off_stagger_s;
    config.coordinator.transition_speed_m_s = layout::TRANSITION_SPEED_M_S;
    config.faults.enabled = arguments.faults.is_some() || arguments.manual || arguments.scenario != Scenario::Tour;
    config
}

/// The port of the dashboard, if nobody names one and no other program has it.
const USUAL_PORT: u16 = 8080;

/// Why the dashboard is not where it usually is.
fn why_not_usual(arguments: &DemoArguments, address: SocketAddr) -> &'static str {
    match arguments.port {
        None if address.port() != USUAL_PORT => " (another program has port 8080)",
        _ => "",
    }
}

/// A port, or 0 for one that the system chooses, where another program has it.
fn usual_or_free(port: u16) -> u16 {
    match TcpListener::bind(("127.0.0.1", port)) {
        Ok(_) => port,
        Err(_) => 0,
    }
}

/// A DDS domain of this demonstration's own: in the usual one there may be vehicles that are real.
fn own_domain() -> u16 {
    const DOMAINS: u32 = 100;
    (std::process::id() % DOMAINS) as u16 + 1
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

fn simulation(arguments: &DemoArguments) -> SimSettings {
    SimSettings {
        vehicles: usize::from(arguments.count()),
        seed: arguments.seed,
        spacing_m: layout::SPACING_M,
        airframe: arguments.airframe.into(),
        payloads: PayloadPlan::all(),
        parameters: fleet::parameters(),
        faces: match arguments.link {
            DemoLink::Mavlink => Faces::Mavlink,
            DemoLink::Dds => Faces::Dds,
            DemoLink::Both => Faces::Both,
        },
        ..SimSettings::default()
    }
}

fn simulate(settings: SimSettings, running: &Running, domain_id: u16) -> anyhow::Result<Simulation> {
    let address = running.handle().endpoint_addresses().get(ENDPOINT).copied();
    let address = address.context("the demo's endpoint is not bound")?;
    let settings = SimSettings {
        ports: PortPlan::SendTo(address),
        ..settings
    };
    if settings.faces == Faces::Mavlink {
        return Ok(Simulation::start(settings)?);
    }
    let dds = DdsSettings {
        domain_id,
        ..DdsSettings::default()
    };
    Ok(skein_sim_dds::start(settings, &dds)?)
}

async fn fly(
    arguments: &DemoArguments,
    flight: &mut Chosen,
    runner: &ScenarioRunner<'_>,
    reports: Option<&reports::Watch>,
) -> anyhow::Result<ExitCode> {
    let cuts = LinkCuts::default();
    let drills = arguments
        .faults
        .filter(|plan| *plan != FaultPlan::Links)
        .map(|plan| Drills::start(plan, runner.node.clone(), arguments.seed));
    let flown = if arguments.faults == Some(FaultPlan::Links) {
        tokio::select! {
            flown = flight.fly(runner) => flown,
            failed = cuts.cut_in_turn(runner) => Err(failed),
        }
    } else {
        flight.fly(runner).await
    };
    let flight_s = flown.is_ok().then(|| runner.elapsed_s());
    let faults = drills.map_or(cuts.made(), Drills::stop);
    // The last frames of the truth are in when the referee has seen one more.
    tokio::time::sleep(Duration::from_millis(100)).await;
    let mut criteria = flight.criteria(runner.referee);
    if arguments.faults == Some(FaultPlan::Links) {
        criteria.extend(cuts.criteria(usize::from(arguments.count())));
    }
    let outcome = report::Outcome {
        criteria,
        flight_s,
        faults,
        setpoints_missing: reports.map(reports::Watch::missing),
        broke_off: flown.as_ref().err(),
    };
    let report = report::make(arguments, &runner.node, runner.referee, outcome);
    if let Some(file) = &arguments.report {
        let json = serde_json::to_string_pretty(&report)?;
        std::fs::write(file, json + "\n").with_context(|| format!("cannot write the report to {}", file.display()))?;
        tell(format_args!("Report: {}", file.display()));
    }
    tell(report.describe().trim_end());
    Ok(if report.passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
