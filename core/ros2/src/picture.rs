//! Frames of cameras as `sensor_msgs` has them: a JPEG, how the camera sees, and where it was.
//!
//! Must never do: encode what nobody listens to; that is for the caller to know.

use crate::frames;
use crate::interfaces::geometry::{Transform, TransformStamped, Vector3};
use crate::interfaces::sensor::{CameraInfo, CompressedImage};
use crate::interfaces::standard::Header;
use image::{ExtendedColorType, codecs::jpeg::JpegEncoder};
use skein_domain::payload::{CameraPose, FrameHeader, PixelFormat};

/// Quality of a JPEG made here, 1 to 100.
const QUALITY: u8 = 80;

/// The frame as a JPEG; nothing if its header does not fit its bytes.
#[must_use]
pub fn jpeg(of: &FrameHeader, bytes: &[u8]) -> Option<Vec<u8>> {
    let (color, samples) = match of.format {
        PixelFormat::Jpeg => return Some(bytes.to_vec()),
        PixelFormat::H264 => return None,
        PixelFormat::Gray8 => (ExtendedColorType::L8, 1),
        PixelFormat::Rgb8 => (ExtendedColorType::Rgb8, 3),
    };
    let row = (of.width_px as usize).checked_mul(samples)?;
    let stride = (of.stride_bytes as usize).max(row).max(1);
    let rows = bytes.chunks(stride).take(of.height_px as usize);
    let pixels: Vec<u8> = rows
        .flat_map(|line| line.get(..row).unwrap_or_default())
        .copied()
        .collect();
    if pixels.is_empty() || pixels.len() != row.checked_mul(of.height_px as usize)? {
        return None;
    }
    let mut picture = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut picture, QUALITY);
    encoder.encode(&pixels, of.width_px, of.height_px, color).ok()?;
    Some(picture)
}

/// The message for a JPEG.
#[must_use]
pub fn compressed(header: Header, data: Vec<u8>) -> CompressedImage {
    CompressedImage {
        header,
        format: "jpeg".to_owned(),
        data,
    }
}

/// How the camera sees: a pinhole without distortion, from its field of view. All zero, which means uncalibrated, if that is not known.
#[must_use]
pub fn info(header: Header, of: &FrameHeader) -> CameraInfo {
    let mut info = CameraInfo {
        header,
        height: of.height_px,
        width: of.width_px,
        ..CameraInfo::default()
    };
    let view_rad = of.pose.map(|pose| pose.field_of_view_rad);
    let Some(view_rad) = view_rad.filter(|view| *view > 0.0 && *view < std::f64::consts::PI) else {
        return info;
    };
    let (half_width, half_height) = (f64::from(of.width_px) / 2.0, f64::from(of.height_px) / 2.0);
    let focal = half_width / (view_rad / 2.0).tan();
    info.distortion_model = "plumb_bob".to_owned();
    info.d = vec![0.0; 5];
    info.k.0 = [focal, 0.0, half_width, 0.0, focal, half_height, 0.0, 0.0, 1.0];
    info.r.0 = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    info.p.0 = [
        focal,
        0.0,
        half_width,
        0.0,
        0.0,
        focal,
        half_height,
        0.0,
        0.0,
        0.0,
        1.0,
        0.0,
    ];
    info
}

/// Where the camera was: from `map` to its optical frame.
#[must_use]
pub fn transform(header: Header, optical_frame: &str, pose: &CameraPose) -> TransformStamped {
    let at = frames::point(&pose.position);
    TransformStamped {
        header: Header {
            frame_id: frames::MAP.to_owned(),
            ..header
        },
        child_frame_id: optical_frame.to_owned(),
        transform: Transform {
            translation: Vector3 {
                x: at.x,
                y: at.y,
                z: at.z,
            },
            rotation: frames::optical(pose.roll_rad, pose.pitch_rad, pose.yaw_rad),
        },
    }
}

#[cfg(test)]
mod tests;
