//! Who starts where and wants to go where: the encounters that filters of this kind are known to fail in, and random ones.

use super::plant::{Kind, Silent};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::TAU;

pub type Start = (Vector3<f64>, Vector3<f64>, Kind);

pub fn ours(from: Vector3<f64>, goal: Vector3<f64>) -> Start {
    (from, Vector3::zeros(), Kind::Ours { goal })
}

/// Places at least `apart_m` from each other in a box of that density.
fn places(rng: &mut ChaCha8Rng, count: usize, apart_m: f64) -> Vec<Vector3<f64>> {
    let side = apart_m * 2.0 * (count as f64).sqrt().max(2.0);
    let mut chosen: Vec<Vector3<f64>> = Vec::new();
    while chosen.len() < count {
        let place = Vector3::new(
            rng.random_range(0.0..side),
            rng.random_range(0.0..side),
            rng.random_range(-12.0..0.0),
        );
        if chosen.iter().all(|other| (other - place).norm() >= apart_m) {
            chosen.push(place);
        }
    }
    chosen
}

/// Anywhere to anywhere.
pub fn random(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA1);
    let from = places(&mut rng, count, 5.0);
    let to = places(&mut rng, count, 5.0);
    from.into_iter().zip(to).map(|(a, b)| ours(a, b)).collect()
}

/// Everybody to the opposite side of a level circle, all through its middle.
pub fn circle(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA2);
    let radius = (count as f64 * 5.0 / TAU).max(12.0);
    let turn = rng.random_range(0.0..TAU);
    let at = |i: usize| {
        let angle = turn + TAU * i as f64 / count as f64;
        Vector3::new(angle.cos(), angle.sin(), 0.0) * radius
    };
    (0..count).map(|i| ours(at(i), -at(i))).collect()
}

/// The same on a sphere (evenly spread along a spiral of the golden angle).
pub fn sphere(count: usize, _seed: u64) -> Vec<Start> {
    let radius = (count as f64 / 4.0 / std::f64::consts::PI).sqrt() * 6.0;
    let radius = radius.max(12.0);
    let at = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
        let level = (1.0 - z * z).sqrt();
        let angle = i as f64 * 2.399_963;
        Vector3::new(level * angle.cos(), level * angle.sin(), z) * radius
    };
    (0..count).map(|i| ours(at(i), -at(i))).collect()
}

/// Two streams that cross at right angles.
pub fn streams(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA4);
    let shift = rng.random_range(-2.5..2.5);
    (0..count)
        .map(|i| {
            let row = (i / 2) as f64;
            let along = -20.0 - 5.0 * (row / 3.0).floor();
            let across = (row % 3.0 - 1.0) * 5.0;
            if i % 2 == 0 {
                let from = Vector3::new(along, across, 0.0);
                ours(from, Vector3::new(-along, across, 0.0))
            } else {
                let from = Vector3::new(across + shift, along, 0.0);
                ours(from, Vector3::new(across + shift, -along, 0.0))
            }
        })
        .collect()
}

/// Two lines that fly at each other, exactly.
pub fn head_on(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA5);
    let half = rng.random_range(15.0..40.0);
    (0..count)
        .map(|i| {
            let east = (i / 2) as f64 * 6.0;
            let side = if i % 2 == 0 { -1.0 } else { 1.0 };
            ours(
                Vector3::new(side * half, east, 0.0),
                Vector3::new(-side * half, east, 0.0),
            )
        })
        .collect()
}

/// A grid at five metres in which everybody goes to another's place.
pub fn swaps(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA6);
    let columns = (count as f64).sqrt().ceil() as usize;
    let at = |i: usize| Vector3::new((i / columns) as f64 * 5.0, (i % columns) as f64 * 5.0, 0.0);
    let mut to: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        to.swap(i, rng.random_range(0..=i));
    }
    (0..count).map(|i| ours(at(i), at(to[i]))).collect()
}

/// Random ways, during which every fourth vehicle stops answering.
pub fn failing(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA7);
    let mut starts = random(count, seed);
    for (_, _, kind) in starts.iter_mut().step_by(4) {
        if let Kind::Ours { goal } = *kind {
            let then = [Silent::FliesOn, Silent::Hovers, Silent::Drifts][rng.random_range(0..3)];
            let at_s = rng.random_range(0.5..4.0);
            *kind = Kind::Fails { goal, at_s, then };
        }
    }
    starts
}

/// Vehicles that hold or fly, and foreign ones that cross right through them.
pub fn foreign(count: usize, seed: u64) -> Vec<Start> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA8);
    let mut starts = if seed.is_multiple_of(2) {
        random(count, seed)
    } else {
        swaps(count, seed).iter().map(|s| ours(s.0 * 1.6, s.0 * 1.6)).collect()
    };
    let mut left = 1 + count / 10;
    while left > 0 {
        let through = starts[rng.random_range(0..count)].0;
        let course = rng.random_range(0.0..TAU);
        let climb = rng.random_range(-0.15..0.15);
        let direction = Vector3::new(course.cos(), course.sin(), climb);
        let velocity = direction * rng.random_range(2.0..15.0);
        let seconds = rng.random_range(7.0..9.0);
        let from = through - velocity * seconds;
        if starts.iter().all(|s| (s.0 - from).norm() > 20.0) {
            starts.push((from, velocity, Kind::Foreign));
            left -= 1;
        }
    }
    starts
}

pub type Make = fn(usize, u64) -> Vec<Start>;

pub const ALL: [(&str, Make); 8] = [
    ("random", random),
    ("circle", circle),
    ("sphere", sphere),
    ("streams", streams),
    ("head_on", head_on),
    ("swaps", swaps),
    ("failing", failing),
    ("foreign", foreign),
];
