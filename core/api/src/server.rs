//! Serving: the router with everything around it, and the accept loop with its bounds.
//!
//! Must never do: wait for a client that takes its time.

use crate::app::{App, Closing, MAX_STREAMS};
use crate::connections::{Admitted, Connections};
use crate::error::ApiError;
use crate::guard::{Guard, keep_foreign_pages_out};
use crate::open_replays::{OpenReplays, Served};
use crate::settings::ApiSettings;
use crate::webrtc::LocalAddress;
use crate::{assets, audit, body, elsewhere, endpoints, metrics, openapi, replay, replays, trace};
use axum::Extension;
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::{HeaderName, HeaderValue, Method, Uri, header};
use axum::middleware;
use axum::routing::any;
use hyper::body::Incoming;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use skein_replay::Replay;
use skein_runtime::NodeHandle;
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{oneshot, watch};
use tokio::time::{interval, sleep, timeout};
use tower_http::set_header::SetResponseHeaderLayer;

/// The head of a request has to be there within this time.
const HEAD_WITHIN: Duration = Duration::from_secs(10);
/// At the end, requests that are being answered have so long.
const END_WITHIN: Duration = Duration::from_secs(3);
/// Pause after an accept that failed, for example because no file descriptor is left.
const AFTER_FAILED_ACCEPT: Duration = Duration::from_millis(100);

/// What an answer of the API may load in a browser: nothing. The dashboard's pages say more themselves.
const POLICY_OF_DATA: &str = "default-src 'none'; frame-ancestors 'none'";

/// Every route of a node, with the checks and headers around them.
pub fn router(node: NodeHandle, settings: &ApiSettings) -> Router {
    let app = App {
        replays: Some(Arc::new(OpenReplays::new(serve_replay(settings.clone())))),
        ..App::new(node, openapi::document().into())
    };
    // Beside the table of routes: what is below it are the routes of another node, with its own document.
    let replays = Router::new()
        .route("/replay/{file}", any(replays::to_the_page))
        .route("/replay/{file}/", any(replays::first))
        .route("/replay/{file}/{*rest}", any(replays::rest));
    around(app, settings, replays)
}

/// Every route of a recorded flight, with the same around them: nothing can be changed but what of it is shown.
pub fn replay_router(replay: Arc<Replay>, settings: &ApiSettings) -> Router {
    let app = App::of_replay(replay, openapi::document().into());
    around(app, settings, Router::new())
}

/// How recorded flights are served beside a node.
fn serve_replay(settings: ApiSettings) -> impl Fn(Arc<Replay>) -> Served {
    move |replay| {
        let app = App::of_replay(replay, openapi::document().into());
        let streams = app.streams.clone();
        Served {
            router: around(app, &settings, Router::new()),
            is_looked_at: Box::new(move || streams.available_permits() < MAX_STREAMS),
        }
    }
}

/// The routes, the routes beside them, and what is around all of them.
fn around(app: App, settings: &ApiSettings, beside: Router<App>) -> Router {
    metrics::install();
    let guard = Arc::new(Guard::new(settings));
    let routes = endpoints::all()
        .into_iter()
        .fold(beside, |routes, one| routes.route(one.path, one.handler));
    let always = |name: HeaderName, value: &'static str| {
        SetResponseHeaderLayer::overriding(name, HeaderValue::from_static(value))
    };
    let unless_said = |name: HeaderName, value: &'static str| {
        SetResponseHeaderLayer::if_not_present(name, HeaderValue::from_static(value))
    };
    let routes = routes
        .fallback(assets::dashboard)
        .method_not_allowed_fallback(wrong_method)
        .layer(middleware::from_fn_with_state(
            app.clone(),
            elsewhere::to_the_vehicles_node,
        ))
        .layer(middleware::from_fn_with_state(app.clone(), audit::record))
        .layer(middleware::from_fn_with_state(app.clone(), replay::refuse_changes))
        .with_state(app)
        .layer(DefaultBodyLimit::max(body::MAX_BODY_BYTES))
        .layer(middleware::from_fn_with_state(guard, keep_foreign_pages_out))
        .layer(unless_said(header::CACHE_CONTROL, "no-store"))
        .layer(unless_said(header::CONTENT_SECURITY_POLICY, POLICY_OF_DATA))
        .layer(always(header::X_CONTENT_TYPE_OPTIONS, "nosniff"))
        .layer(always(header::REFERRER_POLICY, "no-referrer"))
        .layer(always(header::X_FRAME_OPTIONS, "DENY"))
        .layer(always(
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ))
        .layer(always(
            HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ));
    trace::traced(routes)
}

async fn wrong_method(method: Method, uri: Uri) -> ApiError {
    ApiError::MethodNotAllowed {
        path: uri.path().to_owned(),
        method,
    }
}

/// Serves until `shutdown` is there: then takes no more connections, closes the streams, and gives requests a moment to finish.
///
/// # Errors
/// Never yet: a connection that fails is its own affair, and an accept that fails is tried again.
pub async fn serve(listener: TcpListener, router: Router, shutdown: impl Future<Output = ()>) -> io::Result<()> {
    let (close, closing) = watch::channel(false);
    let closing = Closing(closing);
    let router = router.layer(Extension(closing.clone()));
    let connections = Connections::default();
    let mut upkeep = interval(metrics::UPKEEP_EVERY);
    let mut shutdown = std::pin::pin!(shutdown);
    loop {
        tokio::select! {
            () = &mut shutdown => break,
            _ = upkeep.tick() => metrics::upkeep(),
            accepted = accept(&listener) => {
                let Some((stream, from)) = accepted else { continue };
                // One for which there is no room is closed at once: who waits in vain learns nothing.
                if let Some((admitted, dismissed)) = connections.admit(Instant::now(), from.ip()) {
                    tokio::spawn(connection(stream, router.clone(), closing.clone(), admitted, dismissed));
                }
            }
        }
    }
    drop((listener, router, closing));
    close.send_replace(true);
    // Every connection and every stream holds a receiver as long as it lives.
    if timeout(END_WITHIN, close.closed()).await.is_err() {
        tracing::debug!("some requests were not finished in time");
    }
    Ok(())
}

/// Serves one connection until it ends or is dismissed; a stream that is opened on it goes on by itself.
async fn connection(
    stream: TcpStream,
    router: Router,
    mut closing: Closing,
    admitted: Admitted,
    dismissed: oneshot::Receiver<()>,
) {
    let local = stream.local_addr().ok().map(LocalAddress);
    let answer = TowerToHyperService::new(router);
    let service = service_fn(|mut request: hyper::Request<Incoming>| {
        if let Some(local) = local {
            request.extensions_mut().insert(local);
        }
        let asked = admitted.asked(Instant::now());
        let answered = answer.call(request);
        async move {
            let answered = answered.await;
            drop(asked);
            answered
        }
    });
    let mut http = hyper::server::conn::http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_WITHIN);
    let served = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
    let mut served = std::pin::pin!(served);
    let outcome = tokio::select! {
        outcome = served.as_mut() => outcome,
        _ = dismissed => Ok(()),
        () = closing.wait() => {
            served.as_mut().graceful_shutdown();
            served.await
        }
    };
    if let Err(error) = outcome {
        tracing::debug!("a connection broke: {error}");
    }
}

/// The next connection. Nothing in it may be lost if it is dropped while it waits.
async fn accept(listener: &TcpListener) -> Option<(TcpStream, SocketAddr)> {
    match listener.accept().await {
        Ok((stream, from)) => {
            // Small messages, each worth having now. A socket that does not take the option still works.
            let _ = stream.set_nodelay(true);
            Some((stream, from))
        }
        Err(error) => {
            tracing::warn!("a connection could not be accepted: {error}");
            sleep(AFTER_FAILED_ACCEPT).await;
            None
        }
    }
}
