//! What becomes of a datagram in the air.
//!
//! Must never do: let the fate of one link depend on what is sent over others, but through the airtime they share.

use crate::transport::To;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use skein_domain::{NodeId, NodeTime, PositionNed};
use std::collections::BTreeMap;

/// How the air is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirSettings {
    /// Where half of the datagrams arrive, in metres; infinite for no loss by distance.
    pub range_m: f64,
    /// Path loss exponent: 2 in free space, 3 to 4 near the ground.
    pub path_loss_exponent: f64,
    /// How many decibels less of signal make the odds of arriving e times worse: small for a sharp end of the range.
    pub fade_db: f64,
    /// What all share, in bits per second; infinite for no limit.
    pub bits_per_s: f64,
    /// What each datagram costs beside its bytes: headers and preamble as if they were bytes.
    pub overhead_bytes: usize,
    /// A datagram that would have to wait longer for the air is dropped at its sender, in seconds.
    pub longest_wait_s: f64,
    /// Share of datagrams lost for other reasons.
    pub loss: f64,
    /// Each is later by this, in seconds.
    pub delay_s: f64,
    /// And by up to this, evenly drawn for each, in seconds: so they overtake each other.
    pub jitter_s: f64,
    /// Share that arrives twice.
    pub doubles: f64,
}

impl Default for AirSettings {
    /// A perfect one.
    fn default() -> Self {
        Self {
            range_m: f64::INFINITY,
            path_loss_exponent: 2.5,
            fade_db: 1.5,
            bits_per_s: f64::INFINITY,
            overhead_bytes: 40,
            longest_wait_s: 1.0,
            loss: 0.0,
            delay_s: 0.0,
            jitter_s: 0.0,
            doubles: 0.0,
        }
    }
}

/// One direction of a link that differs from the others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Link {
    /// Nothing arrives.
    pub cut: bool,
    /// Share of datagrams lost beside all other reasons.
    pub loss: f64,
    /// Signal lost beside the distance's, in decibels.
    pub loss_db: f64,
    /// Delay beside the others', in seconds.
    pub delay_s: f64,
}

/// What the air was used for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AirUse {
    /// Datagrams that went into the air.
    pub sent: u64,
    /// Bytes of them, without overhead.
    pub bytes: u64,
    /// Datagrams that would have had to wait too long for the air.
    pub dropped: u64,
    /// Arrivals, doubles included.
    pub arrived: u64,
    /// Receivers that were not reached.
    pub lost: u64,
    /// Airtime in all, in seconds.
    pub airtime_s: f64,
}

#[derive(Debug)]
pub(super) struct RadioChannel {
    pub(super) settings: AirSettings,
    pub(super) links: BTreeMap<(NodeId, NodeId), Link>,
    pub(super) parts: Option<BTreeMap<NodeId, usize>>,
    pub(super) used: AirUse,
    seed: u64,
    places: BTreeMap<NodeId, PositionNed>,
    /// Each direction of a link has chance of its own.
    chance: BTreeMap<(NodeId, NodeId), ChaCha8Rng>,
    free_at: NodeTime,
}

impl RadioChannel {
    pub(super) fn new(settings: AirSettings, seed: u64) -> Self {
        Self {
            settings,
            links: BTreeMap::new(),
            parts: None,
            used: AirUse::default(),
            seed,
            places: BTreeMap::new(),
            chance: BTreeMap::new(),
            free_at: NodeTime::default(),
        }
    }

    pub(super) fn join(&mut self, node: NodeId) {
        self.places.entry(node).or_default();
    }

    pub(super) fn place(&mut self, node: NodeId, at: PositionNed) {
        self.places.insert(node, at);
    }

    /// Sends once; gives who gets it and when.
    pub(super) fn sent(&mut self, now: NodeTime, from: NodeId, to: To, bytes: usize) -> Vec<(NodeId, NodeTime)> {
        let airtime_s = (bytes + self.settings.overhead_bytes) as f64 * 8.0 / self.settings.bits_per_s;
        let start = self.free_at.max(now);
        if start.seconds_since(now) > self.settings.longest_wait_s {
            self.used.dropped += 1;
            return Vec::new();
        }
        let done = start.plus_seconds(airtime_s);
        self.free_at = done;
        self.used.sent += 1;
        self.used.bytes += bytes as u64;
        self.used.airtime_s += airtime_s;
        let receivers: Vec<NodeId> = match to {
            To::One(node) => vec![node],
            To::All => self.places.keys().copied().filter(|node| *node != from).collect(),
        };
        let mut arrivals = Vec::new();
        for node in receivers {
            let times = self.fate(from, node, done);
            self.used.arrived += times.len() as u64;
            self.used.lost += u64::from(times.is_empty());
            arrivals.extend(times.into_iter().map(|at| (node, at)));
        }
        arrivals
    }

    /// When a datagram arrives at one receiver: never, once or twice. It draws the same number of times whatever becomes of it.
    fn fate(&mut self, from: NodeId, to: NodeId, done: NodeTime) -> Vec<NodeTime> {
        let reached = self.reaches(from, to);
        let link = self.links.get(&(from, to)).copied().unwrap_or_default();
        let AirSettings {
            loss,
            delay_s,
            jitter_s,
            doubles,
            ..
        } = self.settings;
        let seed = mix(self.seed, from.0, to.0);
        let chance = self
            .chance
            .entry((from, to))
            .or_insert_with(|| ChaCha8Rng::seed_from_u64(seed));
        let [arrives, lost, lost_here, twice, late, later] = std::array::from_fn(|_| chance.random::<f64>());
        if link.cut || arrives >= reached || lost < loss || lost_here < link.loss {
            return Vec::new();
        }
        let at = |drawn: f64| done.plus_seconds(delay_s + link.delay_s + jitter_s * drawn);
        let mut times = vec![at(late)];
        if twice < doubles {
            times.push(at(later));
        }
        times
    }

    /// The share of datagrams that the distance lets arrive. Log-distance path loss; the odds fall with the signal's margin over that at
    /// the range.
    fn reaches(&self, from: NodeId, to: NodeId) -> f64 {
        let apart = self
            .parts
            .as_ref()
            .is_some_and(|parts| parts.get(&from).is_none() || parts.get(&from) != parts.get(&to));
        if apart {
            return 0.0;
        }
        let place = |node: NodeId| self.places.get(&node).copied().unwrap_or_default();
        let distance_m = place(from).distance_m(&place(to)).max(1.0);
        let extra_db = self.links.get(&(from, to)).map_or(0.0, |link| link.loss_db);
        let margin_db =
            10.0 * self.settings.path_loss_exponent * (self.settings.range_m / distance_m).log10() - extra_db;
        1.0 / (1.0 + (-margin_db / self.settings.fade_db).exp())
    }
}

/// One seed of three numbers (SplitMix64's finisher, Steele et al. 2014).
fn mix(seed: u64, from: u64, to: u64) -> u64 {
    [from, to].into_iter().fold(seed, |seed, value| {
        let mut z = seed.wrapping_add(value).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}
