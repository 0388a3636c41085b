//! Traces in the terms of [OpenTelemetry](https://opentelemetry.io): what became of a request, on whichever nodes of the swarm. They leave over OTLP
//! (HTTP, protobuf) where the standard's own variables name a collector, `OTEL_EXPORTER_OTLP_ENDPOINT` or `OTEL_EXPORTER_OTLP_TRACES_ENDPOINT`; without
//! them no span is made.
//!
//! - [`start`]: the layer that exports, for whoever sets logging up.
//! - [`traceparent`] and [`follow`]: a trace goes on in another process, as [W3C Trace Context](https://www.w3.org/TR/trace-context/) has it.
//! - [`Export`]: held until the program ends.
//!
//! Must never do: let who flies wait for a collector. Spans that it does not take in time are dropped.

#![forbid(unsafe_code)]

use opentelemetry::global;
use opentelemetry::trace::TracerProvider as _;
use opentelemetry_otlp::ExporterBuildError;
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::propagation::TraceContextPropagator;
use opentelemetry_sdk::trace::SdkTracerProvider;
use std::collections::HashMap;
use tracing::level_filters::LevelFilter;
use tracing::{Span, Subscriber};
use tracing_opentelemetry::OpenTelemetrySpanExt;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::registry::LookupSpan;

/// The crates whose spans are exported, with what is logged inside of them.
const ROOMS: [&str; 2] = ["skein_api", "skein_runtime"];
/// Variables that name a collector.
const ENDPOINTS: [&str; 2] = ["OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT"];
/// The header of W3C Trace Context.
pub const TRACEPARENT: &str = "traceparent";

/// What exports; its end sends what is still to be sent.
#[derive(Debug, Default)]
pub struct Export(Option<SdkTracerProvider>);

impl Drop for Export {
    fn drop(&mut self) {
        if let Some(provider) = &self.0
            && let Err(error) = provider.shutdown()
        {
            tracing::warn!(%error, "the last traces did not reach their collector");
        }
    }
}

/// The layer that exports spans, if the environment names a collector, and what keeps it going.
///
/// # Errors
/// When a variable has a value that cannot be.
pub fn start<S>() -> Result<(Option<impl Layer<S>>, Export), ExporterBuildError>
where
    S: Subscriber + for<'span> LookupSpan<'span>,
{
    let named = |key: &&str| std::env::var_os(key).is_some_and(|value| !value.is_empty());
    if !ENDPOINTS.iter().any(named) {
        return Ok((None, Export::default()));
    }
    let exporter = opentelemetry_otlp::SpanExporter::builder().with_http().build()?;
    // Under a name of the operator's, if `OTEL_SERVICE_NAME` has one.
    let resource = match std::env::var_os("OTEL_SERVICE_NAME") {
        Some(_) => Resource::builder(),
        None => Resource::builder().with_service_name("skein"),
    };
    let provider = SdkTracerProvider::builder()
        .with_batch_exporter(exporter)
        .with_resource(resource.build())
        .build();
    global::set_text_map_propagator(TraceContextPropagator::new());
    let layer = tracing_opentelemetry::layer()
        .with_tracer(provider.tracer("skein"))
        .with_filter(Targets::new().with_targets(ROOMS.map(|room| (room, LevelFilter::DEBUG))));
    Ok((Some(layer), Export(Some(provider))))
}

/// Where the present span stands in its trace, for another process; nothing if none is exported.
#[must_use]
pub fn traceparent() -> Option<String> {
    let mut carrier = HashMap::new();
    let context = Span::current().context();
    global::get_text_map_propagator(|propagator| propagator.inject_context(&context, &mut carrier));
    carrier.remove(TRACEPARENT)
}

/// Makes a span that was not entered yet go on with a trace from elsewhere. What is no [`traceparent`] changes nothing.
pub fn follow(span: &Span, traceparent: Option<&str>) {
    if let Some(traceparent) = traceparent {
        let carrier = HashMap::from([(TRACEPARENT.to_owned(), traceparent.to_owned())]);
        let context = global::get_text_map_propagator(|propagator| propagator.extract(&carrier));
        // Not possible where no span is made.
        let _ = span.set_parent(context);
    }
}
