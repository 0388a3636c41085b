//! What becomes of a frame: pure, seeded.
//!
//! Must never do: know of sockets or clocks.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// How much later than others a frame comes that is overtaken, in seconds.
const HELD_BACK_S: f64 = 0.05;

/// How one direction between two hosts treats frames.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// Share that is lost, 0..=1.
    pub loss: f64,
    /// Every frame takes so long, in seconds.
    pub delay_s: f64,
    /// And up to so much longer, drawn evenly: frames overtake each other.
    pub jitter_s: f64,
    /// Share that comes twice, the second one up to 50 ms later.
    pub doubled: f64,
    /// Share that is held back by 50 ms, so that those behind it overtake it.
    pub overtaken: f64,
}

/// One direction between two hosts.
#[derive(Debug)]
pub(super) struct Way {
    pub quality: Quality,
    /// Nothing passes.
    pub cut: bool,
    /// Each direction has its own: the fate of one does not depend on what others send.
    rng: ChaCha8Rng,
}

impl Way {
    pub(super) fn new(seed: u64, from: u8, to: u8) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(from) << 8 | u64::from(to));
        Self {
            quality: Quality::default(),
            cut: false,
            rng,
        }
    }

    /// After how many seconds each copy of a frame arrives; none if it is lost.
    pub(super) fn arrivals_s(&mut self) -> impl Iterator<Item = f64> + use<> {
        let Quality {
            loss,
            delay_s,
            jitter_s,
            doubled,
            overtaken,
        } = self.quality;
        let mut share = || self.rng.random_range(0.0..1.0_f64);
        // always as many draws, so that a change of one share does not shift the others
        let (lost, late, held, twice, behind) = (share(), share(), share(), share(), share());
        let first_s = delay_s + late * jitter_s + if held < overtaken { HELD_BACK_S } else { 0.0 };
        let first = (!self.cut && lost >= loss).then_some(first_s);
        let second = first.filter(|_| twice < doubled).map(|s| s + behind * HELD_BACK_S);
        first.into_iter().chain(second)
    }
}
