//! Polynomials over one piece of a trajectory, and proven bounds of their values.
//!
//! A polynomial in Bernstein form lies between its smallest and its largest coefficient; halving the interval brings the two together
//! quadratically (Lane & Riesenfeld 1981). So peaks are bounded without looking for roots, and nothing depends on how finely one samples.

use skein_domain::TrajectoryPiece;
use std::cell::Cell;

/// Room for the square of a polynomial of the seventh degree.
const ROOM: usize = 16;
/// The highest degree of a piece's own polynomials.
pub(super) const MAX_DEGREE: usize = 7;
/// An interval is halved at most so often: a share of 1/4096 of a piece is looked at as one.
const DEEPEST: u8 = 12;

/// A polynomial in the share of a piece's time, 0 to 1; in powers of it or in Bernstein form, as its owner knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polynomial {
    degree: usize,
    coefficients: [f64; ROOM],
}

impl Polynomial {
    /// From coefficients, constant term first. Those beyond the room are left out; callers check the degree before.
    pub fn new(coefficients: &[f64]) -> Self {
        let mut own = [0.0; ROOM];
        own.iter_mut().zip(coefficients).for_each(|(to, from)| *to = *from);
        Self {
            degree: coefficients.len().clamp(1, ROOM) - 1,
            coefficients: own,
        }
    }

    /// From coefficients in seconds over `duration_s`, in powers.
    pub fn over(coefficients: &[f64], duration_s: f64) -> Self {
        let mut own = Self::new(coefficients);
        let mut scale = 1.0;
        for c in &mut own.coefficients {
            *c *= scale;
            scale *= duration_s;
        }
        own
    }

    /// The coefficients.
    pub fn all(&self) -> &[f64] {
        self.coefficients.get(..=self.degree).unwrap_or(&self.coefficients)
    }

    /// One in powers as one of a higher degree, with zeros.
    pub fn of_degree(&self, degree: usize) -> Self {
        Self {
            degree: self.degree.max(degree.min(ROOM - 1)),
            ..*self
        }
    }

    /// The derivative by the share of time, in powers.
    pub fn derivative(&self) -> Self {
        let slopes: Vec<f64> = self
            .all()
            .iter()
            .enumerate()
            .skip(1)
            .map(|(power, c)| power as f64 * c)
            .collect();
        Self::new(&slopes)
    }

    /// The same polynomial over the part of the interval from share `begin`, `length` long, as one from 0 to 1; in powers.
    pub fn part(&self, begin: f64, length: f64) -> Self {
        let mut shifted = *self;
        // Taylor shift by synthetic division, then scaling.
        let cells = Cell::from_mut(&mut shifted.coefficients[..]).as_slice_of_cells();
        for lowest in 0..self.degree {
            for power in (lowest..self.degree).rev() {
                if let (Some(here), Some(above)) = (cells.get(power), cells.get(power + 1)) {
                    here.set(here.get() + begin * above.get());
                }
            }
        }
        Self {
            coefficients: Self::over(shifted.all(), length).coefficients,
            ..shifted
        }
    }

    /// Difference, in either form if both have the same and the same degree.
    pub fn minus(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a - b)
    }

    /// Sum.
    pub fn plus(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a + b)
    }

    fn combined(&self, other: &Self, with: impl Fn(f64, f64) -> f64) -> Self {
        let mut own = *self;
        own.degree = self.degree.max(other.degree);
        own.coefficients
            .iter_mut()
            .zip(&other.coefficients)
            .for_each(|(a, b)| *a = with(*a, *b));
        own
    }

    /// Product, in powers.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = [0.0; ROOM];
        for (power, a) in self.all().iter().enumerate() {
            product
                .iter_mut()
                .skip(power)
                .zip(other.all())
                .for_each(|(to, b)| *to += a * b);
        }
        Self {
            degree: (self.degree + other.degree).min(ROOM - 1),
            coefficients: product,
        }
    }

    /// From powers to Bernstein form.
    pub fn bernstein(&self) -> Self {
        let degree = self.degree as f64;
        let mut own = *self;
        let mut share = 1.0; // 1 / C(degree, i)
        for (i, c) in own.coefficients.iter_mut().enumerate().take(self.degree + 1) {
            *c *= share;
            share *= (i as f64 + 1.0) / (degree - i as f64).max(1.0);
        }
        // b_j = Σ_i C(j, i) (a_i / C(n, i)): n rounds of adding neighbours, from the end.
        let cells = Cell::from_mut(&mut own.coefficients[..]).as_slice_of_cells();
        for lowest in (1..=self.degree).rev() {
            for j in lowest..=self.degree {
                if let (Some(before), Some(here)) = (cells.get(j - 1), cells.get(j)) {
                    here.set(here.get() + before.get());
                }
            }
        }
        own
    }

    /// Both halves of one in Bernstein form (de Casteljau).
    pub fn halves(&self) -> (Self, Self) {
        let (mut left, mut right, mut row) = (*self, *self, *self);
        let cells = Cell::from_mut(&mut row.coefficients[..]).as_slice_of_cells();
        for round in 1..=self.degree {
            for pair in cells.windows(2).take(self.degree) {
                if let [here, next] = pair {
                    here.set(0.5 * (here.get() + next.get()));
                }
            }
            // Row entry i is now the mean over i..=i + round: the first is the left half's, the last full one the right half's.
            let ends = [
                (&mut left, round, 0),
                (&mut right, self.degree - round, self.degree - round),
            ];
            for (half, at, from) in ends {
                if let (Some(to), Some(value)) = (half.coefficients.get_mut(at), cells.get(from)) {
                    *to = value.get();
                }
            }
        }
        (left, right)
    }

    /// Smallest and largest coefficient, which enclose the values of one in Bernstein form.
    pub fn enclosure(&self) -> (f64, f64) {
        self.all()
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
                if c.is_nan() {
                    (f64::NEG_INFINITY, f64::INFINITY)
                } else {
                    (low.min(*c), high.max(*c))
                }
            })
    }

    /// The values at both ends of one in Bernstein form.
    fn ends(&self) -> (f64, f64) {
        let last = self.all().last().copied().unwrap_or(0.0);
        (self.coefficients[0], last)
    }

    /// An upper bound of the values of one in Bernstein form, at most a tolerance above the largest (or as near as the deepest halving
    /// comes). The tolerance may depend on the largest value found so far. Infinite if a coefficient is not a number.
    pub fn at_most_by(&self, tolerance: impl Fn(f64) -> f64) -> f64 {
        self.at_most_above(f64::NEG_INFINITY, tolerance)
    }

    /// The same, and not looked at more closely where it is surely no more than `enough`.
    pub fn at_most_above(&self, enough: f64, tolerance: impl Fn(f64) -> f64) -> f64 {
        let mut reached = f64::NEG_INFINITY;
        let mut bound = f64::NEG_INFINITY;
        let mut open = vec![(*self, 0_u8)];
        while let Some((part, depth)) = open.pop() {
            let (begin, end) = part.ends();
            reached = reached.max(begin).max(end);
            let (_, high) = part.enclosure();
            if high <= (reached + tolerance(reached)).max(enough) || depth >= DEEPEST || !high.is_finite() {
                bound = bound.max(high);
            } else {
                let (left, right) = part.halves();
                open.push((left, depth + 1));
                open.push((right, depth + 1));
            }
        }
        bound
    }

    /// With the other sign.
    pub fn negated(&self) -> Self {
        let mut own = *self;
        own.coefficients.iter_mut().for_each(|c| *c = -*c);
        own
    }
}

/// The axes of a piece, in powers of the share of its time.
pub(super) fn axes(piece: &TrajectoryPiece) -> [Polynomial; 3] {
    [&piece.north, &piece.east, &piece.down].map(|axis| Polynomial::over(axis, piece.duration_s))
}

/// The sum of squares, in Bernstein form, of polynomials in powers.
pub(super) fn squared(parts: &[Polynomial]) -> Polynomial {
    parts
        .iter()
        .map(|part| part.times(part))
        .fold(Polynomial::new(&[0.0]), |sum, square| sum.plus(&square))
        .bernstein()
}
