//! Records who changed what over the API: method, path, body and outcome of each request that changes something.
//!
//! Must never do: record a secret, hold up a request, or record what sensors tell many times a second.

use crate::app::App;
use crate::control;
use crate::operators;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use serde_json::Value;
use skein_view::Audit;

/// A body is recorded up to so many bytes; longer ones are plugins and the like, of which the length is.
const LONGEST_BODY: usize = 8 * 1024;
/// What programs tell again and again and no operator does.
const TOLD_OFTEN: [(Method, &str); 4] = [
    (Method::POST, "/api/v1/detections"),
    (Method::PUT, "/api/v1/references/"),
    (Method::PUT, "/api/v1/tracks"),
    (Method::POST, "/api/v1/operator/alive"),
];
/// What is done below this path changes what is shown of a recorded flight.
const REPLAYS: &str = "/replay/";
/// Fields of a body that are secrets.
const SECRETS: [&str; 4] = ["key", "token", "secret", "password"];

/// Around every route.
pub(crate) async fn record(State(app): State<App>, request: Request, next: Next) -> Response {
    let reads_only = matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    let path = request.uri().path().to_owned();
    let often = |(method, begin): &(Method, &str)| request.method() == method && path.starts_with(begin);
    let is_replay = path.starts_with(REPLAYS);
    if is_replay || reads_only || TOLD_OFTEN.iter().any(often) || !app.node.tape().is_on() {
        return next.run(request).await;
    }
    let what = format!("{} {path}", request.method());
    let who = who(&app, request.headers());
    let (request, with) = match with(request).await {
        Ok(read) => read,
        Err(answer) => return answer,
    };
    let response = next.run(request).await;
    let (response, outcome) = outcome(response).await;
    app.node.audit(|| Audit {
        time: app.node.now(),
        who,
        over: "api".to_owned(),
        what,
        with,
        outcome,
    });
    response
}

/// The operator that a secret names, or the console that the request names.
fn who(app: &App, headers: &HeaderMap) -> String {
    if let Some(operator) = operators::named(&app.node, headers) {
        return operator.name;
    }
    let console = headers.get(control::HEADER).and_then(|value| value.to_str().ok());
    let Some(console) = console.filter(|id| !id.is_empty()) else {
        return String::new();
    };
    match app.node.console_name(console) {
        Some(name) => format!("{name} ({console})"),
        None => console.chars().take(80).collect(),
    }
}

/// The request as it came, and its body as it is recorded.
async fn with(request: Request) -> Result<(Request, String), Response> {
    let length = request.headers().get(header::CONTENT_LENGTH);
    let length = length.and_then(|value| value.to_str().ok()?.parse::<usize>().ok());
    match length {
        Some(0) => Ok((request, String::new())),
        Some(length) if length <= LONGEST_BODY => {
            let (parts, body) = request.into_parts();
            let bytes = to_bytes(body, LONGEST_BODY).await.map_err(|_| {
                // It was cut off on its way: nothing of it is carried out.
                axum::http::StatusCode::BAD_REQUEST.into_response()
            })?;
            let told = told(&bytes);
            Ok((Request::from_parts(parts, Body::from(bytes)), told))
        }
        Some(length) => Ok((request, format!("{length} bytes"))),
        None => Ok((request, String::new())),
    }
}

/// A body without its secrets.
fn told(bytes: &Bytes) -> String {
    match serde_json::from_slice::<Value>(bytes) {
        Ok(mut value) => {
            hide(&mut value);
            value.to_string()
        }
        Err(_) => format!("{} bytes", bytes.len()),
    }
}

fn hide(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                if SECRETS.contains(&name.as_str()) {
                    *field = Value::String("hidden".to_owned());
                } else {
                    hide(field);
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(hide),
        _ => {}
    }
}

/// The status, and of a refusal what it says.
async fn outcome(response: Response) -> (Response, String) {
    let status = response.status();
    if status.is_success() {
        return (response, status.as_u16().to_string());
    }
    let (parts, body) = response.into_parts();
    let bytes = to_bytes(body, LONGEST_BODY).await.unwrap_or_default();
    let message = serde_json::from_slice::<Value>(&bytes).ok();
    let message = message.and_then(|value| Some(value.get("error")?.get("message")?.as_str()?.to_owned()));
    let outcome = format!("{} {}", status.as_u16(), message.unwrap_or_default());
    (
        Response::from_parts(parts, Body::from(bytes)),
        outcome.trim_end().to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_secret_is_hidden_wherever_it_stands() {
        let body = Bytes::from_static(br#"{"key":"opensesame","of":[{"token":1,"name":"a"}]}"#);
        let told_of: Value = serde_json::from_str(&told(&body)).expect("is JSON");
        assert_eq!(
            told_of,
            json!({ "key": "hidden", "of": [{ "token": "hidden", "name": "a" }] })
        );
        assert_eq!(told(&Bytes::from_static(b"\x7fELF")), "4 bytes");
    }
}
