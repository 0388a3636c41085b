//! Pictures as cameras give them, read without caring how their pixels lie.
//!
//! Must never do: trust a header. What does not fit its bytes is no picture.

use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_vision::Gray;

/// More pixels than this are not looked at.
const MOST_PIXELS: u64 = 1 << 25;

/// A picture in colour.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Picture {
    /// Width in pixels.
    pub(crate) width: usize,
    /// Height in pixels.
    pub(crate) height: usize,
    /// Red, green and blue of each pixel, without gaps between rows.
    pub(crate) rgb: Vec<u8>,
}

impl Picture {
    /// Reads a frame; `None` if it is none that can be read.
    pub(crate) fn read(header: &FrameHeader, bytes: &[u8]) -> Option<Self> {
        let pixels = u64::from(header.width_px) * u64::from(header.height_px);
        if pixels == 0 || pixels > MOST_PIXELS {
            return None;
        }
        let (width, height) = (header.width_px as usize, header.height_px as usize);
        let stride = header.stride_bytes as usize;
        let rgb = match header.format {
            PixelFormat::Rgb8 => rows(bytes, 3 * width, stride, height)?.flatten().copied().collect(),
            PixelFormat::Gray8 => rows(bytes, width, stride, height)?
                .flatten()
                .flat_map(|gray| [*gray; 3])
                .collect(),
            PixelFormat::Jpeg => return Self::decode(bytes),
            PixelFormat::H264 => return None,
        };
        Some(Self { width, height, rgb })
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), image::ImageFormat::Jpeg);
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(4 * MOST_PIXELS);
        reader.limits(limits);
        let rgb = reader.decode().ok()?.into_rgb8();
        Some(Self {
            width: rgb.width() as usize,
            height: rgb.height() as usize,
            rgb: rgb.into_raw(),
        })
    }

    pub(crate) fn gray(&self) -> Gray {
        // Weights of ITU-R BT.601, of 256.
        let gray = |rgb: &[u8]| (77 * u32::from(rgb[0]) + 150 * u32::from(rgb[1]) + 29 * u32::from(rgb[2]) + 128) >> 8;
        let pixels = self.rgb.chunks_exact(3).map(|rgb| gray(rgb) as u8);
        Gray::new(self.width, self.height, pixels.collect())
    }
}

/// The rows of a picture; `None` if there are not bytes enough for them.
fn rows(bytes: &[u8], row_bytes: usize, stride: usize, height: usize) -> Option<impl Iterator<Item = &[u8]>> {
    let stride = if stride == 0 { row_bytes } else { stride };
    let needed = stride.checked_mul(height - 1)?.checked_add(row_bytes)?;
    let fits = stride >= row_bytes && bytes.len() >= needed;
    fits.then(|| bytes.chunks(stride).take(height).map(move |row| &row[..row_bytes]))
}
