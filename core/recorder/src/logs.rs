//! Logs of autopilots (PX4: ULog), fetched over the vehicle's link and laid beside the recordings: under the name of the recording of their flight,
//! where there is one.
//!
//! Must never do: leave a part of a log under the name of a whole one.

use crate::folder;
use skein_domain::exchange::Severity;
use skein_domain::{AutopilotLog, LogFetch, LogFetchEnd, Refusal, VehicleId};
use skein_recording::Recording;
use skein_runtime::NodeHandle;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// An autopilot's clock and this computer's are apart by so much at most where a log is taken for one of a recording, in seconds.
const CLOCKS_S: f64 = 60.0;
/// Recordings that are looked at, the newest first.
const LOOKED_AT: usize = 200;

/// The logs of a vehicle.
///
/// # Errors
/// When there is no such vehicle, it is armed, it does not answer, or one of its logs is being fetched.
pub async fn list(node: &NodeHandle, vehicle: VehicleId) -> Result<Vec<AutopilotLog>, Refusal> {
    let busy = node
        .log_fetches()
        .get(&vehicle)
        .is_some_and(|fetch| fetch.end.is_none());
    if busy {
        return Err(Refusal::not_permitted("a log of it is being fetched"));
    }
    node.logs_of(vehicle)?.list().await
}

/// Begins to fetch one. How far it has come says [`NodeHandle::log_fetches`].
///
/// # Errors
/// When there is no such log or vehicle, it is armed, or there is no folder for it.
pub async fn fetch(node: &NodeHandle, vehicle: VehicleId, number: u16) -> Result<LogFetch, Refusal> {
    let no_folder = || Refusal::not_permitted("there is no folder for recordings (recorder.folder)");
    let folder = node.config().recorder.folder.clone().ok_or_else(no_folder)?;
    let logs = list(node, vehicle).await?;
    let log = logs.into_iter().find(|log| log.number == number);
    let log = log.ok_or_else(|| Refusal::invalid(format!("the autopilot has no log {number}")))?;
    let begun = node.begin_log_fetch(vehicle, log)?;
    let (handle, runtime) = (node.clone(), tokio::runtime::Handle::current());
    // A disk may stand still: on a thread of its own nobody else waits for it.
    let started = std::thread::Builder::new().name("log".into()).spawn(move || {
        let name = handle
            .snapshot()
            .vehicles
            .iter()
            .find(|one| one.id == vehicle)
            .map(|one| one.name.clone());
        let name = name.unwrap_or_else(|| format!("uav-{vehicle}"));
        let fetched = runtime.block_on(written(&handle, vehicle, log, &folder, &name));
        end(&handle, vehicle, &name, fetched);
    });
    if let Err(error) = started {
        let why = format!("no thread for it: {error}");
        node.note_log_fetch(vehicle, 0, Some(LogFetchEnd::BrokenOff { why: why.clone() }));
        return Err(Refusal::not_permitted(why));
    }
    Ok(begun)
}

fn end(node: &NodeHandle, vehicle: VehicleId, name: &str, fetched: Result<PathBuf, Refusal>) {
    let end = match fetched {
        Ok(path) => {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            node.tell_of_recorder(Severity::Info, format!("{name}: its log was fetched: {file}"));
            LogFetchEnd::Fetched { file }
        }
        Err(refusal) => {
            node.tell_of_recorder(
                Severity::Advisory,
                format!("{name}: its log was not fetched: {refusal}"),
            );
            LogFetchEnd::BrokenOff {
                why: refusal.to_string(),
            }
        }
    };
    node.note_log_fetch(vehicle, 0, Some(end));
}

async fn written(
    node: &NodeHandle,
    vehicle: VehicleId,
    log: AutopilotLog,
    folder: &Path,
    name: &str,
) -> Result<PathBuf, Refusal> {
    let failed = |error: io::Error| Refusal::not_permitted(format!("it cannot be written: {error}"));
    fs::create_dir_all(folder).map_err(failed)?;
    let path = path_of(folder, log, name);
    let part = path.with_extension(format!("{}.{}", folder::LOG_ENDING, folder::PART_ENDING));
    let mut file = File::create(&part).map_err(failed)?;
    let fetched = node
        .logs_of(vehicle)?
        .fetch(log, |bytes| {
            node.check_log_may_be_fetched(vehicle)?;
            file.write_all(bytes).map_err(failed)?;
            node.note_log_fetch(vehicle, bytes.len(), None);
            Ok(())
        })
        .await;
    let whole = fetched.and_then(|()| {
        file.sync_all().map_err(failed)?;
        fs::rename(&part, &path).map_err(failed)
    });
    match whole {
        Ok(()) => Ok(path),
        Err(refusal) => {
            // What is left of it goes as old recordings go; it is under no name of a log.
            let _ = fs::remove_file(&part);
            Err(refusal)
        }
    }
}

/// Beside the recording in which the log was written last, else under its own time.
fn path_of(folder: &Path, log: AutopilotLog, vehicle: &str) -> PathBuf {
    let mut recordings = folder::all(folder).unwrap_or_default();
    recordings.sort_unstable_by(|a, b| b.cmp(a));
    let of_flight = log.written_unix_s.and_then(|written_s| {
        let all = recordings.iter().take(LOOKED_AT);
        let apart = all.filter_map(|path| Some((apart_s(path, f64::from(written_s))?, path)));
        let near = apart.filter(|(apart_s, _)| *apart_s <= CLOCKS_S);
        let (_, nearest) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(nearest.file_stem()?.to_string_lossy().into_owned())
    });
    let of_time = || {
        let unix_ns = log
            .written_unix_s
            .map_or_else(crate::encoder::time_of_day_ns, |s| u64::from(s) * 1_000_000_000);
        folder::name(unix_ns, "log")
    };
    let stem = of_flight.unwrap_or_else(of_time);
    folder.join(format!(
        "{stem}_{}_{}.{}",
        folder::plain(vehicle),
        log.number,
        folder::LOG_ENDING
    ))
}

/// How far a moment is from a recording, in seconds; 0 within it.
fn apart_s(recording: &Path, unix_s: f64) -> Option<f64> {
    let recording = Recording::open(recording).ok()?;
    let (begin, end) = recording.span();
    let at_s = |at| recording.header().base.unix_ns(at) as f64 * 1e-9;
    Some((at_s(begin) - unix_s).max(unix_s - at_s(end)).max(0.0))
}
