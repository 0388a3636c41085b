//! Frames as pictures that a browser shows.

use skein_domain::payload::{FrameHeader, PixelFormat};

/// The frame as a JPEG if it is one, else as a PNG. Empty if the header does not fit the bytes.
pub(crate) fn encode(header: &FrameHeader, bytes: &[u8]) -> Vec<u8> {
    let color = match header.format {
        PixelFormat::Jpeg => return bytes.to_vec(),
        PixelFormat::H264 => return Vec::new(),
        PixelFormat::Gray8 => png::ColorType::Grayscale,
        PixelFormat::Rgb8 => png::ColorType::Rgb,
    };
    let row = header.width_px as usize * color.samples();
    let stride = (header.stride_bytes as usize).max(row);
    let rows = bytes.chunks(stride.max(1)).take(header.height_px as usize);
    let pixels: Vec<u8> = rows
        .flat_map(|line| line.get(..row).unwrap_or_default())
        .copied()
        .collect();
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, header.width_px, header.height_px);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&pixels).and_then(|()| writer.finish()));
    match written {
        Ok(()) => picture,
        Err(error) => {
            tracing::debug!("a frame could not be made a picture: {error}");
            Vec::new()
        }
    }
}

#[cfg(test)]
mod tests;
