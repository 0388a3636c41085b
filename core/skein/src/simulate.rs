//! `skein sim`: simulated vehicles only, on the ports of PX4's own simulation or sent to one address.

use crate::args::SimArguments;
use anyhow::{Context, bail};
use skein_node::{stop_asked, tell};
use skein_sim::truth_lines::TruthLines;
use skein_sim::{PortPlan, SimSettings, Simulation};
use std::fs::File;
use std::time::Duration;

/// Runs simulated vehicles until it is told to stop.
///
/// # Errors
/// When a port is in use or the system ids do not fit.
pub async fn simulate(arguments: SimArguments) -> anyhow::Result<()> {
    let last = u16::from(arguments.first_system_id) + u16::from(arguments.vehicles) - 1;
    if last > 255 {
        bail!("system ids would run to {last}; the greatest is 255");
    }
    let ports = arguments.send_to.map_or(PortPlan::Px4, PortPlan::SendTo);
    let mut settings = SimSettings {
        vehicles: usize::from(arguments.vehicles),
        first_system_id: arguments.first_system_id,
        seed: arguments.seed,
        spacing_m: arguments.spacing_m,
        airframe: arguments.airframe.into(),
        ports,
        ..SimSettings::default()
    };
    if let Some(origin) = arguments.origin {
        settings.origin = origin;
    }
    settings.starts = settings.places();
    for start in &mut settings.starts {
        start.position.north_m += arguments.at.north_m;
        start.position.east_m += arguments.at.east_m;
    }
    let simulation = Simulation::start(settings)?;
    if let Some(path) = &arguments.truth {
        let file = File::create(path).with_context(|| format!("cannot write the truth to {}", path.display()))?;
        let mut lines = TruthLines::new(file);
        simulation.observe(Box::new(move |frame| lines.look(frame)))?;
    }
    tell(format_args!(
        "{} vehicles, system ids {} to {last}.",
        arguments.vehicles, arguments.first_system_id
    ));
    match arguments.send_to {
        Some(address) => tell(format_args!("Every vehicle sends to {address}.")),
        None => tell(format_args!(
            "Onboard links: 14580+N sends to 127.0.0.1:14540+N (from the eleventh on all to 14549).\n\
             Ground-station links: 18570+N sends to 127.0.0.1:14550."
        )),
    }
    tell("Stop with Ctrl-C.");
    match arguments.seconds {
        Some(seconds) => {
            tokio::select! {
                () = tokio::time::sleep(Duration::from_secs_f64(seconds.max(0.0))) => {}
                asked = stop_asked() => asked?,
            }
        }
        None => stop_asked().await?,
    }
    simulation.stop();
    Ok(())
}
