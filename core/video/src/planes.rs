//! Pixels as encoders take them: brightness and two colour differences at half the size (I420, BT.601, 16 to 235).

use image::{ImageError, ImageFormat, ImageReader, Limits};
use openh264::formats::{RGB8Source, RGBSource, YUVBuffer, YUVSource};
use skein_domain::payload::{FrameHeader, PixelFormat};
use std::io::Cursor;
use thiserror::Error;

/// No side is longer, in pixels: the encoder's limit.
const LONGEST_SIDE_PX: usize = 3840;
const GREY: u8 = 128;

/// Why there are no pixels.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanesError {
    /// The picture is too small or too large.
    #[error("{width_px} x {height_px} pixels: 2 to {LONGEST_SIDE_PX} a side can be encoded")]
    Size {
        /// Its width in pixels.
        width_px: usize,
        /// Its height in pixels.
        height_px: usize,
    },
    /// The bytes are fewer than the header says.
    #[error("the bytes are fewer than the header says")]
    TooShort,
    /// It is no picture of pixels.
    #[error("it is encoded already")]
    Encoded,
    /// A JPEG that cannot be read.
    #[error("a damaged JPEG: {0}")]
    Damaged(String),
}

/// Pixels. Sides are even: an odd row or column at the edge is left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planes {
    width: usize,
    height: usize,
    y: Vec<u8>,
    u: Vec<u8>,
    v: Vec<u8>,
}

impl Planes {
    /// Of a camera's frame.
    ///
    /// # Errors
    ///
    /// Its size cannot be encoded, its bytes are too few, or it has no pixels.
    pub fn of_frame(header: &FrameHeader, bytes: &[u8]) -> Result<Self, PlanesError> {
        let per_pixel = match header.format {
            PixelFormat::Gray8 => 1,
            PixelFormat::Rgb8 => 3,
            PixelFormat::Jpeg => return Self::of_jpeg(bytes),
            PixelFormat::H264 => return Err(PlanesError::Encoded),
        };
        let (width, height) = even(header.width_px as usize, header.height_px as usize)?;
        let stride = (header.stride_bytes as usize).max(header.width_px as usize * per_pixel);
        let rows: Vec<&[u8]> = bytes
            .chunks(stride)
            .take(height)
            .filter_map(|row| row.get(..width * per_pixel))
            .collect();
        if rows.len() < height {
            return Err(PlanesError::TooShort);
        }
        let packed = rows.concat();
        if per_pixel == 1 {
            let half = vec![GREY; width * height / 4];
            // From the whole range of a byte to that of video.
            let y = packed.iter().map(|grey| 16 + (u16::from(*grey) * 219 / 255) as u8);
            return Ok(Self {
                width,
                height,
                y: y.collect(),
                u: half.clone(),
                v: half,
            });
        }
        Self::of_rgb(&packed, (width, height))
    }

    fn of_jpeg(bytes: &[u8]) -> Result<Self, PlanesError> {
        let damaged = |error: ImageError| PlanesError::Damaged(error.to_string());
        let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Jpeg);
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) =
            (Some(LONGEST_SIDE_PX as u32), Some(LONGEST_SIDE_PX as u32));
        reader.limits(limits);
        let picture = reader.decode().map_err(damaged)?.into_rgb8();
        let (width, height) = even(picture.width() as usize, picture.height() as usize)?;
        let rows = picture.as_raw().chunks(picture.width() as usize * 3).take(height);
        let packed: Vec<u8> = rows
            .flat_map(|row| row.get(..width * 3).unwrap_or_default())
            .copied()
            .collect();
        Self::of_rgb(&packed, (width, height))
    }

    fn of_rgb(packed: &[u8], size: (usize, usize)) -> Result<Self, PlanesError> {
        let mut buffer = YUVBuffer::new(size.0, size.1);
        buffer.read_rgb8(Packed { rgb: packed, size });
        Self::of_yuv(&buffer)
    }

    /// Of pixels as the decoder has them.
    ///
    /// # Errors
    ///
    /// Their size cannot be encoded.
    pub(crate) fn of_yuv(source: &impl YUVSource) -> Result<Self, PlanesError> {
        let (wide, high) = source.dimensions();
        let (width, height) = even(wide, high)?;
        let (y_stride, u_stride, v_stride) = source.strides();
        Ok(Self {
            width,
            height,
            y: plane(source.y(), y_stride, width, height),
            u: plane(source.u(), u_stride, width / 2, height / 2),
            v: plane(source.v(), v_stride, width / 2, height / 2),
        })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size_px(&self) -> (u32, u32) {
        (
            u32::try_from(self.width).unwrap_or(0),
            u32::try_from(self.height).unwrap_or(0),
        )
    }

    /// Made smaller to fit into a size, with the same shape; as it is if it fits already.
    #[must_use]
    pub fn fitted(&self, most_width_px: u32, most_height_px: u32) -> Self {
        let (most_width, most_height) = (most_width_px as usize, most_height_px as usize);
        if self.width <= most_width && self.height <= most_height {
            return self.clone();
        }
        let by_width = most_width as f64 / self.width as f64;
        let scale = by_width.min(most_height as f64 / self.height as f64);
        let side = |length: usize| (((length as f64 * scale) as usize) & !1).max(2);
        let (width, height) = (side(self.width), side(self.height));
        let (from, to) = ((self.width, self.height), (width, height));
        let halves = |(width, height): (usize, usize)| (width / 2, height / 2);
        Self {
            width,
            height,
            y: smaller(&self.y, from, to),
            u: smaller(&self.u, halves(from), halves(to)),
            v: smaller(&self.v, halves(from), halves(to)),
        }
    }

    pub(crate) fn rows(&self, row: usize) -> (&[u8], &[u8], &[u8]) {
        let of = |plane: &'_ [u8], row: usize, width: usize| row * width..((row + 1) * width).min(plane.len());
        let half = self.width / 2;
        (
            self.y.get(of(&self.y, row, self.width)).unwrap_or_default(),
            self.u.get(of(&self.u, row / 2, half)).unwrap_or_default(),
            self.v.get(of(&self.v, row / 2, half)).unwrap_or_default(),
        )
    }
}

impl YUVSource for Planes {
    fn dimensions(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    fn strides(&self) -> (usize, usize, usize) {
        (self.width, self.width / 2, self.width / 2)
    }

    fn y(&self) -> &[u8] {
        &self.y
    }

    fn u(&self) -> &[u8] {
        &self.u
    }

    fn v(&self) -> &[u8] {
        &self.v
    }
}

struct Packed<'a> {
    rgb: &'a [u8],
    size: (usize, usize),
}

impl RGBSource for Packed<'_> {
    fn dimensions(&self) -> (usize, usize) {
        self.size
    }

    fn pixel_f32(&self, x: usize, y: usize) -> (f32, f32, f32) {
        let at = (y * self.size.0 + x) * 3;
        let value = |offset: usize| self.rgb.get(at + offset).copied().map_or(0.0, f32::from);
        (value(0), value(1), value(2))
    }
}

impl RGB8Source for Packed<'_> {
    fn dimensions_padded(&self) -> (usize, usize) {
        self.size
    }

    fn rgb8_data(&self) -> &[u8] {
        self.rgb
    }
}

fn even(width_px: usize, height_px: usize) -> Result<(usize, usize), PlanesError> {
    let sides = 2..=LONGEST_SIDE_PX;
    if !sides.contains(&width_px) || !sides.contains(&height_px) {
        return Err(PlanesError::Size { width_px, height_px });
    }
    Ok((width_px & !1, height_px & !1))
}

fn plane(bytes: &[u8], stride: usize, width: usize, height: usize) -> Vec<u8> {
    let mut packed: Vec<u8> = Vec::with_capacity(width * height);
    for row in bytes.chunks(stride.max(1)).take(height) {
        packed.extend(row.get(..width).unwrap_or_default());
    }
    packed.resize(width * height, GREY);
    packed
}

/// The mean of what falls on each point.
fn smaller(plane: &[u8], (from_width, from_height): (usize, usize), (width, height): (usize, usize)) -> Vec<u8> {
    let span = |index: usize, of: usize, from: usize| {
        let begin = index * from / of;
        begin..((index + 1) * from / of).max(begin + 1).min(from)
    };
    let mut out = Vec::with_capacity(width * height);
    for row in 0..height {
        let rows = span(row, height, from_height);
        for column in 0..width {
            let columns = span(column, width, from_width);
            let (mut sum, mut count) = (0_u32, 0_u32);
            for source in rows.clone() {
                let line = source * from_width;
                for value in plane.get(line + columns.start..line + columns.end).unwrap_or_default() {
                    sum += u32::from(*value);
                    count += 1;
                }
            }
            out.push((sum / count.max(1)) as u8);
        }
    }
    out
}

#[cfg(test)]
mod tests;
