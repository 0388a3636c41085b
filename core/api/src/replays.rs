//! Recorded flights that are looked at beside the node that flies: each is served below its own path, with the dashboard and all routes of a node,
//! by a router of its own.
//!
//! Must never do: hand a request on to the node that flies.

use crate::app::{App, Closing};
use crate::error::ApiError;
use crate::flights;
use crate::open_replays::OpenReplays;
use crate::webrtc::LocalAddress;
use axum::Router;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, Request, State};
use axum::http::Uri;
use axum::response::{IntoResponse, Redirect, Response};
use hyper::upgrade::OnUpgrade;
use skein_replay::Replay;
use tower::ServiceExt;

/// The page stands below its path: what it loads is named from there.
///
/// As it was asked for, still encoded: a name that was decoded could lead to another host.
pub(crate) async fn to_the_page(uri: Uri) -> Redirect {
    Redirect::permanent(&format!("{}/", uri.path()))
}

/// The page.
pub(crate) async fn first(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let Path(name) = name?;
    pass_on(&app, name, request).await
}

/// All that is below it.
pub(crate) async fn rest(
    State(app): State<App>,
    path: Result<Path<(String, String)>, PathRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let Path((name, _)) = path?;
    pass_on(&app, name, request).await
}

async fn pass_on(app: &App, name: String, request: Request) -> Result<Response, ApiError> {
    let uri = request.uri().clone();
    // As it was asked for, still encoded: `/replay/FILE/REST`.
    let rest = uri.path().splitn(4, '/').nth(3).unwrap_or_default();
    let not_found = || ApiError::not_found(&uri);
    let replays = app.replays.as_ref().ok_or_else(not_found)?;
    if rest.is_empty() {
        replays.forget_unfinished(&name);
    }
    let router = match replays.router(&name) {
        Some(router) => router,
        None => open(app, replays, name).await?,
    };
    let query = uri.query().map_or_else(String::new, |query| format!("?{query}"));
    let below = format!("/{rest}{query}");
    let below = below.parse::<Uri>().map_err(|_| not_found())?;
    let answered = router.oneshot(moved(request, below)).await;
    Ok(answered.map_or_else(|never| match never {}, IntoResponse::into_response))
}

/// The request as if it had come to the other router, without what this one made of its path.
fn moved(request: Request, to: Uri) -> Request {
    let (mut parts, body) = request.into_parts();
    let mut before = std::mem::take(&mut parts.extensions);
    if let Some(upgrade) = before.remove::<OnUpgrade>() {
        parts.extensions.insert(upgrade);
    }
    if let Some(address) = before.remove::<LocalAddress>() {
        parts.extensions.insert(address);
    }
    if let Some(closing) = before.remove::<Closing>() {
        parts.extensions.insert(closing);
    }
    parts.uri = to;
    Request::from_parts(parts, body)
}

async fn open(app: &App, replays: &OpenReplays, name: String) -> Result<Router, ApiError> {
    let path = flights::path_of(app, &name)?;
    let unreadable = || ApiError::UnreadableRecording { file: name.clone() };
    let opened = tokio::task::spawn_blocking(move || Replay::open(&path)).await;
    let replay = opened.ok().and_then(Result::ok).ok_or_else(unreadable)?;
    replays.add(name, replay)
}
