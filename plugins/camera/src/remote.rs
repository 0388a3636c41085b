//! A camera that speaks MAVLink's camera protocol v2: asked what it is and does, told what to do.

use crate::capture::{mode_number, mode_of};
use crate::occurrence::CameraEvent;
use crate::settings::Settings;
use mavlink::MessageData;
use mavlink::dialects::common::{
    CAMERA_CAPTURE_STATUS_DATA, CAMERA_IMAGE_CAPTURED_DATA, CAMERA_INFORMATION_DATA, CAMERA_SETTINGS_DATA,
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, CameraCapFlags, HEARTBEAT_DATA, MavCmd, STORAGE_INFORMATION_DATA,
    StorageStatus, VIDEO_STREAM_INFORMATION_DATA, VIDEO_STREAM_STATUS_DATA, VideoStreamStatusFlags,
};
use minicbor::{Decode, Encode};
use payload_mavlink::{Outcome, Requests, decode, send, text};
use skein_domain::payload::{CameraCommand, CameraState, CameraStream, MavlinkMessage};
use skein_domain::{CommandId, NodeTime, Refusal, SystemId};
use skein_plugin_sdk::Effects;

/// Messages that a camera is known by.
pub(crate) const MESSAGES: &[u32] = &[
    HEARTBEAT_DATA::ID,
    COMMAND_ACK_DATA::ID,
    CAMERA_INFORMATION_DATA::ID,
    CAMERA_SETTINGS_DATA::ID,
    STORAGE_INFORMATION_DATA::ID,
    CAMERA_CAPTURE_STATUS_DATA::ID,
    CAMERA_IMAGE_CAPTURED_DATA::ID,
    VIDEO_STREAM_INFORMATION_DATA::ID,
    VIDEO_STREAM_STATUS_DATA::ID,
];

/// What is asked for and how often while the camera is heard, in seconds.
const QUESTIONS: [(u32, f64); 5] = [
    (CAMERA_INFORMATION_DATA::ID, 1.0),
    (CAMERA_SETTINGS_DATA::ID, 2.0),
    (CAMERA_CAPTURE_STATUS_DATA::ID, 2.0),
    (STORAGE_INFORMATION_DATA::ID, 10.0),
    (VIDEO_STREAM_INFORMATION_DATA::ID, 10.0),
];
/// More streams than a camera has.
const MOST_STREAMS: usize = 16;
/// Zoom as a share of the whole range, in the numbers of SET_CAMERA_ZOOM.
const ZOOM_RANGE: f32 = 2.0;
/// How often CAMERA_CAPTURE_STATUS is sent by itself while recording, per second.
const STATUS_RATE_HZ: f32 = 1.0;

/// The client of a MAVLink camera.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Remote {
    #[n(0)]
    system_id: u8,
    #[n(1)]
    heard: Option<NodeTime>,
    #[n(2)]
    requests: Requests<CommandId>,
    /// When each of [`QUESTIONS`] was last asked.
    #[n(3)]
    asked: [Option<NodeTime>; QUESTIONS.len()],
    #[n(4)]
    information: Option<Information>,
    #[n(5)]
    mode: u8,
    /// Share of the zoom range in percent.
    #[n(6)]
    zoom_percent: Option<f64>,
    #[n(7)]
    storage: Option<Storage>,
    #[n(8)]
    capturing: bool,
    #[n(9)]
    recording: bool,
    #[n(10)]
    recording_s: f64,
    #[n(11)]
    pictures: u32,
    #[n(12)]
    streams: Vec<Stream>,
    /// Numbers single pictures, so that a command sent twice takes one.
    #[n(13)]
    capture_sequence: u32,
}

#[derive(Debug, Clone, PartialEq, Encode, Decode)]
struct Information {
    #[n(0)]
    vendor: String,
    #[n(1)]
    model: String,
    #[n(2)]
    capabilities: u32,
    #[n(3)]
    width_px: u16,
    #[n(4)]
    height_px: u16,
    /// Horizontal, at the widest zoom, in radians.
    #[n(5)]
    field_of_view_rad: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
struct Storage {
    #[n(0)]
    free_mib: f64,
    #[n(1)]
    total_mib: f64,
    #[n(2)]
    missing: bool,
    #[n(3)]
    unformatted: bool,
}

#[derive(Debug, Clone, PartialEq, Encode, Decode)]
struct Stream {
    #[n(0)]
    stream: u8,
    #[n(1)]
    name: String,
    #[n(2)]
    uri: String,
    #[n(3)]
    running: bool,
    #[n(4)]
    rate_hz: f64,
    #[n(5)]
    width_px: u16,
    #[n(6)]
    height_px: u16,
}

impl Remote {
    pub(crate) fn new(system_id: Option<SystemId>) -> Self {
        Self {
            system_id: system_id.map_or(0, |id| id.0),
            ..Self::default()
        }
    }

    pub(crate) fn is_connected(&self, now: NodeTime, settings: &Settings) -> bool {
        self.heard
            .is_some_and(|heard| now.seconds_since(heard) <= settings.lost_after_s)
    }

    /// Takes a message; tells how a command ended, if one did.
    pub(crate) fn hear(
        &mut self,
        now: NodeTime,
        message: &MavlinkMessage,
        settings: &Settings,
        effects: &mut Effects,
    ) -> Option<Outcome<CommandId>> {
        if message.component_id != settings.component_id {
            return None;
        }
        self.heard = Some(now);
        self.system_id = message.system_id;
        match message.message_id {
            COMMAND_ACK_DATA::ID => {
                let outcome = self.requests.heard(now, message);
                if outcome.is_some() {
                    self.ask_anew();
                }
                return outcome;
            }
            CAMERA_INFORMATION_DATA::ID => self.hear_information(&decode(message)?),
            CAMERA_SETTINGS_DATA::ID => self.hear_settings(&decode(message)?),
            STORAGE_INFORMATION_DATA::ID => self.hear_storage(&decode(message)?),
            CAMERA_CAPTURE_STATUS_DATA::ID => self.hear_status(&decode(message)?, effects),
            CAMERA_IMAGE_CAPTURED_DATA::ID => self.hear_picture(&decode(message)?, effects),
            VIDEO_STREAM_INFORMATION_DATA::ID => self.hear_stream(&decode(message)?),
            VIDEO_STREAM_STATUS_DATA::ID => self.hear_stream_status(&decode(message)?),
            _ => {}
        }
        None
    }

    /// What it does may have changed: ask soon.
    fn ask_anew(&mut self) {
        for ((id, _), asked) in QUESTIONS.iter().zip(&mut self.asked) {
            if *id != CAMERA_INFORMATION_DATA::ID && *id != STORAGE_INFORMATION_DATA::ID {
                *asked = None;
            }
        }
    }

    fn hear_information(&mut self, said: &CAMERA_INFORMATION_DATA) {
        let (focal, sensor) = (f64::from(said.focal_length), f64::from(said.sensor_size_h));
        let known = focal.is_finite() && focal > 0.0 && sensor.is_finite() && sensor > 0.0;
        self.information = Some(Information {
            vendor: text(&said.vendor_name),
            model: text(&said.model_name),
            capabilities: said.flags.bits(),
            width_px: said.resolution_h,
            height_px: said.resolution_v,
            field_of_view_rad: known.then(|| 2.0 * (0.5 * sensor / focal).atan()),
        });
    }

    fn hear_settings(&mut self, said: &CAMERA_SETTINGS_DATA) {
        self.mode = said.mode_id as u8;
        let zoom = f64::from(said.zoomLevel);
        self.zoom_percent = (0.0..=100.0).contains(&zoom).then_some(zoom);
    }

    fn hear_storage(&mut self, said: &STORAGE_INFORMATION_DATA) {
        // Storage is counted from 1; the first is where pictures go.
        if said.storage_id > 1 || said.status == StorageStatus::STORAGE_STATUS_NOT_SUPPORTED {
            return;
        }
        let sane = |mib: f32| if mib.is_finite() { f64::from(mib).max(0.0) } else { 0.0 };
        self.storage = Some(Storage {
            free_mib: sane(said.available_capacity),
            total_mib: sane(said.total_capacity),
            missing: said.status == StorageStatus::STORAGE_STATUS_EMPTY,
            unformatted: said.status == StorageStatus::STORAGE_STATUS_UNFORMATTED,
        });
    }

    fn hear_status(&mut self, said: &CAMERA_CAPTURE_STATUS_DATA, effects: &mut Effects) {
        self.capturing = said.image_status != 0;
        let records = said.video_status != 0;
        if records && !self.recording {
            effects.occurrence(&CameraEvent::RecordingStarted);
        } else if !records && self.recording {
            effects.occurrence(&CameraEvent::RecordingStopped {
                seconds: self.recording_s,
            });
        }
        self.recording = records;
        if records || said.recording_time_ms > 0 {
            self.recording_s = f64::from(said.recording_time_ms) * 1e-3;
        }
        // Zero may mean that it does not say.
        if let Ok(pictures @ 1..) = u32::try_from(said.image_count) {
            self.pictures = pictures;
        }
    }

    fn hear_picture(&mut self, said: &CAMERA_IMAGE_CAPTURED_DATA, effects: &mut Effects) {
        let Ok(before) = u32::try_from(said.image_index) else {
            return;
        };
        // It counts from 0.
        let picture = before.saturating_add(1);
        if picture > self.pictures {
            self.pictures = picture;
            effects.occurrence(&CameraEvent::PictureTaken { picture, frame: None });
        }
    }

    fn hear_stream(&mut self, said: &VIDEO_STREAM_INFORMATION_DATA) {
        let stream = Stream {
            stream: said.stream_id,
            name: text(&*said.name),
            uri: text(&*said.uri),
            running: said
                .flags
                .contains(VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING),
            rate_hz: sane_rate(said.framerate),
            width_px: said.resolution_h,
            height_px: said.resolution_v,
        };
        let has_room = self.streams.len() < MOST_STREAMS;
        match self.streams.iter_mut().find(|known| known.stream == stream.stream) {
            Some(known) => *known = stream,
            None if has_room => self.streams.push(stream),
            None => return,
        }
        self.streams.sort_by_key(|stream| stream.stream);
    }

    fn hear_stream_status(&mut self, said: &VIDEO_STREAM_STATUS_DATA) {
        if let Some(known) = self.streams.iter_mut().find(|known| known.stream == said.stream_id) {
            known.running = said
                .flags
                .contains(VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING);
            known.rate_hz = sane_rate(said.framerate);
            (known.width_px, known.height_px) = (said.resolution_h, said.resolution_v);
        }
    }

    /// Once per tick: asks what is due, and again what was not acknowledged.
    pub(crate) fn work(
        &mut self,
        now: NodeTime,
        settings: &Settings,
        effects: &mut Effects,
    ) -> Vec<Outcome<CommandId>> {
        let connected = self.is_connected(now, settings);
        for (index, (id, pause_s)) in QUESTIONS.into_iter().enumerate() {
            let first = id == CAMERA_INFORMATION_DATA::ID;
            let wanted = if first {
                self.information.is_none() || !connected
            } else {
                self.may_ask(id, connected)
            };
            let asked = self.asked.get_mut(index);
            let Some(asked) = asked.filter(|asked| asked.is_none_or(|then| now.seconds_since(then) >= pause_s)) else {
                continue;
            };
            if wanted {
                *asked = Some(now);
                self.request_message(id, settings, effects);
            }
        }
        self.requests.work(now, settings.patience(), effects)
    }

    fn may_ask(&self, id: u32, connected: bool) -> bool {
        connected
            && self.information.is_some()
            && (id != VIDEO_STREAM_INFORMATION_DATA::ID || self.has(CameraCapFlags::CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM))
    }

    fn has(&self, capability: CameraCapFlags) -> bool {
        let bits = self
            .information
            .as_ref()
            .map_or(0, |information| information.capabilities);
        CameraCapFlags::from_bits_retain(bits).contains(capability)
    }

    fn request_message(&self, id: u32, settings: &Settings, effects: &mut Effects) {
        // Ids below 2^24 are exact. The second parameter is which storage or stream: 0 is all.
        send(
            &self.command(MavCmd::MAV_CMD_REQUEST_MESSAGE, [id as f32, 0.0, 0.0, 0.0], settings),
            effects,
        );
    }

    fn command(
        &self,
        command: MavCmd,
        [param1, param2, param3, param4]: [f32; 4],
        settings: &Settings,
    ) -> COMMAND_LONG_DATA {
        COMMAND_LONG_DATA {
            param1,
            param2,
            param3,
            param4,
            command,
            target_system: self.system_id,
            target_component: settings.component_id,
            ..COMMAND_LONG_DATA::default()
        }
    }

    /// Tells it what to do. The outcome follows from [`Self::hear`] or [`Self::work`].
    pub(crate) fn tell(
        &mut self,
        now: NodeTime,
        id: CommandId,
        command: CameraCommand,
        settings: &Settings,
    ) -> Result<(), Refusal> {
        if !self.is_connected(now, settings) {
            return Err(Refusal::not_running("the camera"));
        }
        self.can(command)?;
        let (what, params) = match command {
            CameraCommand::TakePictures { count, interval_s } => {
                let single = count == 1;
                self.capture_sequence += u32::from(single);
                let sequence = if single { self.capture_sequence as f32 } else { 0.0 };
                (
                    MavCmd::MAV_CMD_IMAGE_START_CAPTURE,
                    [0.0, interval_s as f32, count as f32, sequence],
                )
            }
            CameraCommand::StopPictures => (MavCmd::MAV_CMD_IMAGE_STOP_CAPTURE, [0.0; 4]),
            CameraCommand::StartRecording => (MavCmd::MAV_CMD_VIDEO_START_CAPTURE, [0.0, STATUS_RATE_HZ, 0.0, 0.0]),
            CameraCommand::StopRecording => (MavCmd::MAV_CMD_VIDEO_STOP_CAPTURE, [0.0; 4]),
            CameraCommand::Zoom { factor } => {
                let percent = 100.0 * (factor - 1.0) / (settings.zoom_max - 1.0).max(f64::EPSILON);
                (
                    MavCmd::MAV_CMD_SET_CAMERA_ZOOM,
                    [ZOOM_RANGE, percent.clamp(0.0, 100.0) as f32, 0.0, 0.0],
                )
            }
            CameraCommand::SetMode { mode } => (
                MavCmd::MAV_CMD_SET_CAMERA_MODE,
                [0.0, f32::from(mode_number(mode)), 0.0, 0.0],
            ),
            CameraCommand::StartStream { stream } => (
                MavCmd::MAV_CMD_VIDEO_START_STREAMING,
                [f32::from(stream), 0.0, 0.0, 0.0],
            ),
            CameraCommand::StopStream { stream } => {
                (MavCmd::MAV_CMD_VIDEO_STOP_STREAMING, [f32::from(stream), 0.0, 0.0, 0.0])
            }
        };
        let message = self.command(what, params, settings);
        if self.requests.ask(id, &message) {
            return Ok(());
        }
        Err(Refusal::not_permitted("too many commands wait for the camera's answer"))
    }

    /// Whether the camera can do it, by what it says of itself.
    fn can(&self, command: CameraCommand) -> Result<(), Refusal> {
        let (needs, what) = match command {
            CameraCommand::TakePictures { .. } | CameraCommand::StopPictures => {
                (CameraCapFlags::CAMERA_CAP_FLAGS_CAPTURE_IMAGE, "pictures")
            }
            CameraCommand::StartRecording | CameraCommand::StopRecording => {
                (CameraCapFlags::CAMERA_CAP_FLAGS_CAPTURE_VIDEO, "recording")
            }
            CameraCommand::Zoom { .. } => (CameraCapFlags::CAMERA_CAP_FLAGS_HAS_BASIC_ZOOM, "zoom"),
            CameraCommand::SetMode { .. } => (CameraCapFlags::CAMERA_CAP_FLAGS_HAS_MODES, "modes"),
            CameraCommand::StartStream { .. } | CameraCommand::StopStream { .. } => {
                (CameraCapFlags::CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM, "streams")
            }
        };
        if self.information.is_none() || self.has(needs) {
            return Ok(());
        }
        Err(Refusal::not_supported(format!("{what} by this camera")))
    }

    /// The zoom factor, if it says.
    pub(crate) fn zoom(&self, settings: &Settings) -> Option<f64> {
        self.zoom_percent
            .map(|percent| 1.0 + percent * 0.01 * (settings.zoom_max - 1.0))
    }

    /// Writes what it says into a state.
    pub(crate) fn describe(&self, now: NodeTime, settings: &Settings, state: &mut CameraState) {
        let connected = self.is_connected(now, settings);
        let information = self.information.as_ref();
        state.connected = connected;
        state.vendor = information.map_or_else(String::new, |i| i.vendor.clone());
        state.model = information.map_or_else(String::new, |i| i.model.clone());
        state.mode = mode_of(self.mode);
        state.capturing = self.capturing;
        state.pictures = self.pictures;
        state.recording = self.recording;
        state.recording_s = self.recording_s;
        state.zoom = self.zoom(settings);
        state.storage_free_mib = self.storage.map(|storage| storage.free_mib);
        state.storage_total_mib = self.storage.map(|storage| storage.total_mib);
        if let Some(i) = information {
            let known = |px: u16| (px > 0).then_some(u32::from(px));
            (state.width_px, state.height_px) = (known(i.width_px), known(i.height_px));
            let at_zoom = |widest| settings.field_of_view_at(widest, self.zoom(settings).unwrap_or(1.0));
            state.field_of_view_rad = i.field_of_view_rad.map(at_zoom);
        }
        state.streams = self.streams.iter().map(CameraStream::from).collect();
        state.fault = match self.storage {
            Some(Storage { missing: true, .. }) => "no storage in the camera".to_owned(),
            Some(Storage { unformatted: true, .. }) => "the camera's storage is not formatted".to_owned(),
            _ => String::new(),
        };
    }
}

fn sane_rate(rate_hz: f32) -> f64 {
    if rate_hz.is_finite() { f64::from(rate_hz) } else { 0.0 }
}

impl From<&Stream> for CameraStream {
    fn from(stream: &Stream) -> Self {
        Self {
            stream: stream.stream,
            name: stream.name.clone(),
            uri: stream.uri.clone(),
            running: stream.running,
            rate_hz: stream.rate_hz,
            width_px: u32::from(stream.width_px),
            height_px: u32::from(stream.height_px),
        }
    }
}
