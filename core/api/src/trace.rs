//! A span for each request: see `skein_telemetry`.
//!
//! Must never do: write down more than the path. A query and headers may hold what somebody would not want in a log.

use axum::Router;
use axum::http::Request;
use axum::response::Response;
use std::time::Duration;
use tower_http::trace::TraceLayer;
use tracing::Span;
use tracing::field::Empty;

/// The routes, each request in a span of its own.
pub(crate) fn traced(routes: Router) -> Router {
    routes.layer(TraceLayer::new_for_http().make_span_with(begun).on_response(answered))
}

fn begun<B>(request: &Request<B>) -> Span {
    let (method, path) = (request.method(), request.uri().path());
    let span = tracing::debug_span!(
        "request",
        otel.name = format!("{method} {path}"),
        otel.kind = "server",
        otel.status_code = Empty,
        http.request.method = %method,
        url.path = path,
        http.response.status_code = Empty,
    );
    let parent = request
        .headers()
        .get(skein_telemetry::TRACEPARENT)
        .and_then(|value| value.to_str().ok());
    skein_telemetry::follow(&span, parent);
    span
}

fn answered<B>(response: &Response<B>, latency: Duration, span: &Span) {
    let status = response.status();
    span.record("http.response.status_code", status.as_u16());
    if status.is_server_error() {
        span.record("otel.status_code", "ERROR");
    }
    tracing::debug!(
        status = status.as_u16(),
        latency_ms = latency.as_secs_f64() * 1e3,
        "answered"
    );
}
