//! Recordings of flights on this node: listed, fetched, and told as a report.
//!
//! Must never do: reach a file outside of their folder, or read one on a thread that requests wait for.

use crate::app::App;
use crate::error::ApiError;
use crate::files;
use crate::protocol::{FlightList, RecordedFlight};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::header;
use axum::response::{Html, IntoResponse, Response};
use skein_recording::Recording;
use skein_report::Report;
use std::path::PathBuf;

/// The page brings its own styles and pictures, and loads nothing.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'";
/// So many are named.
const MOST: usize = 500;

fn unknown(file: &str) -> ApiError {
    ApiError::UnknownRecording { file: file.to_owned() }
}

/// How recordings end, and logs of autopilots.
const RECORDING: &str = ".mcap";
const LOG: &str = ".ulg";

/// Names of files, the newest first: they begin with the time of day.
fn names(folder: &std::path::Path, ending: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.ok()?.file_name().into_string().ok();
    let mut names: Vec<String> = entries.filter_map(name).filter(|name| name.ends_with(ending)).collect();
    names.sort_unstable_by(|a, b| b.cmp(a));
    names.truncate(MOST);
    names
}

/// Where a file of this name is, if it is one of them.
pub(crate) fn path_of(app: &App, name: &str) -> Result<PathBuf, ApiError> {
    let folder = app.node.config().recorder.folder.clone().ok_or_else(|| unknown(name))?;
    let is_one = |ending: &&str| names(&folder, ending).iter().any(|one| one == name);
    if [RECORDING, LOG].iter().any(is_one) {
        Ok(folder.join(name))
    } else {
        Err(unknown(name))
    }
}

pub(crate) async fn list(State(app): State<App>) -> Json<FlightList> {
    let folder = app.node.config().recorder.folder.clone();
    let read = tokio::task::spawn_blocking(move || {
        let folder = folder?;
        let logs = names(&folder, LOG);
        let of = |file: String| {
            let stem = file.strip_suffix(RECORDING).unwrap_or(&file);
            let begins = format!("{}_", stem.strip_suffix("_ground").unwrap_or(stem));
            let beside = logs.iter().filter(|log| log.starts_with(&begins)).cloned();
            let recording = Recording::open(&folder.join(&file)).ok()?;
            let (begin, end) = recording.span();
            Some(RecordedFlight {
                begun_unix_s: recording.header().base.unix_ns(begin) as f64 * 1e-9,
                seconds: end.seconds_since(begin),
                bytes: recording.bytes(),
                node: recording.header().name.clone(),
                logs: beside.collect(),
                finished: recording.is_finished(),
                file,
            })
        };
        Some(names(&folder, RECORDING).into_iter().filter_map(of).collect())
    });
    let flights = read.await.ok().flatten().unwrap_or_default();
    Json(FlightList { flights })
}

/// A recording as an MCAP file.
///
/// # Errors
/// When there is none of this name.
pub(crate) async fn file(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<Response, ApiError> {
    let Path(name) = name?;
    let path = path_of(&app, &name)?;
    let sent = files::send(&path, &name, "application/octet-stream").await;
    sent.map_err(|_| unknown(&name))
}

/// The report of a flight, a page by itself.
///
/// # Errors
/// When there is no recording of this name, or nothing can be read of it.
pub(crate) async fn report(
    State(app): State<App>,
    name: Result<Path<String>, PathRejection>,
) -> Result<Response, ApiError> {
    let Path(name) = name?;
    let path = path_of(&app, &name)?;
    let made = tokio::task::spawn_blocking(move || {
        let recording = Recording::open(&path).ok()?;
        Report::of(&recording).ok().map(|report| skein_report::html(&report))
    });
    let page = made.await.ok().flatten();
    let page = page.ok_or_else(|| unknown(&name))?;
    Ok(([(header::CONTENT_SECURITY_POLICY, POLICY)], Html(page)).into_response())
}
