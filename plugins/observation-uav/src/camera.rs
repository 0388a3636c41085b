//! What the camera does while something is observed: begun with the observation, ended with it if it was begun for it.

use crate::model::ObservationUav;
use crate::settings::OnObserving;
use crate::watch::Begun;
use skein_plugin_sdk::Effects;
use skein_plugin_sdk::domain::payload::{CameraCommand, CameraState};

/// The stream that is run.
const FIRST_STREAM: u8 = 1;

impl ObservationUav {
    /// Begins what is configured, as soon as there is a camera. Begun when on station: the way there is of no interest.
    pub(crate) fn run_camera(&mut self, out: &mut Effects) {
        let on_station = self.watch.observation.as_ref().is_some_and(|o| o.on_station);
        let Some((name, state)) = self.payloads.camera().filter(|_| on_station) else {
            return;
        };
        let name = name.to_owned();
        let camera = command(self.settings.camera, self.settings.picture_interval_s, state);
        let running = state.streams.iter().any(|s| s.stream == FIRST_STREAM && s.running);
        if self.watch.camera == Begun::No
            && let Some(command) = camera
        {
            self.watch.camera = self.begin(&name, command, out);
        }
        if self.watch.stream == Begun::No && self.settings.stream {
            let command = (!running).then_some(CameraCommand::StartStream { stream: FIRST_STREAM });
            self.watch.stream = self.begin(&name, command, out);
        }
    }

    fn begin(&mut self, name: &str, command: Option<CameraCommand>, out: &mut Effects) -> Begun {
        let Some(command) = command else {
            return Begun::Already;
        };
        let request = self.new_request();
        out.payload_command(request, name, &command);
        Begun::ByUs
    }

    /// Ends what was begun for the observation.
    pub(crate) fn stop_camera(&mut self, out: &mut Effects) {
        let camera = std::mem::take(&mut self.watch.camera);
        let stream = std::mem::take(&mut self.watch.stream);
        let Some(name) = self.payloads.camera().map(|(name, _)| name.to_owned()) else {
            return;
        };
        let stop = match self.settings.camera {
            OnObserving::Record => CameraCommand::StopRecording,
            OnObserving::Pictures | OnObserving::Nothing => CameraCommand::StopPictures,
        };
        let stop_stream = CameraCommand::StopStream { stream: FIRST_STREAM };
        for (begun, command) in [(camera, stop), (stream, stop_stream)] {
            if begun == Begun::ByUs {
                let request = self.new_request();
                out.payload_command(request, &name, &command);
            }
        }
    }
}

/// What is to be begun: nothing at all, or nothing any more because it runs already, or this.
fn command(wanted: OnObserving, interval_s: f64, state: &CameraState) -> Option<Option<CameraCommand>> {
    match wanted {
        OnObserving::Nothing => None,
        OnObserving::Record => Some((!state.recording).then_some(CameraCommand::StartRecording)),
        OnObserving::Pictures => {
            let take = CameraCommand::TakePictures { count: 0, interval_s };
            Some((!state.capturing).then_some(take))
        }
    }
}
