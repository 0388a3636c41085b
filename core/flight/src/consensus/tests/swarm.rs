//! A swarm of points that follow velocities with a lag, and hear of each other late, seldom and imprecisely.

use crate::consensus::{KeepingTuning, command, keepings};
use nalgebra::Vector3;
use skein_domain::exchange::PeerState;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{FlightLimits, Keeping, KeepingLaw, NodeTime, OffsetFrd, PositionNed, VehicleId, VelocityNed};
use std::collections::VecDeque;

pub const LIMITS: FlightLimits = FlightLimits {
    max_speed_m_s: 10.0,
    max_climb_m_s: 2.0,
    max_descent_m_s: 1.5,
    max_acceleration_m_s2: 3.0,
    min_turn_radius_m: 0.0,
    endurance_s: None,
    keeps_view: false,
};
const SPACING_M: f64 = 6.0;
const PERIOD_S: f64 = 0.02;
/// A message per vehicle every so many periods.
const MESSAGE_PERIODS: u64 = 5;
/// How fast a vehicle takes a velocity up, in seconds.
const LAG_S: f64 = 0.3;

pub fn wedge(count: usize) -> Vec<OffsetFrd> {
    let arm = |i: usize| {
        let step = i.div_ceil(2) as f64 * SPACING_M * std::f64::consts::FRAC_1_SQRT_2;
        OffsetFrd::new(-step, if i.is_multiple_of(2) { -step } else { step }, 0.0)
    };
    (0..count).map(arm).collect()
}

pub fn line(count: usize) -> Vec<OffsetFrd> {
    (0..count)
        .map(|i| OffsetFrd::new(-(i as f64) * SPACING_M, 0.0, 0.0))
        .collect()
}

pub fn grid(count: usize) -> Vec<OffsetFrd> {
    let place = |i: usize| OffsetFrd::new(-((i / 3) as f64) * SPACING_M, (i % 3) as f64 * SPACING_M, 0.0);
    (0..count).map(place).collect()
}

pub fn cube(count: usize) -> Vec<OffsetFrd> {
    let place = |i: usize| {
        let (x, y, z) = ((i % 2) as f64, (i / 2 % 2) as f64, (i / 4) as f64);
        OffsetFrd::new(-x, y, -z).vector() * SPACING_M
    };
    (0..count).map(|i| place(i).into()).collect()
}

/// How vehicles hear of each other.
#[derive(Debug, Clone, Copy)]
pub struct World {
    seed: u64,
    loss: f64,
    late_periods: usize,
    noise_m: f64,
}

impl World {
    pub fn quiet(seed: u64) -> Self {
        Self {
            seed,
            loss: 0.0,
            late_periods: 1,
            noise_m: 0.0,
        }
    }

    /// One in five lost, 200 ms late, 5 % of the spacing of noise.
    pub fn harsh(seed: u64) -> Self {
        Self {
            seed,
            loss: 0.2,
            late_periods: 10,
            noise_m: 0.05 * SPACING_M,
        }
    }

    /// From 0 to 1 (splitmix64).
    fn draw(&mut self) -> f64 {
        self.seed = self.seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// About normal, of variance one.
    fn noise(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| (0..6).map(|_| self.draw() - 0.5).sum::<f64>() * std::f64::consts::SQRT_2)
    }
}

pub struct Swarm {
    keepings: Vec<Option<Keeping>>,
    places: Vec<Vector3<f64>>,
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    /// What everyone knows of everyone: receiver, then sender.
    known: Vec<Vec<Option<PeerState>>>,
    on_the_way: VecDeque<Vec<(usize, usize, PeerState)>>,
    silent: Vec<bool>,
    world: World,
    ticks: u64,
    /// The largest error of the shape and the smallest distance so far.
    pub worst_m: f64,
    pub nearest_m: f64,
}

impl Swarm {
    pub fn new(slots: &[OffsetFrd], law: KeepingLaw, world: World) -> Self {
        let count = slots.len();
        let members: Vec<_> = slots
            .iter()
            .enumerate()
            .map(|(i, slot)| (VehicleId(i as u16 + 1), *slot))
            .collect();
        let mut own = vec![None; count];
        for (id, keeping) in keepings(&members, Some(VehicleId(1)), 0.0, law, NodeTime(0)) {
            own[id.0 as usize - 1] = Some(keeping);
        }
        let places: Vec<_> = slots.iter().map(|slot| slot.vector()).collect();
        Self {
            keepings: own,
            positions: places.clone(),
            places,
            velocities: vec![Vector3::zeros(); count],
            known: vec![vec![None; count]; count],
            on_the_way: VecDeque::new(),
            silent: vec![false; count],
            world,
            ticks: 0,
            worst_m: 0.0,
            nearest_m: f64::INFINITY,
        }
    }

    /// Everyone but the leader somewhere else, by up to so much per axis.
    pub fn perturb(&mut self, by_m: f64) {
        for i in 1..self.positions.len() {
            self.positions[i] += Vector3::from_fn(|_, _| (self.world.draw() * 2.0 - 1.0) * by_m);
        }
    }

    /// Nothing more is heard of it, and it falls away.
    pub fn silence(&mut self, i: usize) {
        self.silent[i] = true;
    }

    fn now(&self) -> NodeTime {
        NodeTime::from_seconds(10.0 + self.ticks as f64 * PERIOD_S)
    }

    pub fn run(&mut self, seconds: f64, leader: impl Fn(f64) -> VelocityNed) {
        for _ in 0..(seconds / PERIOD_S) as u64 {
            self.tick(leader(self.ticks as f64 * PERIOD_S));
        }
    }

    fn tick(&mut self, leader: VelocityNed) {
        self.ticks += 1;
        let now = self.now();
        self.exchange(now);
        let wanted: Vec<Vector3<f64>> = (0..self.positions.len())
            .map(|i| {
                let Some(keeping) = &self.keepings[i] else {
                    return leader.vector();
                };
                let peers: Vec<PeerState> = self.known[i].iter().flatten().copied().collect();
                let here = PositionNed::from(self.positions[i]);
                command(keeping, &here, &peers, now, &LIMITS, &KeepingTuning::default())
                    .velocity
                    .vector()
            })
            .collect();
        for (i, wanted) in wanted.into_iter().enumerate() {
            if self.silent[i] {
                continue;
            }
            let change = ((wanted - self.velocities[i]) / LAG_S).cap_magnitude(LIMITS.max_acceleration_m_s2);
            self.velocities[i] += change * PERIOD_S;
            self.positions[i] += self.velocities[i] * PERIOD_S;
        }
        self.worst_m = self.worst_m.max(self.shape_error_m());
        self.nearest_m = self.nearest_m.min(self.nearest());
    }

    fn exchange(&mut self, now: NodeTime) {
        let mut sent = Vec::new();
        for from in 0..self.positions.len() {
            if self.silent[from] || !(self.ticks + from as u64).is_multiple_of(MESSAGE_PERIODS) {
                continue;
            }
            let noise = self.world.noise() * self.world.noise_m;
            let state = PeerState {
                id: VehicleId(from as u16 + 1),
                kinematics: VehicleKinematics {
                    position: (self.positions[from] + noise).into(),
                    velocity: self.velocities[from].into(),
                    yaw_rad: 0.0,
                    measured: now,
                },
                airborne: true,
            };
            for to in 0..self.positions.len() {
                if self.world.draw() >= self.world.loss {
                    sent.push((from, to, state));
                }
            }
        }
        self.on_the_way.push_back(sent);
        if self.on_the_way.len() > self.world.late_periods {
            for (from, to, state) in self.on_the_way.pop_front().into_iter().flatten() {
                self.known[to][from] = Some(state);
            }
        }
    }

    fn heard(&self) -> Vec<usize> {
        (0..self.positions.len()).filter(|i| !self.silent[*i]).collect()
    }

    fn nearest(&self) -> f64 {
        let heard = self.heard();
        let pairs = heard
            .iter()
            .flat_map(|i| heard.iter().filter(move |j| *j < i).map(move |j| (*i, *j)));
        pairs
            .map(|(i, j)| (self.positions[i] - self.positions[j]).norm())
            .fold(f64::INFINITY, f64::min)
    }

    /// The mean over all vehicles that are heard of how far they are from their places in the shape, moved and turned about the vertical
    /// as it fits best.
    pub fn shape_error_m(&self) -> f64 {
        let heard = self.heard();
        let mean = |of: &[Vector3<f64>]| heard.iter().map(|i| of[*i]).sum::<Vector3<f64>>() / heard.len() as f64;
        let (here, there) = (mean(&self.positions), mean(&self.places));
        let (mut along, mut across) = (0.0, 0.0);
        for i in &heard {
            let (p, q) = (self.positions[*i] - here, self.places[*i] - there);
            along += q.x * p.x + q.y * p.y;
            across += q.x * p.y - q.y * p.x;
        }
        let (sin, cos) = across.atan2(along).sin_cos();
        let off = |i: &usize| {
            let (p, q) = (self.positions[*i] - here, self.places[*i] - there);
            (p - Vector3::new(q.x * cos - q.y * sin, q.x * sin + q.y * cos, q.z)).norm()
        };
        heard.iter().map(off).sum::<f64>() / heard.len() as f64
    }

    pub fn slowest_m_s(&self) -> f64 {
        self.velocities.iter().map(|v| v.norm()).fold(f64::INFINITY, f64::min)
    }

    pub fn fastest_follower_m_s(&self) -> f64 {
        self.velocities.iter().skip(1).map(|v| v.norm()).fold(0.0, f64::max)
    }
}
