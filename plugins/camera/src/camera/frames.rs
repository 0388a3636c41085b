//! Frames: made or taken when they are due, and given away.

use super::Camera;
use crate::clock_strip;
use crate::decoding::{self, DecodeError, Files, Picture, Reader};
use crate::settings::{Settings, Source};
use crate::stream::{self, Coded, StreamFault, StreamReader};
use crate::synthetic::Synthetic;
use crate::truth::PictureTruth;
use skein_domain::exchange::{PayloadReport, PeerState};
use skein_domain::payload::{CameraPose, FrameHeader, PixelFormat};
use skein_domain::{NodeTime, VehicleId};
use skein_plugin_sdk::frames::{FrameMut, acquire};
use skein_plugin_sdk::{Effects, log};

const BYTES_PER_PIXEL: u32 = 3;
/// The host lends four buffers, and one may still be read.
const MOST_CODED_AT_ONCE: usize = 3;
/// Pause before files that could not be read are tried again, in seconds.
const RETRY_S: f64 = 5.0;

/// Where frames come from, and how that goes.
#[derive(Debug)]
pub(super) struct Frames {
    origin: Origin,
    /// The source gives frames.
    pub(super) delivers: bool,
    /// Size of the last frame in pixels.
    pub(super) size_px: Option<(u32, u32)>,
    /// What truly is in the last one, where that is asked for.
    pub(super) truth: Option<PictureTruth>,
    /// What is wrong with the source.
    pub(super) fault: String,
    /// When files are tried again.
    retry: Option<NodeTime>,
    /// What comes encoded beside that.
    stream: Option<Stream>,
}

/// Where encoded pictures come from.
#[derive(Debug)]
struct Stream {
    origin: stream::Origin,
    reader: Option<StreamReader>,
    began: Option<NodeTime>,
    /// When it is tried again.
    retry: Option<NodeTime>,
}

/// What comes encoded with these settings.
fn origin_of(settings: &Settings) -> Option<stream::Origin> {
    match settings.source {
        Source::Video => Some(stream::Origin::File(settings.path.clone())),
        Source::Rtsp => Some(stream::Origin::Rtsp(stream::RtspCamera {
            url: settings.url.clone(),
            user: settings.user.clone(),
            password: settings.password.clone(),
        })),
        Source::Rtp => Some(stream::Origin::Rtp(stream::RtpPort {
            // Both were judged with the rest of the configuration.
            listen: settings.listen_address().ok()?,
            parameter_sets: stream::parameter_sets(&settings.parameter_sets).ok()?,
        })),
        Source::Gstreamer => Some(stream::Origin::Pipeline(settings.pipeline.clone())),
        Source::Mavlink | Source::Synthetic | Source::Stills => None,
    }
}

#[derive(Debug)]
enum Origin {
    Nothing,
    Scene(Box<Synthetic>),
    Files(Files, Option<Reader>),
}

impl Frames {
    pub(super) fn new(settings: &Settings, vehicle: VehicleId, taken: u64) -> Self {
        let path = settings.path.clone();
        let files = match settings.source {
            Source::Mavlink | Source::Synthetic | Source::Rtsp | Source::Rtp | Source::Gstreamer => None,
            Source::Stills => Some(Files::Stills(path)),
            Source::Video if !settings.decode => None,
            Source::Video => Some(Files::Video {
                path,
                rate_hz: settings.rate_hz,
            }),
        };
        let mut frames = Self {
            origin: Origin::Nothing,
            delivers: false,
            size_px: None,
            truth: None,
            fault: String::new(),
            retry: None,
            stream: origin_of(settings).map(|origin| Stream {
                origin,
                reader: None,
                began: None,
                retry: None,
            }),
        };
        if let Some(files) = files {
            let reader = frames.start(&files, taken);
            frames.origin = Origin::Files(files, reader);
        } else if settings.source == Source::Synthetic {
            frames.origin = Origin::Scene(Box::new(Synthetic::new(settings, vehicle)));
        }
        frames
    }

    fn start(&mut self, files: &Files, taken: u64) -> Option<Reader> {
        match decoding::start(files.clone(), taken) {
            Ok(reader) => Some(reader),
            Err(error) => {
                self.fault = format!("no thread to decode on: {error}");
                None
            }
        }
    }

    pub(super) fn see(&mut self, peers: &[PeerState], settings: &Settings) {
        if let Origin::Scene(scene) = &mut self.origin {
            scene.see(peers, settings);
        }
    }

    pub(super) fn hear(&mut self, report: &PayloadReport, settings: &Settings) {
        if let Origin::Scene(scene) = &mut self.origin {
            scene.hear(report, settings);
        }
    }

    /// The next picture of the files, if it is ready; begins anew with them where that failed.
    fn picture(&mut self, now: NodeTime, taken: u64) -> Option<Picture> {
        let Origin::Files(files, reader) = &mut self.origin else {
            return None;
        };
        let Some(reading) = reader else {
            let due = *self.retry.get_or_insert(now.plus_seconds(RETRY_S));
            if now >= due {
                let files = files.clone();
                self.retry = None;
                let started = self.start(&files, taken);
                self.origin = Origin::Files(files, started);
            }
            return None;
        };
        match reading.take() {
            Ok(Some(picture)) => {
                self.fault.clear();
                self.delivers = true;
                return Some(picture);
            }
            Ok(None) => {}
            Err(DecodeError::Ended(ended)) => {
                *reader = None;
                self.delivers = false;
                if self.fault.is_empty() {
                    self.fault = ended.to_string();
                }
            }
            Err(error) => {
                self.fault = error.to_string();
                log::warn!("{error}");
            }
        }
        None
    }
}

impl Stream {
    /// The encoded pictures that are due; begins anew with the source where it failed.
    fn due(&mut self, now: NodeTime, delivers: &mut bool, fault: &mut String) -> Vec<Coded> {
        let Some(reader) = &mut self.reader else {
            if self.retry.is_none_or(|retry| now >= retry) {
                self.retry = Some(now.plus_seconds(RETRY_S));
                self.began = None;
                self.reader = StreamReader::start(self.origin.clone())
                    .inspect_err(|error| *fault = format!("no thread to read on: {error}"))
                    .ok();
            }
            return Vec::new();
        };
        let since_s = self.began.map_or(0.0, |began| now.seconds_since(began));
        let mut due = Vec::new();
        while due.len() < MOST_CODED_AT_ONCE {
            match reader.take(since_s) {
                Ok(Some(coded)) => {
                    self.began.get_or_insert(now);
                    *delivers = true;
                    fault.clear();
                    due.push(coded);
                }
                Ok(None) => return due,
                Err(StreamFault::Ended(_)) => {
                    *delivers = false;
                    self.reader = None;
                    self.retry = Some(now.plus_seconds(RETRY_S));
                    return due;
                }
                Err(error) => {
                    *delivers = false;
                    let reason = error.to_string();
                    // Once, not with every attempt.
                    if *fault != reason {
                        log::warn!("{reason}");
                        *fault = reason;
                    }
                }
            }
        }
        due
    }
}

impl Camera {
    /// Gives what came encoded and is due.
    pub(super) fn give_coded(&mut self, now: NodeTime, effects: &mut Effects) {
        let Some(stream) = &mut self.frames.stream else {
            return;
        };
        let due = stream.due(now, &mut self.frames.delivers, &mut self.frames.fault);
        for coded in due {
            // Numbers that are missing count as lost, here as below.
            self.core.coded += 1 + coded.left_out;
            let Some(mut frame) = acquire(coded.bytes.len()) else {
                // The number is missing in what is given: whoever looks knows that one was lost.
                self.core.capture.dropped += 1;
                continue;
            };
            frame.copy_from_slice(&coded.bytes);
            let header = FrameHeader {
                sequence: self.core.coded,
                time: now,
                format: PixelFormat::H264,
                ..FrameHeader::default()
            };
            effects.frame(frame, header);
        }
    }

    /// Gives a frame if one is due, there is one, and there is room for it.
    pub(super) fn give_frame(&mut self, now: NodeTime, effects: &mut Effects) {
        if matches!(self.frames.origin, Origin::Nothing)
            || !self.core.capture.frame_is_due(now, 1.0 / self.settings.rate_hz)
        {
            return;
        }
        if matches!(self.frames.origin, Origin::Scene(_)) {
            self.draw(now, effects);
        } else if let Some(picture) = self.frames.picture(now, self.core.taken) {
            self.core.taken += 1;
            let size_px = (picture.width_px, picture.height_px);
            self.give(now, size_px, None, effects, |out| out.copy_from_slice(&picture.rgb));
        }
    }

    fn draw(&mut self, now: NodeTime, effects: &mut Effects) {
        let (own, settings) = (self.own, &self.settings);
        let field_of_view_rad = self.field_of_view_rad();
        let Origin::Scene(scene) = &self.frames.origin else {
            return;
        };
        let pose = scene.pose(now, &own, settings, field_of_view_rad);
        self.frames.delivers = pose.is_some();
        let Some(pose) = pose else {
            self.frames.fault = "the vehicle does not know where it is".to_owned();
            return;
        };
        self.frames.fault.clear();
        let size_px = (settings.width_px, settings.height_px);
        let Some(mut frame) = self.room_for(size_px) else {
            return;
        };
        let Origin::Scene(scene) = &mut self.frames.origin else {
            return;
        };
        scene.draw(now, &pose, size_px, &mut frame);
        if self.settings.clock {
            clock_strip::draw(now, size_px.0, &mut frame);
        }
        let believed = scene.believed(now, &pose);
        // The frame is the next one that is counted.
        let number = self.core.capture.frames + 1;
        self.frames.truth = self.settings.truth.then(|| scene.truth(number, now, &pose, size_px));
        self.pass_on(now, frame, size_px, Some(believed), effects);
    }

    fn give(
        &mut self,
        now: NodeTime,
        size_px: (u32, u32),
        pose: Option<CameraPose>,
        effects: &mut Effects,
        fill: impl FnOnce(&mut [u8]),
    ) {
        if let Some(mut frame) = self.room_for(size_px) {
            fill(&mut frame);
            self.pass_on(now, frame, size_px, pose, effects);
        }
    }

    /// A buffer for a frame; without one the frame is left out.
    fn room_for(&mut self, size_px: (u32, u32)) -> Option<FrameMut> {
        self.frames.size_px = Some(size_px);
        let len = u64::from(size_px.0) * u64::from(size_px.1) * u64::from(BYTES_PER_PIXEL);
        let frame = usize::try_from(len).ok().and_then(acquire);
        if frame.is_none() {
            self.core.capture.dropped += 1;
        }
        frame
    }

    fn pass_on(
        &mut self,
        now: NodeTime,
        frame: FrameMut,
        (width_px, height_px): (u32, u32),
        pose: Option<CameraPose>,
        effects: &mut Effects,
    ) {
        let header = FrameHeader {
            sequence: self.core.capture.gave_frame(now, effects),
            time: now,
            width_px,
            height_px,
            stride_bytes: width_px * BYTES_PER_PIXEL,
            format: PixelFormat::Rgb8,
            pose,
            ..FrameHeader::default()
        };
        effects.frame(frame, header);
    }
}
