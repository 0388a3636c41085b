//! What the camera did and does, as it stands in the snapshot: pictures, recording, zoom, the number of frames.

use crate::occurrence::CameraEvent;
use minicbor::{Decode, Encode};
use skein_domain::NodeTime;
use skein_domain::payload::CameraMode;
use skein_plugin_sdk::Effects;

/// Pictures are taken, and when.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Series {
    /// How many are still to be taken; absent: until told otherwise.
    #[n(0)]
    left: Option<u32>,
    #[n(1)]
    interval_s: f64,
    #[n(2)]
    next: NodeTime,
}

/// A camera whose pictures are the frames it gives.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Capture {
    /// Mode, by MAVLink's numbers.
    #[n(0)]
    mode: u8,
    #[n(1)]
    series: Option<Series>,
    #[n(2)]
    pub(crate) pictures: u32,
    #[n(3)]
    recording_since: Option<NodeTime>,
    /// How long it recorded when it last ended, in seconds.
    #[n(4)]
    recorded_s: f64,
    #[n(5)]
    pub(crate) zoom: f64,
    /// Frames given since it was first started.
    #[n(6)]
    pub(crate) frames: u64,
    /// When the next frame is due.
    #[n(7)]
    next_frame: Option<NodeTime>,
    /// Frames that were due but nobody had room for.
    #[n(8)]
    pub(crate) dropped: u64,
}

impl Default for Capture {
    fn default() -> Self {
        Self {
            mode: mode_number(CameraMode::Picture),
            series: None,
            pictures: 0,
            recording_since: None,
            recorded_s: 0.0,
            zoom: 1.0,
            frames: 0,
            next_frame: None,
            dropped: 0,
        }
    }
}

/// MAVLink's number of a mode.
pub(crate) fn mode_number(mode: CameraMode) -> u8 {
    match mode {
        CameraMode::Picture => 0,
        CameraMode::Video => 1,
        CameraMode::Survey => 2,
    }
}

/// The mode of a MAVLink number.
pub(crate) fn mode_of(number: u8) -> CameraMode {
    match number {
        1 => CameraMode::Video,
        2 => CameraMode::Survey,
        _ => CameraMode::Picture,
    }
}

impl Capture {
    pub(crate) fn mode(&self) -> CameraMode {
        mode_of(self.mode)
    }

    pub(crate) fn set_mode(&mut self, mode: CameraMode) {
        self.mode = mode_number(mode);
    }

    pub(crate) fn is_capturing(&self) -> bool {
        self.series.is_some()
    }

    pub(crate) fn is_recording(&self) -> bool {
        self.recording_since.is_some()
    }

    pub(crate) fn recording_s(&self, now: NodeTime) -> f64 {
        self.recording_since
            .map_or(self.recorded_s, |since| now.seconds_since(since))
    }

    pub(crate) fn take_pictures(&mut self, now: NodeTime, count: u32, interval_s: f64) {
        self.series = Some(Series {
            left: (count > 0).then_some(count),
            interval_s,
            next: now,
        });
    }

    pub(crate) fn stop_pictures(&mut self) {
        self.series = None;
    }

    pub(crate) fn start_recording(&mut self, now: NodeTime, effects: &mut Effects) {
        if self.recording_since.is_none() {
            self.recording_since = Some(now);
            effects.occurrence(&CameraEvent::RecordingStarted);
        }
    }

    pub(crate) fn stop_recording(&mut self, now: NodeTime, effects: &mut Effects) {
        if let Some(since) = self.recording_since.take() {
            self.recorded_s = now.seconds_since(since);
            effects.occurrence(&CameraEvent::RecordingStopped {
                seconds: self.recorded_s,
            });
        }
    }

    /// Whether a frame is due; the next one is then set down.
    pub(crate) fn frame_is_due(&mut self, now: NodeTime, period_s: f64) -> bool {
        let due = self.next_frame.unwrap_or(now);
        if now < due {
            return false;
        }
        // From when it was due, so that the rate holds; from now, if that is long past.
        let late = now.seconds_since(due) > period_s;
        self.next_frame = Some(if late { now } else { due }.plus_seconds(period_s));
        true
    }

    /// A frame was given: it is a picture if one is due. Returns its number.
    pub(crate) fn gave_frame(&mut self, now: NodeTime, effects: &mut Effects) -> u64 {
        self.frames += 1;
        if let Some(series) = &mut self.series
            && now >= series.next
        {
            self.pictures = self.pictures.saturating_add(1);
            effects.occurrence(&CameraEvent::PictureTaken {
                picture: self.pictures,
                frame: Some(self.frames),
            });
            series.next = now.plus_seconds(series.interval_s);
            series.left = series.left.map(|left| left.saturating_sub(1));
            if series.left == Some(0) {
                self.series = None;
            }
        }
        self.frames
    }
}
