//! Pictures in grey, one byte a pixel.

/// A picture in grey, without gaps between its rows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Gray {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<u8>,
}

impl Gray {
    /// Of pixels row by row.
    ///
    /// # Panics
    ///
    /// If there are not as many pixels as that.
    #[must_use]
    pub fn new(width: usize, height: usize, pixels: Vec<u8>) -> Self {
        assert_eq!(pixels.len(), width * height, "as many pixels as the picture has");
        Self { width, height, pixels }
    }

    /// Brightness at a place; outside of the picture that of its nearest pixel.
    pub(crate) fn at(&self, x: i32, y: i32) -> u8 {
        let inside = |at: i32, most: usize| usize::try_from(at.max(0)).unwrap_or(0).min(most.saturating_sub(1));
        self.pixels[inside(y, self.height) * self.width + inside(x, self.width)]
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// One row, from the left.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[must_use]
    pub fn row(&self, y: usize) -> &[u8] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    /// Half as wide and high: the mean of four pixels each.
    pub(crate) fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            let (upper, lower) = (self.row(2 * y), self.row(2 * y + 1));
            for x in 0..width {
                let sum = [upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]];
                pixels.push((sum.iter().map(|pixel| u16::from(*pixel)).sum::<u16>() / 4) as u8);
            }
        }
        Self::new(width, height, pixels)
    }
}
