//! Who was heard when: link loss and regain, the share of frames lost, and rates, over the last seconds.
//!
//! PX4 counts the frames of one channel, those of all components together; other components behind the same system id may
//! count on their own. So a component's frame takes part only if it continues the autopilot's count.

use skein_domain::NodeTime;

/// Length of one slice of the window in seconds.
const SLICE_S: f64 = 0.5;
/// Slices in the window: five seconds.
const SLICES: usize = 10;
/// A count that seems to go back by less than this is a frame that was overtaken, not a gap.
const REORDERED_MAX: u8 = 64;
/// A component's frame that continues the count within so many steps shares it.
const SHARED_MAX: u8 = 32;

#[derive(Debug, Clone, Copy, Default)]
struct Slice {
    received: u32,
    lost: i32,
}

/// Counts the frames of one vehicle.
#[derive(Debug, Default)]
pub struct Traffic {
    slices: [Slice; SLICES],
    /// Number of the present slice since the node started.
    slice: u64,
    first: Option<NodeTime>,
    sequence: Option<u8>,
}

impl Traffic {
    /// Notes a frame.
    pub fn on_frame(&mut self, now: NodeTime, autopilot: bool, sequence: u8) {
        self.turn(now);
        self.first.get_or_insert(now);
        let lost = match self.sequence {
            None => 0,
            Some(last) => {
                let ahead = sequence.wrapping_sub(last);
                if !autopilot && !(1..=SHARED_MAX).contains(&ahead) {
                    // Counts on its own.
                    return;
                }
                match ahead {
                    0 => 0,
                    // It was counted as lost when it was overtaken.
                    ahead if ahead > u8::MAX - REORDERED_MAX => -1,
                    ahead => i32::from(ahead) - 1,
                }
            }
        };
        if lost >= 0 && (autopilot || self.sequence.is_some()) {
            self.sequence = Some(sequence);
        }
        let slice = &mut self.slices[self.slice as usize % SLICES];
        slice.received += 1;
        slice.lost += lost;
    }

    /// Starts the count anew: the autopilot restarted or was lost.
    pub fn restart(&mut self) {
        self.sequence = None;
        self.slices = [Slice::default(); SLICES];
        self.first = None;
    }

    /// Share of frames lost over the window, 0..=1.
    pub fn loss(&mut self, now: NodeTime) -> f32 {
        self.turn(now);
        let lost: i32 = self.slices.iter().map(|slice| slice.lost).sum();
        let received: u32 = self.slices.iter().map(|slice| slice.received).sum();
        let lost = lost.max(0) as f32;
        if received == 0 {
            0.0
        } else {
            lost / (lost + received as f32)
        }
    }

    /// Frames per second over the window.
    pub fn rate_hz(&mut self, now: NodeTime) -> f32 {
        self.turn(now);
        let received: u32 = self.slices.iter().map(|slice| slice.received).sum();
        let in_slice_s = now.as_seconds() - self.slice as f64 * SLICE_S;
        let window_s = (SLICES - 1) as f64 * SLICE_S + in_slice_s;
        let heard_s = self.first.map_or(0.0, |first| now.seconds_since(first));
        (f64::from(received) / window_s.min(heard_s.max(SLICE_S))) as f32
    }

    fn turn(&mut self, now: NodeTime) {
        let slice = (now.as_seconds() / SLICE_S) as u64;
        if slice <= self.slice {
            return;
        }
        for number in (self.slice + 1..=slice).rev().take(SLICES) {
            self.slices[number as usize % SLICES] = Slice::default();
        }
        self.slice = slice;
    }
}

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

#[cfg(test)]
mod tests {
    //! Loss over wrap, reordering, foreign counters and outages.

    use super::*;
    use proptest::prelude::*;

    fn at(i: u32) -> NodeTime {
        NodeTime::from_seconds(1.0 + f64::from(i) * 0.01)
    }

    #[test]
    fn a_whole_stream_loses_nothing_and_has_its_rate() {
        let mut traffic = Traffic::default();
        for i in 0..1000 {
            traffic.on_frame(at(i), true, i as u8);
        }
        assert_eq!(traffic.loss(at(1000)), 0.0);
        let rate = traffic.rate_hz(at(1000));
        assert!((rate - 100.0).abs() < 3.0, "{rate}");
    }

    #[test]
    fn a_quarter_lost_is_a_quarter() {
        let mut traffic = Traffic::default();
        for i in (0..1000).filter(|i| i % 4 != 3) {
            traffic.on_frame(at(i), true, i as u8);
        }
        assert!((traffic.loss(at(1000)) - 0.25).abs() < 0.01);
        assert_eq!(
            traffic.loss(NodeTime::from_seconds(100.0)),
            0.0,
            "the window has moved on"
        );
    }

    #[test]
    fn a_component_with_its_own_count_does_not_disturb_and_one_that_shares_it_is_counted() {
        let mut traffic = Traffic::default();
        for i in 0..1000_u32 {
            traffic.on_frame(at(i), true, (i * 2) as u8);
            traffic.on_frame(at(i), false, (i * 2 + 1) as u8);
        }
        assert_eq!(traffic.loss(at(1000)), 0.0, "shared");
        let mut traffic = Traffic::default();
        for i in 0..1000_u32 {
            traffic.on_frame(at(i), true, i as u8);
            traffic.on_frame(at(i), false, (i as u8).wrapping_add(128));
        }
        assert_eq!(traffic.loss(at(1000)), 0.0, "own");
    }

    proptest! {
        #[test]
        fn swapping_neighbours_loses_nothing(swaps in prop::collection::vec(any::<bool>(), 300)) {
            let mut order: Vec<u32> = (0..600).collect();
            for (i, swap) in swaps.iter().enumerate() {
                if *swap { order.swap(i * 2, i * 2 + 1); }
            }
            let mut traffic = Traffic::default();
            for &i in &order {
                traffic.on_frame(at(300), true, i as u8);
            }
            let lost: i32 = traffic.slices.iter().map(|slice| slice.lost).sum();
            // The very first may be the one that was overtaken: before it there is nothing to be counted as lost.
            prop_assert!((-1..=0).contains(&lost), "{lost}");
        }
    }
}
