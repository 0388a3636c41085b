//! How often something was sent of late.
//!
//! Must never do: read a clock.

use skein_domain::NodeTime;

/// Counts how often something was sent, over two seconds.
#[derive(Debug, Default)]
pub struct SendRate {
    second: u64,
    in_second: u32,
    in_last: u32,
}

impl SendRate {
    /// Notes one.
    pub fn on_sent(&mut self, now: NodeTime) {
        self.turn(now);
        self.in_second += 1;
    }

    /// Per second: the last whole second and what there is of the present one.
    pub fn rate_hz(&mut self, now: NodeTime) -> f32 {
        self.turn(now);
        let elapsed_s = now.as_seconds() - self.second as f64;
        ((f64::from(self.in_last) + f64::from(self.in_second)) / (1.0 + elapsed_s)) as f32
    }

    fn turn(&mut self, now: NodeTime) {
        let second = now.as_seconds() as u64;
        if second > self.second {
            self.in_last = if second == self.second + 1 { self.in_second } else { 0 };
            self.in_second = 0;
            self.second = second;
        }
    }
}
