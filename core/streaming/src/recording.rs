//! Videos recorded on this node: the pictures as they are encoded in an MP4 file, and beside it where the vehicle was and how its payloads stood.
//!
//! Bound: a slow disk makes the recording leave out pictures, and nobody else wait; of the folder's files the oldest go when it is full.

use crate::CameraStreams;
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::payload::PayloadKind;
use skein_domain::{NodeTime, Refusal, VehicleId};
use skein_state::SharedState;
use skein_state::video::{Rendition, Viewer};
use skein_video::{EncodedFrame, Mp4Writer};
use skein_view::EventKind;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::Notify;

/// Where the vehicle was is written so often, in seconds.
const PLACE_EVERY_S: f64 = 0.1;
/// What the page names in one list.
const MOST_LISTED: usize = 500;

/// A video that is or was recorded here.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedVideo {
    /// The file's name.
    pub file: String,
    /// Its vehicle.
    pub vehicle: VehicleId,
    /// The camera's name there.
    pub payload: String,
    /// Its size in bytes.
    pub bytes: u64,
    /// How long it is, in seconds; 0 for one that has ended: the file knows.
    pub seconds: f64,
    /// It is being recorded.
    pub running: bool,
}

impl CameraStreams {
    /// Begins to record a camera.
    ///
    /// # Errors
    /// When there is no such camera, it is being recorded already, or this node keeps no recordings.
    pub fn start_recording(&self, vehicle: VehicleId, payload: &str) -> Result<RecordedVideo, Refusal> {
        let folder = self.recordings_folder()?.to_owned();
        let viewer = self.watch_video(vehicle, payload, Rendition::OF_CAMERA)?;
        let name = name_of(vehicle, payload);
        let file = format!("{name}.mp4");
        let begun = self.shared.recordings.begin(vehicle, payload, file.clone());
        let end = begun.ok_or_else(|| Refusal::not_permitted(format!("{payload} is being recorded already")))?;
        let recorder = Recorder {
            shared: self.shared.clone(),
            vehicle,
            payload: payload.to_owned(),
            folder,
            next_name: Some(name),
            open: None,
            next_place: None,
        };
        tokio::spawn(recorder.run(viewer, end));
        Ok(RecordedVideo {
            file,
            vehicle,
            payload: payload.to_owned(),
            bytes: 0,
            seconds: 0.0,
            running: true,
        })
    }

    /// Ends a recording.
    ///
    /// # Errors
    /// When the camera is not being recorded.
    pub fn stop_recording(&self, vehicle: VehicleId, payload: &str) -> Result<RecordedVideo, Refusal> {
        let ended = self.shared.recordings.end(vehicle, payload);
        let ended = ended.ok_or_else(|| Refusal::not_permitted(format!("{payload} is not being recorded")))?;
        Ok(RecordedVideo {
            file: ended.file,
            vehicle,
            payload: payload.to_owned(),
            bytes: ended.bytes,
            seconds: ended.seconds,
            running: false,
        })
    }

    /// What is and was recorded here, the newest first. Reads a folder: to be called where that may take its time.
    #[must_use]
    pub fn recorded_videos(&self) -> Vec<RecordedVideo> {
        let running = self.shared.recordings.list();
        let mut all: Vec<RecordedVideo> = running
            .into_iter()
            .map(|(vehicle, payload, one)| RecordedVideo {
                file: one.file,
                vehicle,
                payload,
                bytes: one.bytes,
                seconds: one.seconds,
                running: true,
            })
            .collect();
        let kept = self.recordings_folder().map(files_of).unwrap_or_default();
        for (file, bytes) in kept {
            let known = all.iter().any(|one| one.file == file);
            if let Some((vehicle, payload)) = camera_of(&file).filter(|_| !known) {
                all.push(RecordedVideo {
                    file,
                    vehicle,
                    payload,
                    bytes,
                    seconds: 0.0,
                    running: false,
                });
            }
        }
        all.sort_by(|one, other| other.file.cmp(&one.file));
        all.truncate(MOST_LISTED);
        all
    }

    /// Where a file of the folder is.
    ///
    /// # Errors
    /// When this node keeps no recordings, or there is none of this name.
    pub fn recorded_file(&self, name: &str) -> Result<PathBuf, Refusal> {
        let folder = self.recordings_folder()?;
        let plain = !name.is_empty() && Path::new(name).file_name() == Some(name.as_ref());
        let path = folder.join(name);
        if plain && path.is_file() {
            return Ok(path);
        }
        Err(Refusal::invalid(format!("there is no recording {name}")))
    }

    fn recordings_folder(&self) -> Result<&Path, Refusal> {
        let folder = self.shared.config.video.recordings.as_deref();
        folder.ok_or_else(|| Refusal::not_permitted("this node keeps no recordings (video.recordings)"))
    }
}

/// A name that tells when a recording began, in milliseconds since 1970, and of which camera it is.
fn name_of(vehicle: VehicleId, payload: &str) -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    format!("{}-{vehicle}-{payload}", since_1970.as_millis())
}

/// The recordings of a folder with their sizes.
fn files_of(folder: &Path) -> Vec<(String, u64)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let file = |entry: std::fs::DirEntry| {
        let name = entry.file_name().into_string().ok()?;
        name.ends_with(".mp4").then_some((name, entry.metadata().ok()?.len()))
    };
    entries.filter_map(file).collect()
}

/// Which camera a file is of, by its name.
fn camera_of(file: &str) -> Option<(VehicleId, String)> {
    let mut parts = file.strip_suffix(".mp4")?.splitn(3, '-').skip(1);
    let vehicle = parts.next()?.parse().ok().map(VehicleId)?;
    Some((vehicle, parts.next()?.to_owned()))
}

/// Records one camera.
struct Recorder {
    shared: Arc<SharedState>,
    vehicle: VehicleId,
    payload: String,
    folder: PathBuf,
    /// Of the first file; another one, when the pictures change their size, is named by when it begins.
    next_name: Option<String>,
    open: Option<OpenFile>,
    next_place: Option<NodeTime>,
}

struct OpenFile {
    writer: Mp4Writer,
    video: Arc<File>,
    places: Arc<File>,
    began: NodeTime,
}

/// A line beside the video: how all stood when a picture was taken.
#[derive(Serialize)]
struct Place {
    /// Seconds into the file.
    at_s: f64,
    /// On the node's clock.
    time_us: u64,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    altitude_amsl_m: Option<f64>,
    roll_rad: f32,
    pitch_rad: f32,
    yaw_rad: Option<f64>,
    /// What gimbals and cameras of the vehicle report, by name.
    payloads: serde_json::Map<String, serde_json::Value>,
}

impl Recorder {
    async fn run(mut self, mut viewer: Viewer, end: Arc<Notify>) {
        let fault = loop {
            let frame = tokio::select! {
                given = viewer.next() => given.frame,
                () = end.notified() => break self.close().await.err(),
            };
            if let Err(fault) = self.take(&frame).await {
                break Some(fault);
            }
        };
        if let Some(fault) = fault {
            self.shared.recordings.end(self.vehicle, &self.payload);
            let text = format!(
                "{} of vehicle {}: the recording ended: {fault}",
                self.payload, self.vehicle
            );
            let kind = EventKind::Payload {
                payload: self.payload.clone(),
            };
            let now = self.shared.now();
            self.shared
                .events
                .record(now, Some(self.vehicle), Severity::Warning, kind, text);
        }
    }

    async fn take(&mut self, frame: &EncodedFrame) -> Result<(), String> {
        if self.open.as_ref().is_some_and(|open| !open.writer.fits(frame)) {
            self.close().await?;
        }
        if self.open.is_none() {
            if !frame.key {
                return Ok(());
            }
            self.begin(frame).await?;
        }
        let place = self.place(frame);
        let Some(open) = &mut self.open else { return Ok(()) };
        let written = open.writer.push(frame).map_err(|error| error.to_string())?;
        if let Some(line) = place {
            write(open.places.clone(), line).await?;
        }
        if let Some(bytes) = written {
            let (len, seconds) = (bytes.len() as u64, frame.taken.seconds_since(open.began));
            write(open.video.clone(), bytes).await?;
            self.shared.recordings.note(self.vehicle, &self.payload, |one| {
                one.bytes += len;
                one.seconds = seconds;
            });
        }
        Ok(())
    }

    async fn begin(&mut self, frame: &EncodedFrame) -> Result<(), String> {
        let (writer, head) = Mp4Writer::new(frame).map_err(|error| error.to_string())?;
        let next_name = self.next_name.take();
        let name = next_name.unwrap_or_else(|| name_of(self.vehicle, &self.payload));
        let (folder, most) = (self.folder.clone(), self.shared.config.video.keep_bytes);
        let created = tokio::task::spawn_blocking(move || {
            std::fs::create_dir_all(&folder)?;
            make_room(&folder, most);
            let video = File::create(folder.join(format!("{name}.mp4")))?;
            Ok::<_, std::io::Error>((video, File::create(folder.join(format!("{name}.jsonl")))?))
        });
        let created = created.await.map_err(|error| error.to_string())?;
        let (video, places) = created.map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let video = Arc::new(video);
        write(video.clone(), head).await?;
        self.next_place = None;
        self.open = Some(OpenFile {
            writer,
            video,
            places: Arc::new(places),
            began: frame.taken,
        });
        Ok(())
    }

    async fn close(&mut self) -> Result<(), String> {
        let Some(open) = self.open.take() else { return Ok(()) };
        match open.writer.finish() {
            Some(bytes) => write(open.video, bytes).await,
            None => Ok(()),
        }
    }

    /// The line for a picture, if one is due.
    fn place(&mut self, frame: &EncodedFrame) -> Option<Vec<u8>> {
        if self.next_place.is_some_and(|next| frame.taken < next) {
            return None;
        }
        self.next_place = Some(frame.taken.plus_seconds(PLACE_EVERY_S));
        let fleet = self.shared.picture();
        let vehicle = fleet.vehicles.iter().find(|vehicle| vehicle.id == self.vehicle)?;
        let aims = |kind: PayloadKind| matches!(kind, PayloadKind::Gimbal | PayloadKind::Camera);
        let payloads = vehicle.payloads.iter().filter(|payload| aims(payload.kind));
        let began = self.open.as_ref()?.began;
        let line = Place {
            at_s: frame.taken.seconds_since(began),
            time_us: frame.taken.0,
            latitude_deg: vehicle.global.map(|place| place.latitude_deg),
            longitude_deg: vehicle.global.map(|place| place.longitude_deg),
            altitude_amsl_m: vehicle.global.map(|place| place.altitude_amsl_m),
            roll_rad: vehicle.roll_rad,
            pitch_rad: vehicle.pitch_rad,
            yaw_rad: vehicle.kinematics.map(|kinematics| kinematics.yaw_rad),
            payloads: payloads
                .filter_map(|payload| Some((payload.name.clone(), payload.state.clone()?)))
                .collect(),
        };
        let mut line = serde_json::to_vec(&line).ok()?;
        line.push(b'\n');
        Some(line)
    }
}

/// Writes where that may take its time.
async fn write(file: Arc<File>, bytes: Vec<u8>) -> Result<(), String> {
    let written = tokio::task::spawn_blocking(move || (&*file).write_all(&bytes));
    let written = written.await.map_err(|error| error.to_string())?;
    written.map_err(|error| error.to_string())
}

/// Removes the oldest recordings until the others take less than is to be kept.
fn make_room(folder: &Path, most: u64) {
    let mut files = files_of(folder);
    files.sort();
    let mut bytes: u64 = files.iter().map(|(_, bytes)| bytes).sum();
    for (name, len) in files {
        if bytes < most {
            return;
        }
        bytes -= len;
        for path in [folder.join(&name), folder.join(&name).with_extension("jsonl")] {
            // What cannot be removed stays; the disk says so when it is full.
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests;
