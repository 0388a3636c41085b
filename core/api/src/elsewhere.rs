//! Requests about a vehicle that another node of the swarm flies: answered there, by the same routes, and passed on as they are. An
//! observer's gateway passes nothing on that changes anything.
//!
//! Must never do: pass on what came from another node.

use crate::app::App;
use crate::control::HEADER;
use crate::error::ApiError;
use crate::{body, endpoints, trace};
use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use skein_domain::{NodeId, Refusal, VehicleId};
use skein_runtime::NodeHandle;
use skein_state::asks::{ApiAnswer, ApiRequest, ApiServer};
use skein_view::NodeRole;
use std::sync::Arc;
use tower::ServiceExt;

/// Answers of another node are no larger than this.
const LARGEST_ANSWER: usize = 8 << 20;
/// Headers of an answer that come along: what the body is.
const PASSED_ON: [HeaderName; 3] = [
    header::CONTENT_TYPE,
    header::CACHE_CONTROL,
    header::CONTENT_SECURITY_POLICY,
];

/// Which vehicle's own routes a path is one of; what is said of a vehicle in general every node knows. Video does not end, so that it cannot be
/// passed on as an answer.
fn vehicle_of(path: &str) -> Option<VehicleId> {
    let (id, rest) = path.strip_prefix("/api/v1/vehicles/")?.split_once('/')?;
    let passed_on = !rest.is_empty() && !is_video(rest);
    id.parse().ok().filter(|_| passed_on).map(VehicleId)
}

/// Whether a path behind the vehicle's id is `payloads/NAME/video…`.
fn is_video(rest: &str) -> bool {
    rest.starts_with("payloads/") && rest.split('/').nth(2) == Some("video")
}

/// Around every route of a gateway.
///
/// # Errors
/// When this node commands nothing, or the other one does not answer.
pub async fn to_the_vehicles_node(State(app): State<App>, request: Request, next: Next) -> Result<Response, ApiError> {
    let reads_only = matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    if !reads_only && is_observer(&app.node) {
        return Err(Refusal::not_permitted("this node is an observer: it watches, and commands nothing").into());
    }
    match vehicle_of(request.uri().path()).and_then(|id| app.node.host_elsewhere(id)) {
        Some(node) => pass_on(&app.node, node, request).await,
        None => Ok(next.run(request).await),
    }
}

fn is_observer(node: &NodeHandle) -> bool {
    node.swarm()
        .is_some_and(|swarm| swarm.roles.contains(&NodeRole::Observer))
}

async fn pass_on(node: &NodeHandle, to: NodeId, request: Request) -> Result<Response, ApiError> {
    let (parts, body) = request.into_parts();
    let body = to_bytes(body, body::MAX_BODY_BYTES)
        .await
        .map_err(|_| ApiError::TooSlow)?;
    let text = |value: &HeaderValue| value.to_str().ok().map(str::to_owned);
    let path = parts.uri.path_and_query().map_or_else(String::new, ToString::to_string);
    let answer = node
        .api_elsewhere(
            to,
            ApiRequest {
                method: parts.method.to_string(),
                path,
                content_type: parts.headers.get(header::CONTENT_TYPE).and_then(text),
                // Control authority over a vehicle holds at every node.
                console: parts.headers.get(HEADER).and_then(text),
                traceparent: skein_telemetry::traceparent(),
                body: body.to_vec(),
            },
        )
        .await?;
    let status = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::BAD_GATEWAY);
    let mut response = (status, Bytes::from(answer.body)).into_response();
    for (name, value) in answer.headers {
        if let (Ok(name), Ok(value)) = (name.parse::<HeaderName>(), value.parse::<HeaderValue>())
            && PASSED_ON.contains(&name)
        {
            response.headers_mut().insert(name, value);
        }
    }
    Ok(response)
}

/// Answers what came in at other nodes' gateways with this node's own routes, and nothing that would be passed on once more.
#[must_use]
pub fn serve_others(node: NodeHandle) -> ApiServer {
    let app = App::new(node, Bytes::new());
    let routes = endpoints::all()
        .into_iter()
        .filter(|one| one.path.starts_with("/api/v1/vehicles/") && one.tag != endpoints::VIDEO)
        .fold(Router::new(), |routes, one| routes.route(one.path, one.handler))
        .with_state(app)
        .layer(DefaultBodyLimit::max(body::MAX_BODY_BYTES));
    let routes = trace::traced(routes);
    Arc::new(move |request| {
        let routes = routes.clone();
        Box::pin(async move { answer(routes, request).await })
    })
}

async fn answer(routes: Router, asked: ApiRequest) -> ApiAnswer {
    let mut request = Request::builder().method(asked.method.as_str()).uri(asked.path);
    if let Some(kind) = asked.content_type {
        request = request.header(header::CONTENT_TYPE, kind);
    }
    if let Some(console) = asked.console {
        request = request.header(HEADER, console);
    }
    if let Some(traceparent) = asked.traceparent {
        request = request.header(skein_telemetry::TRACEPARENT, traceparent);
    }
    let failed = |status: StatusCode| ApiAnswer {
        status: status.as_u16(),
        headers: Vec::new(),
        body: Vec::new(),
    };
    let Ok(request) = request.body(Body::from(asked.body)) else {
        return failed(StatusCode::BAD_REQUEST);
    };
    // A router fails at nothing; what its routes refuse is an answer.
    let Ok(response) = routes.oneshot(request).await;
    let (parts, body) = response.into_parts();
    let Ok(body) = to_bytes(body, LARGEST_ANSWER).await else {
        return failed(StatusCode::INTERNAL_SERVER_ERROR);
    };
    let kept = |name: &HeaderName| Some((name.to_string(), parts.headers.get(name)?.to_str().ok()?.to_owned()));
    ApiAnswer {
        status: parts.status.as_u16(),
        headers: PASSED_ON.iter().filter_map(kept).collect(),
        body: body.to_vec(),
    }
}

#[cfg(test)]
mod tests;
