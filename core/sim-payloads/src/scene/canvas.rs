//! The bytes of a picture.
//!
//! Must never do: write outside of them; what does not fit is left out.

/// Red, green and blue, each 0..=255 but with fractions.
pub(super) type Colour = [f32; 3];

/// Where pixels are put: three bytes each.
pub(super) struct Canvas<'a>(&'a mut [u8]);

impl<'a> Canvas<'a> {
    pub(super) fn new(bytes: &'a mut [u8]) -> Self {
        Self(bytes)
    }

    /// Sets the pixels of one row from its first on; `colour` is asked for each.
    pub(super) fn row(&mut self, row: usize, width: usize, mut colour: impl FnMut(usize) -> Colour) {
        let Some(bytes) = self.0.get_mut(3 * row * width..3 * (row + 1) * width) else {
            return;
        };
        for (column, pixel) in bytes.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *pixel = colour(column).map(|value| value as u8);
        }
    }

    /// Covers a share of a pixel, 0..=1.
    pub(super) fn cover(&mut self, pixel: usize, colour: Colour, share: f32) {
        let Some(bytes) = self.0.get_mut(3 * pixel..3 * pixel + 3) else {
            return;
        };
        for (byte, value) in bytes.iter_mut().zip(colour) {
            let before = f32::from(*byte);
            *byte = (before + (value - before) * share).round() as u8;
        }
    }
}
