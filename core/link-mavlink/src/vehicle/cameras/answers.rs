//! What a camera that this node speaks for answers to which command.
//!
//! Must never do: accept what it does not do.

use super::{ToldCamera, ToldStream};
use crate::outbox::Outbox;
use mavlink::MavHeader;
use mavlink::dialects::common::{
    CAMERA_INFORMATION_DATA, CameraCapFlags, VIDEO_STREAM_INFORMATION_DATA, VIDEO_STREAM_STATUS_DATA,
    VideoStreamEncoding, VideoStreamStatusFlags, VideoStreamType,
};
use mavlink::types::CharArray;
use skein_domain::NodeTime;

const CAMERA_INFORMATION: u32 = 259;
const VIDEO_STREAM_INFORMATION: u32 = 269;
const VIDEO_STREAM_STATUS: u32 = 270;
const COMMAND_ACK: u32 = 77;

/// `MAV_CMD_REQUEST_MESSAGE`, and the older commands for one message each, which ground stations still use.
const REQUEST_MESSAGE: u16 = 512;
const REQUEST_CAMERA_INFORMATION: u16 = 521;
const REQUEST_VIDEO_STREAM_INFORMATION: u16 = 2504;
const REQUEST_VIDEO_STREAM_STATUS: u16 = 2505;
/// `MAV_CMD_VIDEO_START_STREAMING`.
const START_STREAMING: u16 = 2502;

/// `MAV_RESULT_ACCEPTED`, `MAV_RESULT_DENIED` and `MAV_RESULT_UNSUPPORTED`.
const ACCEPTED: u8 = 0;
const DENIED: u8 = 2;
const UNSUPPORTED: u8 = 3;

/// One frame of an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Answer {
    /// How the command ended, to whoever asked.
    Acknowledgement { command: u16, result: u8, to: (u8, u8) },
    /// CAMERA_INFORMATION.
    Information,
    /// VIDEO_STREAM_INFORMATION of one stream, counted from zero.
    Stream(usize),
    /// VIDEO_STREAM_STATUS of one stream, counted from zero.
    Status(usize),
}

/// The message that a command asks for, and of which stream; zero asks for all.
fn asked(command: u16, (first, second): (f32, f32)) -> Option<(u32, f32)> {
    match command {
        REQUEST_MESSAGE if first >= 0.0 => Some((first as u32, second)),
        REQUEST_CAMERA_INFORMATION => Some((CAMERA_INFORMATION, 0.0)),
        REQUEST_VIDEO_STREAM_INFORMATION => Some((VIDEO_STREAM_INFORMATION, first)),
        REQUEST_VIDEO_STREAM_STATUS => Some((VIDEO_STREAM_STATUS, first)),
        _ => None,
    }
}

/// Whether a command asks for what only a camera can tell.
pub(super) fn is_about_cameras(command: u16, parameters: (f32, f32)) -> bool {
    let message = asked(command, parameters).map(|(message, _)| message);
    matches!(
        message,
        Some(CAMERA_INFORMATION | VIDEO_STREAM_INFORMATION | VIDEO_STREAM_STATUS)
    )
}

/// The answers of a camera with so many streams, in their order.
pub(super) fn to(command: u16, parameters: (f32, f32), asker: (u8, u8), streams: usize) -> Vec<Answer> {
    let which = |stream: f32| {
        let all = stream == 0.0;
        (0..streams).filter(move |at| all || *at as f32 + 1.0 == stream)
    };
    let told: Option<Vec<Answer>> = match asked(command, parameters) {
        Some((CAMERA_INFORMATION, _)) => Some(vec![Answer::Information]),
        Some((VIDEO_STREAM_INFORMATION, stream)) => Some(which(stream).map(Answer::Stream).collect()),
        Some((VIDEO_STREAM_STATUS, stream)) => Some(which(stream).map(Answer::Status).collect()),
        // It runs in any case, and whoever asks for one stream only may well not know that.
        None if command == START_STREAMING => Some(Vec::new()),
        _ => None,
    };
    let result = match &told {
        None => UNSUPPORTED,
        Some(messages) if messages.is_empty() && command != START_STREAMING => DENIED,
        Some(_) => ACCEPTED,
    };
    let acknowledgement = Answer::Acknowledgement {
        command,
        result,
        to: asker,
    };
    std::iter::once(acknowledgement)
        .chain(told.into_iter().flatten())
        .collect()
}

impl Answer {
    pub(super) fn push(self, now: NodeTime, camera: &ToldCamera, sender: &mut MavHeader, outbox: &mut Outbox) {
        match self {
            Self::Acknowledgement { command, result, to } => {
                let [low, high] = command.to_le_bytes();
                // Its number may be none that the dialect knows.
                let payload = [low, high, result, 0, 0, 0, 0, 0, to.0, to.1];
                let pushed = outbox.push_payload_from(sender, COMMAND_ACK, &payload);
                debug_assert!(pushed.is_ok(), "COMMAND_ACK is of the dialect");
            }
            Self::Information => outbox.push_from(sender, &information(now, camera)),
            Self::Stream(at) => {
                if let Some(stream) = camera.streams.get(at) {
                    outbox.push_from(sender, &stream_information(at, camera.streams.len(), stream));
                }
            }
            Self::Status(at) => {
                if let Some(stream) = camera.streams.get(at) {
                    outbox.push_from(sender, &stream_status(at, stream));
                }
            }
        }
    }
}

fn information(now: NodeTime, camera: &ToldCamera) -> CAMERA_INFORMATION_DATA {
    let (width_px, height_px) = camera.streams.first().map_or((0, 0), |stream| stream.size_px);
    CAMERA_INFORMATION_DATA {
        time_boot_ms: (now.0 / 1000) as u32,
        vendor_name: *CharArray::from("Skein"),
        model_name: *CharArray::from(camera.name.as_str()),
        focal_length: f32::NAN,
        sensor_size_h: f32::NAN,
        sensor_size_v: f32::NAN,
        resolution_h: short(width_px),
        resolution_v: short(height_px),
        flags: CameraCapFlags::CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM,
        ..CAMERA_INFORMATION_DATA::default()
    }
}

fn stream_information(at: usize, count: usize, stream: &ToldStream) -> VIDEO_STREAM_INFORMATION_DATA {
    let status = stream_status(at, stream);
    VIDEO_STREAM_INFORMATION_DATA {
        stream_id: status.stream_id,
        count: count as u8,
        mavtype: VideoStreamType::VIDEO_STREAM_TYPE_RTPUDP,
        flags: status.flags,
        framerate: status.framerate,
        resolution_h: status.resolution_h,
        resolution_v: status.resolution_v,
        bitrate: status.bitrate,
        name: CharArray::from(stream.name.as_str()),
        // Of a stream over UDP it is the port at which the ground station is to listen.
        uri: CharArray::from(stream.port.to_string().as_str()),
        encoding: VideoStreamEncoding::VIDEO_STREAM_ENCODING_H264,
        ..VIDEO_STREAM_INFORMATION_DATA::default()
    }
}

fn stream_status(at: usize, stream: &ToldStream) -> VIDEO_STREAM_STATUS_DATA {
    let mut flags = VideoStreamStatusFlags::empty();
    flags.set(
        VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING,
        stream.running,
    );
    VIDEO_STREAM_STATUS_DATA {
        stream_id: at as u8 + 1,
        flags,
        framerate: stream.rate_hz as f32,
        resolution_h: short(stream.size_px.0),
        resolution_v: short(stream.size_px.1),
        bitrate: stream.bits_per_s as u32,
        ..VIDEO_STREAM_STATUS_DATA::default()
    }
}

fn short(length_px: u32) -> u16 {
    u16::try_from(length_px).unwrap_or(u16::MAX)
}
