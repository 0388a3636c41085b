//! Pixels as a JPEG file.

use crate::planes::Planes;
use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, SamplingFactor};
use thiserror::Error;

/// Why there is no file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("no JPEG of it: {0}")]
pub struct JpegError(String);

/// A JPEG file of these pixels.
///
/// # Errors
///
/// The encoder does not take them.
pub fn jpeg(planes: &Planes, quality: u8) -> Result<Vec<u8>, JpegError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, quality.clamp(1, 100));
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    let encoded = encoder.encode_image(WholeRange(planes));
    encoded.map_err(|error| JpegError(error.to_string()))?;
    Ok(file)
}

/// JPEG has brightness from 0 to 255, where video has it from 16 to 235.
struct WholeRange<'a>(&'a Planes);

impl ImageBuffer for WholeRange<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        u16::try_from(self.0.size_px().0).unwrap_or(u16::MAX)
    }

    fn height(&self) -> u16 {
        u16::try_from(self.0.size_px().1).unwrap_or(u16::MAX)
    }

    fn fill_buffers(&self, row: u16, buffers: &mut [Vec<u8>; 4]) {
        let (y, u, v) = self.0.rows(usize::from(row));
        let [brightness, blue, red, _] = buffers;
        brightness.extend(y.iter().map(|value| stretched(*value, 16, 219)));
        let twice = |plane: &[u8], into: &mut Vec<u8>| {
            for value in plane {
                let value = colour(*value);
                into.extend([value, value]);
            }
        };
        twice(u, blue);
        twice(v, red);
    }
}

fn stretched(value: u8, lowest: i32, range: i32) -> u8 {
    ((i32::from(value) - lowest) * 255 / range).clamp(0, 255) as u8
}

fn colour(value: u8) -> u8 {
    ((i32::from(value) - 128) * 255 / 224 + 128).clamp(0, 255) as u8
}

#[cfg(test)]
mod tests;
