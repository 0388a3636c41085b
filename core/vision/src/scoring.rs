//! How good what was found is, against what is known to be there: precision, recall, F1 and average precision of boxes; MOTA, IDF1 and identity
//! switches of tracks.
//!
//! A box is right if it shares half of the area that both cover with a true box of its class (intersection over union of 0.5, as PASCAL VOC has it).
//! MOTA as by Bernardin and Stiefelhagen (2008), IDF1 as by Ristani et al. (2016).
//!
//! Must never do: count a box twice, or leave out a picture in which nothing is.

use crate::Bounds;
use crate::assignment::assign;
use std::collections::BTreeMap;

/// Boxes share at least this much, or are not of the same thing.
const SAME_OVERLAP: f64 = 0.5;

/// Something that is there.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueBox {
    /// Which thing of the clip it is.
    pub thing: u64,
    /// What it is.
    pub class: String,
    /// Where.
    pub bounds: Bounds,
}

/// Something that was told.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldBox {
    /// The name of its track in the clip.
    pub track: u64,
    /// What it was taken for.
    pub class: String,
    /// How surely, 0..=1.
    pub score: f64,
    /// Where.
    pub bounds: Bounds,
}

/// What a class of things came to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scores {
    /// True boxes.
    pub truths: u64,
    /// Boxes that were told.
    pub told: u64,
    /// Those of them that are right.
    pub right: u64,
    /// Pictures in which a thing was followed under another name than before.
    pub identity_switches: u64,
    /// Share of what was told that is right; 1 if nothing was told.
    pub precision: f64,
    /// Share of what is there that was told; 1 if nothing is.
    pub recall: f64,
    /// Harmonic mean of the two.
    pub f1: f64,
    /// Area under precision over recall, over all thresholds of the score that what was told has.
    pub ap50: f64,
    /// One less misses, false boxes and identity switches, as a share of the true boxes; may be negative.
    pub mota: f64,
    /// Share of boxes that are right under the one name that fits a thing best, over the whole clip.
    pub idf1: f64,
}

/// Counts for one class, clip by clip.
#[derive(Debug, Clone, Default)]
pub struct Scorer {
    class: String,
    truths: u64,
    right: u64,
    switches: u64,
    identities_right: u64,
    /// Score of each box that was told, and whether it is right.
    told: Vec<(f64, bool)>,
}

impl Scorer {
    /// For one class.
    #[must_use]
    pub fn new(class: &str) -> Self {
        Self {
            class: class.to_owned(),
            ..Self::default()
        }
    }

    /// Takes a whole clip: for each picture what is there, and what was told.
    pub fn clip(&mut self, pictures: &[(Vec<TrueBox>, Vec<ToldBox>)]) {
        let mut names: BTreeMap<u64, u64> = BTreeMap::new();
        let mut together: BTreeMap<(u64, u64), u64> = BTreeMap::new();
        for (truths, told) in pictures {
            let truths: Vec<&TrueBox> = truths.iter().filter(|truth| truth.class == self.class).collect();
            let told: Vec<&ToldBox> = told.iter().filter(|told| told.class == self.class).collect();
            let pairs = assign(truths.len(), told.len(), 1.0, |row, column| {
                let overlap = truths[row].bounds.overlap(&told[column].bounds);
                (overlap >= SAME_OVERLAP).then_some(1.0 - overlap)
            });
            let mut is_right = vec![false; told.len()];
            for (row, column) in pairs {
                is_right[column] = true;
                let (thing, track) = (truths[row].thing, told[column].track);
                *together.entry((thing, track)).or_default() += 1;
                if names.insert(thing, track).is_some_and(|before| before != track) {
                    self.switches += 1;
                }
            }
            self.truths += truths.len() as u64;
            self.right += is_right.iter().filter(|right| **right).count() as u64;
            self.told
                .extend(told.iter().zip(is_right).map(|(told, right)| (told.score, right)));
        }
        self.identities_right += best_identities(&together);
    }

    /// What it came to.
    #[must_use]
    pub fn scores(&self) -> Scores {
        let told = self.told.len() as u64;
        let share = |part: u64, whole: u64| if whole == 0 { 1.0 } else { part as f64 / whole as f64 };
        let (missed, wrong) = (self.truths - self.right, told - self.right);
        let faults = (missed + wrong + self.switches) as f64;
        Scores {
            truths: self.truths,
            told,
            right: self.right,
            identity_switches: self.switches,
            precision: share(self.right, told),
            recall: share(self.right, self.truths),
            f1: share(2 * self.right, self.truths + told),
            ap50: self.average_precision(),
            mota: if self.truths == 0 {
                0.0
            } else {
                1.0 - faults / self.truths as f64
            },
            idf1: share(2 * self.identities_right, self.truths + told),
        }
    }

    /// The area under precision over recall, where precision is the best of this and any greater recall.
    fn average_precision(&self) -> f64 {
        let mut told = self.told.clone();
        told.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut right = 0.0;
        let mut curve: Vec<(f64, f64)> = Vec::with_capacity(told.len());
        for (index, (_, is_right)) in told.iter().enumerate() {
            right += f64::from(u8::from(*is_right));
            curve.push((right / self.truths.max(1) as f64, right / (index + 1) as f64));
        }
        let (mut area, mut best, mut beyond) = (0.0, 0.0_f64, curve.last().map_or(0.0, |last| last.0));
        for (recall, precision) in curve.into_iter().rev() {
            area += (beyond - recall) * best;
            best = best.max(precision);
            beyond = recall;
        }
        area + beyond * best
    }
}

/// Most pictures in which things go by one name each, if each name is given to one thing.
fn best_identities(together: &BTreeMap<(u64, u64), u64>) -> u64 {
    let sorted = |mut all: Vec<u64>| {
        all.sort_unstable();
        all.dedup();
        all
    };
    let things = sorted(together.keys().map(|(thing, _)| *thing).collect());
    let tracks = sorted(together.keys().map(|(_, track)| *track).collect());
    let most = together.values().max().copied().unwrap_or(0) as f64;
    let count = |row: usize, column: usize| together.get(&(things[row], tracks[column])).copied();
    let pairs = assign(things.len(), tracks.len(), most + 1.0, |row, column| {
        count(row, column).map(|count| most - count as f64)
    });
    pairs.into_iter().filter_map(|(row, column)| count(row, column)).sum()
}

#[cfg(test)]
mod tests;
