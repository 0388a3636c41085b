//! How often something may be asked: so many at once, then so many per second.
//!
//! Must never do: read a clock.

/// A bucket of permits that fills by itself.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    most: f64,
    per_s: f64,
    left: f64,
    at_s: f64,
}

impl Limit {
    /// So many at once, and so many per second after that.
    #[must_use]
    pub fn new(most: u32, per_s: f64) -> Self {
        Self {
            most: f64::from(most),
            per_s,
            left: f64::from(most),
            at_s: 0.0,
        }
    }

    /// Whether one more is permitted now, which counts it.
    pub fn permits(&mut self, now_s: f64) -> bool {
        self.left = (self.left + (now_s - self.at_s).max(0.0) * self.per_s).min(self.most);
        self.at_s = self.at_s.max(now_s);
        if self.left < 1.0 {
            return false;
        }
        self.left -= 1.0;
        true
    }
}

#[cfg(test)]
mod tests;
