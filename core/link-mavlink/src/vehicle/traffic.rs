//! Who was heard when: link loss and regain, the share of frames lost, and rates, over the last seconds.
//!
//! PX4 counts the frames of one channel, those of all components together; other components behind the same system id (a gimbal,
//! a camera) count on their own, and their counts pass through the autopilot's again and again. So a component's frame takes part
//! only once its component has been seen to continue the autopilot's count and not one of its own.

use super::AUTOPILOT_COMPONENT;
use skein_domain::NodeTime;

/// Length of one slice of the window in seconds.
const SLICE_S: f64 = 0.5;
/// Slices in the window: five seconds.
const SLICES: usize = 10;
/// A count that seems to go back by less than this is a frame that was overtaken, not a gap.
const REORDERED_MAX: u8 = 64;
/// A component's frame that continues the count within so many steps may share it.
const SHARED_MAX: u8 = 32;
/// How sure it can be whether a component shares the count: so many frames turn it.
const SURE: i8 = 8;

#[derive(Debug, Clone, Copy, Default)]
struct Slice {
    received: u32,
    lost: i32,
}

/// A component other than the autopilot, and whose count it is seen to continue.
#[derive(Debug)]
struct Component {
    id: u8,
    last: u8,
    /// Frames of the autopilot since the last one of this component: without any both counts look the same.
    autopilot_between: bool,
    /// Above zero it shares the autopilot's count; how far above or below, how sure that is.
    shares: i8,
}

impl Component {
    /// Whether this frame of it continues the count whose last is `common`.
    fn shares(&mut self, sequence: u8, common: Option<u8>) -> bool {
        let own = sequence.wrapping_sub(self.last);
        let follows = common.is_some_and(|common| (1..=SHARED_MAX).contains(&sequence.wrapping_sub(common)));
        if self.autopilot_between {
            // One that shares cannot be the next of its own as well; one that does not may follow by chance.
            let vote = if own != 1 && follows { 1 } else { -2 };
            self.shares = self.shares.saturating_add(vote).clamp(-SURE, SURE);
        }
        self.last = sequence;
        self.autopilot_between = false;
        self.shares > 0 && follows
    }
}

/// Counts the frames of one vehicle.
#[derive(Debug, Default)]
pub struct Traffic {
    slices: [Slice; SLICES],
    /// Number of the present slice since the node started.
    slice: u64,
    first: Option<NodeTime>,
    sequence: Option<u8>,
    components: Vec<Component>,
}

impl Traffic {
    /// Notes a frame of the component `component`.
    pub fn on_frame(&mut self, now: NodeTime, component: u8, sequence: u8) {
        self.turn(now);
        self.first.get_or_insert(now);
        if !self.takes_part(component, sequence) {
            return;
        }
        let lost = match self.sequence.map(|last| sequence.wrapping_sub(last)) {
            None | Some(0) => 0,
            // It was counted as lost when it was overtaken.
            Some(ahead) if ahead > u8::MAX - REORDERED_MAX => -1,
            Some(ahead) => i32::from(ahead) - 1,
        };
        if lost >= 0 {
            self.sequence = Some(sequence);
        }
        let slice = &mut self.slices[self.slice as usize % SLICES];
        slice.received += 1;
        slice.lost += lost;
    }

    fn takes_part(&mut self, component: u8, sequence: u8) -> bool {
        if component == AUTOPILOT_COMPONENT {
            self.components.iter_mut().for_each(|c| c.autopilot_between = true);
            return true;
        }
        if let Some(known) = self.components.iter_mut().find(|c| c.id == component) {
            return known.shares(sequence, self.sequence);
        }
        self.components.push(Component {
            id: component,
            last: sequence,
            autopilot_between: false,
            shares: 0,
        });
        false
    }

    /// Starts the count anew: the autopilot restarted or was lost.
    pub fn restart(&mut self) {
        self.sequence = None;
        self.components.clear();
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

#[cfg(test)]
mod tests {
    //! Loss over wrap, reordering, foreign counters and outages.

    use super::*;
    use proptest::prelude::*;

    const GIMBAL: u8 = 154;
    const CAMERA: u8 = 100;

    fn at(i: u32) -> NodeTime {
        NodeTime::from_seconds(1.0 + f64::from(i) * 0.01)
    }

    #[test]
    fn a_whole_stream_loses_nothing_and_has_its_rate() {
        let mut traffic = Traffic::default();
        for i in 0..1000 {
            traffic.on_frame(at(i), AUTOPILOT_COMPONENT, i as u8);
        }
        assert_eq!(traffic.loss(at(1000)), 0.0);
        let rate = traffic.rate_hz(at(1000));
        assert!((rate - 100.0).abs() < 3.0, "{rate}");
    }

    #[test]
    fn a_quarter_lost_is_a_quarter() {
        let mut traffic = Traffic::default();
        for i in (0..1000).filter(|i| i % 4 != 3) {
            traffic.on_frame(at(i), AUTOPILOT_COMPONENT, i as u8);
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
            traffic.on_frame(at(i), AUTOPILOT_COMPONENT, (i * 2) as u8);
            traffic.on_frame(at(i), GIMBAL, (i * 2 + 1) as u8);
        }
        assert_eq!(traffic.loss(at(1000)), 0.0, "shared");
        let mut traffic = Traffic::default();
        for i in 0..1000_u32 {
            traffic.on_frame(at(i), AUTOPILOT_COMPONENT, i as u8);
            traffic.on_frame(at(i), GIMBAL, (i as u8).wrapping_add(128));
        }
        assert_eq!(traffic.loss(at(1000)), 0.0, "own");
    }

    /// 50 frames a second of the autopilot, and others in between with their own rates: `shared` takes the next number for all.
    fn beside(rates_hz: [u32; 2], shared: bool, mut arrives: impl FnMut() -> bool) -> f32 {
        let (mut traffic, mut common, mut own) = (Traffic::default(), 0_u8, [200_u8, 90]);
        let mut largest: f32 = 0.0;
        for i in 0..6000_u32 {
            let mut send = |component: u8, count: &mut u8| {
                *count = count.wrapping_add(1);
                if arrives() {
                    traffic.on_frame(at(i), component, *count);
                }
            };
            if i % 2 == 0 {
                send(AUTOPILOT_COMPONENT, &mut common);
            }
            for (k, component) in [GIMBAL, CAMERA].into_iter().enumerate() {
                if i * rates_hz[k] / 100 != (i + 1) * rates_hz[k] / 100 {
                    send(component, if shared { &mut common } else { &mut own[k] });
                }
            }
            if i > 1000 {
                largest = largest.max(traffic.loss(at(i)));
            }
        }
        largest
    }

    proptest! {
        #[test]
        fn whoever_counts_on_its_own_is_never_taken_for_loss(gimbal_hz in 1_u32..100, camera_hz in 1_u32..100) {
            prop_assert_eq!(beside([gimbal_hz, camera_hz], false, || true), 0.0);
        }

        #[test]
        fn whoever_shares_the_count_is_no_gap_in_it(gimbal_hz in 1_u32..100, camera_hz in 1_u32..100) {
            prop_assert_eq!(beside([gimbal_hz, camera_hz], true, || true), 0.0);
        }

        /// One of ten is lost; the share over five seconds stays near that, whoever counts how.
        #[test]
        fn a_tenth_lost_stays_a_tenth(gimbal_hz in 1_u32..100, camera_hz in 1_u32..100, shared in any::<bool>(), seed in any::<u64>()) {
            let mut state = seed | 1;
            let loss = beside([gimbal_hz, camera_hz], shared, || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) % 10 != 0
            });
            prop_assert!((0.05..0.25).contains(&loss), "{}", loss);
        }

        #[test]
        fn swapping_neighbours_loses_nothing(swaps in prop::collection::vec(any::<bool>(), 300)) {
            let mut order: Vec<u32> = (0..600).collect();
            for (i, swap) in swaps.iter().enumerate() {
                if *swap { order.swap(i * 2, i * 2 + 1); }
            }
            let mut traffic = Traffic::default();
            for &i in &order {
                traffic.on_frame(at(300), AUTOPILOT_COMPONENT, i as u8);
            }
            let lost: i32 = traffic.slices.iter().map(|slice| slice.lost).sum();
            // The very first may be the one that was overtaken: before it there is nothing to be counted as lost.
            prop_assert!((-1..=0).contains(&lost), "{lost}");
        }
    }
}
