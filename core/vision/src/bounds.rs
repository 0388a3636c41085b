//! Boxes in a picture.

/// A box with upright sides. Pixels count from the picture's left upper corner.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// Middle, in pixels from the left.
    pub center_x_px: f64,
    /// Middle, in pixels from the top.
    pub center_y_px: f64,
    /// Width in pixels.
    pub width_px: f64,
    /// Height in pixels.
    pub height_px: f64,
}

impl Bounds {
    /// Whether it can be one: an area, in or near a picture.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let (least, most) = (0.01, 1e6);
        let is_side = |px: f64| (least..=most).contains(&px);
        self.center_x_px.abs() <= most
            && self.center_y_px.abs() <= most
            && is_side(self.width_px)
            && is_side(self.height_px)
    }

    /// Its area in square pixels.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.width_px * self.height_px
    }

    /// Area that two share over the area that both cover, 0..=1.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> f64 {
        let shared = |center: f64, size: f64, other_center: f64, other_size: f64| {
            let end = (center + size / 2.0).min(other_center + other_size / 2.0);
            (end - (center - size / 2.0).max(other_center - other_size / 2.0)).max(0.0)
        };
        let shared = shared(self.center_x_px, self.width_px, other.center_x_px, other.width_px)
            * shared(self.center_y_px, self.height_px, other.center_y_px, other.height_px);
        let both = self.area() + other.area() - shared;
        if both > 0.0 { shared / both } else { 0.0 }
    }
}
