//! The state as others see it, told when it changes.

use super::Camera;
use crate::truth::CameraReport;
use skein_domain::NodeTime;
use skein_domain::payload::CameraState;
use skein_plugin_sdk::Effects;

/// What only counts on is told no more often than this, in seconds.
const COUNT_PAUSE_S: f64 = 1.0;
const BUILT_IN: &str = "Skein";

/// Tells the state when it changed.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    last: Option<(NodeTime, CameraReport)>,
}

impl Reporter {
    fn tell(&mut self, now: NodeTime, state: CameraReport, effects: &mut Effects) {
        if let Some((when, last)) = &self.last {
            let counted = CameraState {
                frames: state.camera.frames,
                recording_s: state.camera.recording_s,
                ..last.camera.clone()
            };
            let only_counts = counted == state.camera && last.truth == state.truth;
            if *last == state || only_counts && now.seconds_since(*when) < COUNT_PAUSE_S {
                return;
            }
        }
        effects.report(&state);
        self.last = Some((now, state));
    }
}

impl Camera {
    pub(super) fn report(&mut self, now: NodeTime, effects: &mut Effects) {
        let state = CameraReport {
            camera: self.state(now),
            truth: self.frames.truth.clone(),
        };
        self.reporter.tell(now, state, effects);
    }

    pub(super) fn state(&self, now: NodeTime) -> CameraState {
        let capture = &self.core.capture;
        let mut state = CameraState {
            connected: self.frames.delivers,
            vendor: BUILT_IN.to_owned(),
            model: format!("{:?}", self.settings.source).to_lowercase(),
            mode: capture.mode(),
            capturing: capture.is_capturing(),
            pictures: capture.pictures,
            recording: capture.is_recording(),
            recording_s: capture.recording_s(now),
            zoom: Some(capture.zoom),
            width_px: self.frames.size_px.map(|size| size.0),
            height_px: self.frames.size_px.map(|size| size.1),
            field_of_view_rad: Some(self.field_of_view_rad()),
            ..CameraState::default()
        };
        if let Some(remote) = &self.core.remote {
            remote.describe(now, &self.settings, &mut state);
        }
        state.frames = capture.frames;
        let faults = [&state.fault, &self.frames.fault];
        let faults: Vec<&str> = faults
            .into_iter()
            .map(String::as_str)
            .filter(|fault| !fault.is_empty())
            .collect();
        state.fault = faults.join("; ");
        state
    }
}
