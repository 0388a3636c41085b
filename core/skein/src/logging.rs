//! Structured logs to standard error, as text or JSON.

use crate::args::LogFormat;
use tracing_subscriber::EnvFilter;

/// Parts of libraries that report the ordinary as a fault: RustDDS a participant that leaves and what goes with it, Zenoh a declaration that was lost on a radio. Who names them in the
/// filter hears them.
const QUIET: &str = "rustdds::rtps::writer=off,rustdds::dds::pubsub=off,rustdds::network=off,zenoh::net::routing=off";

/// Sets logging up for the whole process.
///
/// # Errors
/// When the filter does not parse.
pub fn start(format: LogFormat, filter: &str) -> anyhow::Result<()> {
    let filter = EnvFilter::try_new(format!("{QUIET},{filter}")).map_err(|e| {
        anyhow::anyhow!("--log \"{filter}\" is not a filter: {e}; try \"info\" or \"info,skein_link_mavlink=debug\"")
    })?;
    let builder = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr);
    match format {
        LogFormat::Text => builder.init(),
        LogFormat::Json => builder.json().init(),
    }
    Ok(())
}
