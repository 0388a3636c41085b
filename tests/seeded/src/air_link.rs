//! One direction of a radio link: delays what is sent and loses a part of it. Simulated time.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Messages on their way.
#[derive(Debug, Clone)]
pub struct AirLink<T> {
    under_way: VecDeque<(f64, T)>,
    latency_s: f64,
    jitter_s: f64,
    loss: f64,
}

impl<T> AirLink<T> {
    /// A link with this shortest delay, further delay drawn up to the jitter, and share of messages lost.
    pub fn new(latency_s: f64, jitter_s: f64, loss: f64) -> Self {
        Self {
            under_way: VecDeque::new(),
            latency_s,
            jitter_s,
            loss,
        }
    }

    /// Sends a message.
    pub fn send(&mut self, now_s: f64, message: T, rng: &mut ChaCha8Rng) {
        if rng.random_range(0.0..1.0) >= self.loss {
            let arrives_s = now_s + self.latency_s + rng.random_range(0.0..=1.0) * self.jitter_s;
            self.under_way.push_back((arrives_s, message));
        }
    }

    /// Everything that has arrived by now, in the order of its arrival.
    pub fn receive(&mut self, now_s: f64) -> Vec<T> {
        let mut arrived = Vec::new();
        let mut left = VecDeque::with_capacity(self.under_way.len());
        for (at_s, message) in self.under_way.drain(..) {
            if at_s <= now_s {
                arrived.push((at_s, message));
            } else {
                left.push_back((at_s, message));
            }
        }
        self.under_way = left;
        arrived.sort_by(|a, b| a.0.total_cmp(&b.0));
        arrived.into_iter().map(|(_, message)| message).collect()
    }

    /// Nothing arrives any more.
    pub fn cut(&mut self) {
        self.under_way.clear();
        self.loss = 1.0;
    }
}
