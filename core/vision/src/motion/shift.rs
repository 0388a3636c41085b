//! How far one picture has moved against another: blocks that are easily told from their neighbours are looked for, from coarse to fine, and the
//! median of their ways is the picture's.

use crate::gray::Gray;

/// Side of a block in pixels.
const BLOCK: usize = 16;
/// Blocks that are looked for, the clearest of a raster.
const MOST_BLOCKS: usize = 48;
/// How far is looked in the coarsest picture, in its pixels.
const REACH: i32 = 6;
/// Pictures are halved until they are no wider than this.
const COARSEST_WIDTH: usize = 100;
/// So many of the blocks have to agree with the median.
const AGREE_SHARE: f64 = 0.5;
/// To so many pixels.
const AGREE_PX: f64 = 1.5;
/// A block without this much contrast between neighbours, on average, is told from nothing.
const LEAST_CONTRAST: f64 = 1.5;

/// How far the picture has moved to the right and down since the last one, which is looked for around where it is expected; `None` if most of it agrees on nothing.
/// A picture without any contrast has not moved.
pub(super) fn between(last: &Gray, picture: &Gray, expected: (f64, f64)) -> Option<(f64, f64)> {
    let mut pyramid = vec![(last.clone(), picture.clone())];
    while let Some((coarse_last, coarse)) = pyramid.last().filter(|(last, _)| last.width > COARSEST_WIDTH) {
        pyramid.push((coarse_last.halved(), coarse.halved()));
    }
    let mut guess = (0, 0);
    let mut found = Some((0.0, 0.0));
    for (level, (last, picture)) in pyramid.iter().enumerate().rev() {
        let coarsest = level + 1 == pyramid.len();
        let reach = if coarsest { REACH } else { 2 };
        guess = if coarsest {
            let scale = f64::from(1_u32 << level.min(16));
            ((expected.0 / scale).round() as i32, (expected.1 / scale).round() as i32)
        } else {
            (guess.0 * 2, guess.1 * 2)
        };
        found = median(last, picture, guess, reach);
        let (x, y) = found?;
        guess = (x.round() as i32, y.round() as i32);
    }
    found
}

/// The median of the ways of the clearest blocks, if enough agree with it.
fn median(last: &Gray, picture: &Gray, guess: (i32, i32), reach: i32) -> Option<(f64, f64)> {
    let blocks = clearest(last);
    if blocks.is_empty() {
        return Some((0.0, 0.0));
    }
    let ways: Vec<(f64, f64)> = blocks
        .into_iter()
        .map(|block| way(last, picture, block, guess, reach))
        .collect();
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (x, y) = (
        middle(ways.iter().map(|way| way.0).collect()),
        middle(ways.iter().map(|way| way.1).collect()),
    );
    let near = |way: &&(f64, f64)| (way.0 - x).abs() <= AGREE_PX && (way.1 - y).abs() <= AGREE_PX;
    let agree = ways.iter().filter(near).count();
    (agree as f64 >= AGREE_SHARE * ways.len() as f64).then_some((x, y))
}

/// Upper left corners of the blocks that have most contrast between neighbours, both across and down.
fn clearest(picture: &Gray) -> Vec<(usize, usize)> {
    let mut blocks = Vec::new();
    for top in (BLOCK / 2..picture.height.saturating_sub(BLOCK + BLOCK / 2)).step_by(BLOCK) {
        for left in (BLOCK / 2..picture.width.saturating_sub(BLOCK + BLOCK / 2)).step_by(BLOCK) {
            let (mut across, mut down) = (0_u32, 0_u32);
            for y in top..top + BLOCK {
                let (row, next) = (picture.row(y), picture.row(y + 1));
                for x in left..left + BLOCK {
                    across += u32::from(row[x].abs_diff(row[x + 1]));
                    down += u32::from(row[x].abs_diff(next[x]));
                }
            }
            let contrast = f64::from(across.min(down)) / (BLOCK * BLOCK) as f64;
            if contrast >= LEAST_CONTRAST {
                blocks.push((contrast, (left, top)));
            }
        }
    }
    blocks.sort_by(|a, b| b.0.total_cmp(&a.0));
    blocks.into_iter().take(MOST_BLOCKS).map(|(_, place)| place).collect()
}

/// How far a block has moved, to a fraction of a pixel.
fn way(last: &Gray, picture: &Gray, (left, top): (usize, usize), guess: (i32, i32), reach: i32) -> (f64, f64) {
    let cost = |x: i32, y: i32| -> u32 {
        let mut sum = 0;
        for row in 0..BLOCK {
            let from = &last.row(top + row)[left..left + BLOCK];
            for (column, pixel) in from.iter().enumerate() {
                let there = picture.at((left + column) as i32 + x, (top + row) as i32 + y);
                sum += u32::from(pixel.abs_diff(there));
            }
        }
        sum
    };
    let mut best = (u32::MAX, guess);
    for y in guess.1 - reach..=guess.1 + reach {
        for x in guess.0 - reach..=guess.0 + reach {
            let cost = cost(x, y);
            // Of two that fit as well the nearer one.
            let nearer = |(x, y): (i32, i32)| (x - guess.0).abs() + (y - guess.1).abs();
            if cost < best.0 || (cost == best.0 && nearer((x, y)) < nearer(best.1)) {
                best = (cost, (x, y));
            }
        }
    }
    let (least, (x, y)) = best;
    // The vertex of the parabola through the best and its neighbours.
    let part = |before: u32, after: u32| {
        let (before, least, after) = (f64::from(before), f64::from(least), f64::from(after));
        let curve = before - 2.0 * least + after;
        if curve > 0.0 {
            (0.5 * (before - after) / curve).clamp(-0.5, 0.5)
        } else {
            0.0
        }
    };
    (
        f64::from(x) + part(cost(x - 1, y), cost(x + 1, y)),
        f64::from(y) + part(cost(x, y - 1), cost(x, y + 1)),
    )
}
