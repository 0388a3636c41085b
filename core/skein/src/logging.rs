//! Structured logs to standard error, as text or JSON, and traces to where the environment says.

use crate::args::LogFormat;
use anyhow::Context;
use skein_telemetry::Export;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

/// Parts of libraries that report the ordinary as a fault: RustDDS a participant that leaves and what goes with it, Zenoh a declaration that was lost on a radio. Who names them in the
/// filter hears them.
const QUIET: &str = "rustdds::rtps::writer=off,rustdds::dds::pubsub=off,rustdds::network=off,zenoh::net::routing=off";

/// Sets logging up for the whole process, and what exports traces, which is to be kept until its end.
///
/// # Errors
/// When the filter does not parse, or traces are to go to a place that cannot be.
pub fn start(format: LogFormat, filter: &str) -> anyhow::Result<Export> {
    let filter = EnvFilter::try_new(format!("{QUIET},{filter}")).map_err(|e| {
        anyhow::anyhow!("--log \"{filter}\" is not a filter: {e}; try \"info\" or \"info,skein_link_mavlink=debug\"")
    })?;
    let (traces, export) = skein_telemetry::start().context("traces cannot be exported")?;
    let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let lines = match format {
        LogFormat::Text => lines.boxed(),
        LogFormat::Json => lines.json().boxed(),
    };
    tracing_subscriber::registry()
        .with(lines.with_filter(filter))
        .with(traces)
        .init();
    Ok(export)
}
