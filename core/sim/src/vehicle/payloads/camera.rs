//! The camera's messages and commands.

use super::super::channel::{Channel, LinkKind, Outbox, Stream};
use super::super::telemetry::{e7, mm};
use super::super::{SimVehicle, telemetry};
use crate::wire::CommandRequest;
use mavlink::dialects::common::*;
use mavlink::types::CharArray;
use nalgebra::{UnitQuaternion, Vector3};
use skein_sim_payloads::CAMERA_COMPONENT;
use skein_sim_payloads::camera::{Camera, Outcome, Picture, SENSOR_WIDTH_MM, ZoomAsk};

const STREAM_RATE_HZ: f32 = 30.0;
const STREAM_BIT_S: u32 = 4_000_000;
/// Video, pictures, modes, either in the mode of the other, survey, zoom, stream.
const CAPABILITIES: u32 = 1 | 2 | 4 | 8 | 16 | 32 | 64 | 256;
/// Highest rate of CAMERA_CAPTURE_STATUS while recording, in hertz.
const STATUS_RATE_MAX_HZ: f64 = 50.0;
/// "At infinity": the middle of the picture does not meet the ground.
const NO_GROUND: i32 = i32::MIN;

/// The messages that the older commands ask for.
const fn asked_the_old_way(command: u16) -> Option<u32> {
    match command {
        521 => Some(259),
        522 => Some(260),
        525 => Some(261),
        527 => Some(262),
        2504 => Some(269),
        2505 => Some(270),
        _ => None,
    }
}

/// Whether a camera answers to a command that is sent to everyone.
pub(super) fn is_camera_command(command: u16) -> bool {
    asked_the_old_way(command).is_some()
        || matches!(command, 526 | 529 | 530 | 531 | 2000 | 2001 | 2500 | 2501 | 2502 | 2503)
}

/// The acknowledgement of what a camera said to a command.
fn acknowledged(outcome: Outcome) -> MavResult {
    match outcome {
        Outcome::Accepted => MavResult::MAV_RESULT_ACCEPTED,
        Outcome::Rejected => MavResult::MAV_RESULT_TEMPORARILY_REJECTED,
        Outcome::Denied => MavResult::MAV_RESULT_DENIED,
        Outcome::Failed => MavResult::MAV_RESULT_FAILED,
    }
}

impl SimVehicle {
    /// Carries out a command to the camera.
    pub(super) fn run_camera_command(&mut self, link: LinkKind, c: &CommandRequest, out: &mut Outbox) -> MavResult {
        let (now_s, [a, b, third, fourth]) = (self.time_s, c.param.map(f64::from));
        if let Some(message_id) = asked_the_old_way(c.command) {
            let asked = CommandRequest {
                command: super::REQUEST_MESSAGE,
                param: [message_id as f32, c.param[0], 0.0, 0.0],
                ..*c
            };
            return self.about_message(link, CAMERA_COMPONENT, &asked, out);
        }
        let Some(camera) = &mut self.payloads.camera else {
            return MavResult::MAV_RESULT_UNSUPPORTED;
        };
        let outcome = match c.command {
            526 => camera.format(a, b == 1.0, third == 1.0),
            529 => camera.reset_settings(),
            530 => camera.set_mode(b),
            531 => zoom(camera, a, b),
            2000 => camera.start_pictures(now_s, b, third, fourth),
            2001 => camera.stop_pictures(),
            2500 => camera.start_recording(now_s),
            2501 => camera.stop_recording(),
            2502 | 2503 if a == 0.0 || a == 1.0 => {
                camera.streaming = c.command == 2502;
                Outcome::Accepted
            }
            2502 | 2503 => Outcome::Denied,
            _ => return MavResult::MAV_RESULT_UNSUPPORTED,
        };
        if outcome == Outcome::Accepted {
            self.adapt_status_rate(link, c);
        }
        acknowledged(outcome)
    }

    /// Whoever starts a recording says how often it wants to hear how that goes.
    fn adapt_status_rate(&mut self, link: LinkKind, c: &CommandRequest) {
        let interval_us = match c.command {
            2500 if c.param[1] > 0.0 => 1e6 / f64::from(c.param[1]).min(STATUS_RATE_MAX_HZ),
            2500 | 2501 => -1.0,
            _ => return,
        };
        let now_us = self.time_us();
        let stream = Stream {
            component: CAMERA_COMPONENT,
            message_id: 262,
        };
        self.on_channel(link, |_, channel| {
            channel.set_interval(stream, interval_us, now_us);
        });
    }

    pub(super) fn send_camera_message(
        &self,
        channel: &mut Channel,
        message_id: u32,
        index: u8,
        out: &mut Outbox,
    ) -> bool {
        let Some(camera) = &self.payloads.camera else {
            return false;
        };
        // There is one storage and one stream; zero asks for all.
        if matches!(message_id, 261 | 269 | 270) && index > 1 {
            return false;
        }
        let from = CAMERA_COMPONENT;
        match message_id {
            259 => channel.send_as(from, out, &self.camera_information(camera)),
            260 => channel.send_as(from, out, &self.camera_settings(camera)),
            261 => channel.send_as(from, out, &self.storage_information(camera)),
            262 => channel.send_as(from, out, &self.capture_status(camera)),
            263 if camera.pictures > 0 => {
                let last = Picture {
                    index: camera.pictures - 1,
                    taken: true,
                };
                channel.send_as(from, out, &self.image_captured(&last));
            }
            269 => channel.send_as(from, out, &self.stream_information(camera)),
            270 => channel.send_as(from, out, &stream_status(camera)),
            271 => channel.send_as(from, out, &self.field_of_view(camera)),
            _ => return false,
        }
        true
    }

    fn camera_information(&self, camera: &Camera) -> CAMERA_INFORMATION_DATA {
        let settings = &camera.settings;
        let sensor_height_mm = SENSOR_WIDTH_MM * f64::from(settings.height_px) / f64::from(settings.width_px.max(1));
        CAMERA_INFORMATION_DATA {
            time_boot_ms: self.up_ms(),
            vendor_name: name("Skein"),
            model_name: name("Simulated camera"),
            firmware_version: 1,
            focal_length: camera.focal_length_mm() as f32,
            sensor_size_h: SENSOR_WIDTH_MM as f32,
            sensor_size_v: sensor_height_mm as f32,
            resolution_h: settings.width_px,
            resolution_v: settings.height_px,
            flags: CameraCapFlags::from_bits_retain(CAPABILITIES),
            gimbal_device_id: self
                .payloads
                .gimbal
                .as_ref()
                .map_or(0, |_| skein_sim_payloads::GIMBAL_COMPONENT),
            ..CAMERA_INFORMATION_DATA::default()
        }
    }

    fn camera_settings(&self, camera: &Camera) -> CAMERA_SETTINGS_DATA {
        CAMERA_SETTINGS_DATA {
            time_boot_ms: self.up_ms(),
            mode_id: match camera.mode {
                0 => CameraMode::CAMERA_MODE_IMAGE,
                1 => CameraMode::CAMERA_MODE_VIDEO,
                _ => CameraMode::CAMERA_MODE_IMAGE_SURVEY,
            },
            zoomLevel: camera.zoom_percent() as f32,
            focusLevel: f32::NAN,
            ..CAMERA_SETTINGS_DATA::default()
        }
    }

    fn storage_information(&self, camera: &Camera) -> STORAGE_INFORMATION_DATA {
        STORAGE_INFORMATION_DATA {
            time_boot_ms: self.up_ms(),
            storage_id: 1,
            storage_count: 1,
            status: StorageStatus::STORAGE_STATUS_READY,
            total_capacity: camera.settings.storage_mib as f32,
            used_capacity: camera.used_mib() as f32,
            available_capacity: camera.available_mib() as f32,
            read_speed: 80.0,
            write_speed: 60.0,
            mavtype: StorageType::STORAGE_TYPE_MICROSD,
            name: CharArray::from("microSD"),
            storage_usage: StorageUsageFlag::from_bits_retain(0b111),
        }
    }

    fn capture_status(&self, camera: &Camera) -> CAMERA_CAPTURE_STATUS_DATA {
        let recording_s = camera.recording_s(self.time_s);
        CAMERA_CAPTURE_STATUS_DATA {
            time_boot_ms: self.up_ms(),
            image_status: if camera.interval_s().is_some() { 3 } else { 0 },
            image_interval: camera.interval_s().unwrap_or(0.0) as f32,
            video_status: u8::from(recording_s.is_some()),
            recording_time_ms: (recording_s.unwrap_or(0.0) * 1e3) as u32,
            available_capacity: camera.available_mib() as f32,
            image_count: camera.pictures,
            ..CAMERA_CAPTURE_STATUS_DATA::default()
        }
    }

    /// Pitch and yaw of the optical axis, yaw from north.
    fn camera_direction(&self) -> (f64, f64) {
        match &self.payloads.gimbal {
            Some(gimbal) => (gimbal.head.pitch.angle_rad, gimbal.yaw_north_rad(&self.carrier())),
            None => (self.body.roll_pitch_rad().1, self.body.yaw_rad),
        }
    }

    pub(super) fn image_captured(&self, picture: &Picture) -> CAMERA_IMAGE_CAPTURED_DATA {
        let here = self.geodetic_of(&self.estimator.now.position);
        let (pitch_rad, yaw_rad) = self.camera_direction();
        let file = if picture.taken {
            format!("/DCIM/{:05}.jpg", picture.index)
        } else {
            String::new()
        };
        CAMERA_IMAGE_CAPTURED_DATA {
            time_utc: self.identity.utc_at_zero_us + self.time_us(),
            time_boot_ms: self.up_ms(),
            lat: e7(here.latitude_deg),
            lon: e7(here.longitude_deg),
            alt: mm(here.altitude_amsl_m),
            relative_alt: mm(self.relative_altitude_m()),
            q: telemetry::wire_quaternion(&UnitQuaternion::from_euler_angles(0.0, pitch_rad, yaw_rad)),
            image_index: picture.index,
            capture_result: MavBool::from_bits_retain(u8::from(picture.taken)),
            file_url: CharArray::from(file.as_str()),
            ..CAMERA_IMAGE_CAPTURED_DATA::default()
        }
    }

    /// The stream as it would be offered; nothing is served there.
    fn stream_information(&self, camera: &Camera) -> VIDEO_STREAM_INFORMATION_DATA {
        let status = stream_status(camera);
        VIDEO_STREAM_INFORMATION_DATA {
            stream_id: 1,
            count: 1,
            mavtype: VideoStreamType::VIDEO_STREAM_TYPE_RTSP,
            flags: status.flags,
            framerate: status.framerate,
            resolution_h: status.resolution_h,
            resolution_v: status.resolution_v,
            bitrate: status.bitrate,
            hfov: status.hfov,
            name: CharArray::from("simulated"),
            uri: CharArray::from(format!("rtsp://127.0.0.1:8554/vehicle{}", self.identity.system_id).as_str()),
            encoding: VideoStreamEncoding::VIDEO_STREAM_ENCODING_H264,
            ..VIDEO_STREAM_INFORMATION_DATA::default()
        }
    }

    fn field_of_view(&self, camera: &Camera) -> CAMERA_FOV_STATUS_DATA {
        let own = self.estimator.now.position;
        let here = self.geodetic_of(&own);
        let (pitch_rad, yaw_rad) = self.camera_direction();
        let hfov_rad = camera.field_of_view_rad();
        let aspect = f64::from(camera.settings.height_px) / f64::from(camera.settings.width_px.max(1));
        let height_m = self.estimator.now.height_m.max(0.0);
        let middle = (pitch_rad < -0.01).then(|| {
            let (sin_yaw, cos_yaw) = yaw_rad.sin_cos();
            let reach_m = height_m / (-pitch_rad).tan();
            self.geodetic_of(&(own + Vector3::new(reach_m * cos_yaw, reach_m * sin_yaw, height_m)))
        });
        CAMERA_FOV_STATUS_DATA {
            time_boot_ms: self.up_ms(),
            lat_camera: e7(here.latitude_deg),
            lon_camera: e7(here.longitude_deg),
            alt_camera: mm(here.altitude_amsl_m),
            lat_image: middle.map_or(NO_GROUND, |place| e7(place.latitude_deg)),
            lon_image: middle.map_or(NO_GROUND, |place| e7(place.longitude_deg)),
            alt_image: middle.map_or(NO_GROUND, |place| mm(place.altitude_amsl_m)),
            q: telemetry::wire_quaternion(&UnitQuaternion::from_euler_angles(0.0, pitch_rad, yaw_rad)),
            hfov: hfov_rad.to_degrees() as f32,
            vfov: (2.0 * ((0.5 * hfov_rad).tan() * aspect).atan()).to_degrees() as f32,
            ..CAMERA_FOV_STATUS_DATA::default()
        }
    }
}

fn stream_status(camera: &Camera) -> VIDEO_STREAM_STATUS_DATA {
    VIDEO_STREAM_STATUS_DATA {
        stream_id: 1,
        flags: VideoStreamStatusFlags::from_bits_retain(u16::from(camera.streaming)),
        framerate: STREAM_RATE_HZ,
        resolution_h: camera.settings.width_px,
        resolution_v: camera.settings.height_px,
        bitrate: STREAM_BIT_S,
        hfov: camera.field_of_view_rad().to_degrees().round() as u16,
        ..VIDEO_STREAM_STATUS_DATA::default()
    }
}

fn zoom(camera: &mut Camera, kind: f64, value: f64) -> Outcome {
    let ask = match kind as i32 {
        0 => ZoomAsk::Step(value),
        1 => ZoomAsk::Continuous(value),
        2 => ZoomAsk::Range(value),
        3 => ZoomAsk::FocalLength(value),
        4 => ZoomAsk::FieldOfView(value),
        _ => return Outcome::Denied,
    };
    camera.zoom(ask)
}

/// A name in a field of 32 bytes.
fn name(text: &str) -> [u8; 32] {
    let mut bytes = [0; 32];
    bytes.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = from);
    bytes
}
