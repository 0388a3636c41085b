//! Recorded flights that are looked at beside the node that flies: each is served below its own path, with the dashboard and all routes of a node,
//! by a router of its own.
//!
//! Must never do: hand a request on to the node that flies.

use crate::app::{App, MAX_STREAMS};
use crate::error::ApiError;
use crate::server::around;
use crate::settings::ApiSettings;
use crate::{flights, openapi};
use axum::Router;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, Request, State};
use axum::http::Uri;
use axum::response::{IntoResponse, Redirect, Response};
use parking_lot::Mutex;
use skein_replay::Replay;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;
use tower::ServiceExt;

/// So many are open at once: each has a thread, and reads a file.
const MOST: usize = 4;
/// One that nobody looks at is closed after so long.
const IDLE: Duration = Duration::from_secs(600);

/// Those that are open.
#[derive(Default)]
pub struct Replays {
    settings: ApiSettings,
    open: Mutex<Vec<Open>>,
}

struct Open {
    file: String,
    router: Router,
    streams: Arc<Semaphore>,
    asked: Instant,
}

impl Open {
    fn is_looked_at(&self) -> bool {
        self.streams.available_permits() < MAX_STREAMS
    }
}

impl Replays {
    /// None yet, served with these settings.
    pub fn new(settings: ApiSettings) -> Self {
        Self {
            settings,
            open: Mutex::default(),
        }
    }

    /// The router of one, if it is open.
    fn router(&self, file: &str) -> Option<Router> {
        let mut open = self.open.lock();
        let one = open.iter_mut().find(|one| one.file == file)?;
        one.asked = Instant::now();
        Some(one.router.clone())
    }

    /// Adds one; another one that nobody looks at goes for it.
    fn add(&self, file: String, replay: Replay) -> Result<Router, ApiError> {
        let mut open = self.open.lock();
        open.retain(|one| one.is_looked_at() || one.asked.elapsed() < IDLE);
        if let Some(one) = open.iter().find(|one| one.file == file) {
            return Ok(one.router.clone());
        }
        if open.len() >= MOST {
            let idle = open.iter().enumerate().filter(|(_, one)| !one.is_looked_at());
            let oldest = idle.min_by_key(|(_, one)| one.asked).map(|(index, _)| index);
            open.remove(oldest.ok_or(ApiError::TooManyReplays { limit: MOST })?);
        }
        let shown = App::of_replay(Arc::new(replay), openapi::document().into());
        let streams = shown.streams.clone();
        let router = around(shown, &self.settings, Router::new());
        open.push(Open {
            file,
            router: router.clone(),
            streams,
            asked: Instant::now(),
        });
        Ok(router)
    }
}

/// The page stands below its path: what it loads is named from there.
pub(crate) async fn to_the_page(name: Result<Path<String>, PathRejection>) -> Result<Redirect, ApiError> {
    let Path(name) = name?;
    Ok(Redirect::permanent(&format!("{name}/")))
}

/// The page.
pub(crate) async fn first(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let Path(name) = name?;
    pass_on(&app, name, "", request).await
}

/// All that is below it.
pub(crate) async fn rest(
    State(app): State<App>,
    path: Result<Path<(String, String)>, PathRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let Path((name, rest)) = path?;
    pass_on(&app, name, &rest, request).await
}

async fn pass_on(app: &App, name: String, rest: &str, mut request: Request) -> Result<Response, ApiError> {
    let router = match app.replays.router(&name) {
        Some(router) => router,
        None => open(app, name).await?,
    };
    let query = request
        .uri()
        .query()
        .map_or_else(String::new, |query| format!("?{query}"));
    let below = format!("/{}{query}", rest.replace(' ', "%20"));
    let not_found = ApiError::not_found(request.uri());
    *request.uri_mut() = below.parse::<Uri>().map_err(|_| not_found)?;
    let answered = router.oneshot(request).await;
    Ok(answered.map_or_else(|never| match never {}, IntoResponse::into_response))
}

async fn open(app: &App, name: String) -> Result<Router, ApiError> {
    let path = flights::path_of(app, &name)?;
    let unreadable = || ApiError::UnreadableRecording { file: name.clone() };
    let opened = tokio::task::spawn_blocking(move || Replay::open(&path)).await;
    let replay = opened.ok().and_then(Result::ok).ok_or_else(unreadable)?;
    app.replays.add(name, replay)
}
