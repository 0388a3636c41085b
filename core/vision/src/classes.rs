//! What a thing is taken for: a score for each class that a detector knows.

use std::collections::BTreeMap;

/// The class of what is there and looks like nothing that is known.
pub const UNKNOWN_CLASS: &str = "unknown";

/// Scores by class, each 0..=1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClassScores(BTreeMap<String, f64>);

impl ClassScores {
    /// Of one class alone; a score that is no number is taken for nothing.
    #[must_use]
    pub fn one(class: &str, score: f64) -> Self {
        Self::all([(class.to_owned(), score)])
    }

    /// Of several classes.
    #[must_use]
    pub fn all(scores: impl IntoIterator<Item = (String, f64)>) -> Self {
        let scores = scores.into_iter();
        Self(
            scores
                .filter(|(_, score)| *score > 0.0)
                .map(|(class, score)| (class, score.min(1.0)))
                .collect(),
        )
    }

    /// The class with the greatest score, and the score; `None` if there is none.
    #[must_use]
    pub fn best(&self) -> Option<(&str, f64)> {
        let best = self.0.iter().max_by(|a, b| a.1.total_cmp(b.1));
        best.map(|(class, score)| (class.as_str(), *score))
    }

    /// The score of one class.
    #[must_use]
    pub fn of(&self, class: &str) -> f64 {
        self.0.get(class).copied().unwrap_or(0.0)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(class, score)| (class.as_str(), *score))
    }

    /// The same ones, but what one class has goes to another.
    #[must_use]
    pub fn renamed(&self, from: &str, to: &str) -> Self {
        let mut scores = self.0.clone();
        if let Some(score) = scores.remove(from) {
            let of_other = scores.entry(to.to_owned()).or_insert(0.0);
            *of_other = of_other.max(score);
        }
        Self(scores)
    }

    /// The same ones, each nearer to 1 by `share`, 0..=1, of what it lacks, times itself: a small score stays small.
    #[must_use]
    pub fn raised(&self, share: f64) -> Self {
        Self(
            self.0
                .iter()
                .map(|(class, score)| (class.clone(), score + share * (1.0 - score) * score))
                .collect(),
        )
    }

    /// Moves all scores by `share`, 0..=1, towards those of another one.
    pub fn blend(&mut self, newer: &Self, share: f64) {
        for score in self.0.values_mut() {
            *score *= 1.0 - share;
        }
        for (class, score) in &newer.0 {
            *self.0.entry(class.clone()).or_insert(0.0) += share * score;
        }
        self.0.retain(|_, score| *score > 1e-4);
    }
}
