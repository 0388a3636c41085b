//! Curves over time, thinned while they are read: whatever the length of a flight, a curve takes the same memory, and no peak of it is lost.
//!
//! Must never do: draw a line over a time in which nothing was measured.

use serde::Serialize;
use skein_domain::VehicleId;

/// A line is broken where nothing was measured for so long, in seconds.
const BREAK_S: f64 = 2.0;

/// A value at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sample {
    /// Seconds since the recording begins.
    pub t_s: f64,
    /// The value, in the unit of its curve.
    pub value: f64,
    /// The two vehicles it is about, if it is about two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<[VehicleId; 2]>,
}

impl Sample {
    /// One that is about no pair.
    #[must_use]
    pub fn new(t_s: f64, value: f64) -> Self {
        Self { t_s, value, pair: None }
    }
}

/// A thinned curve: pieces without a gap in them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Curve {
    /// The pieces in order of time.
    pub pieces: Vec<Vec<Sample>>,
}

impl Curve {
    /// All its samples.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.pieces.iter().flatten()
    }

    /// The sample with the smallest value.
    #[must_use]
    pub fn lowest(&self) -> Option<&Sample> {
        self.samples().min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// The sample with the largest value.
    #[must_use]
    pub fn highest(&self) -> Option<&Sample> {
        self.samples().max_by(|a, b| a.value.total_cmp(&b.value))
    }
}

/// What is kept of a stretch of time.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    number: i64,
    first_s: f64,
    last_s: f64,
    low: Sample,
    high: Sample,
}

/// Thins a curve: of each stretch of time its lowest and highest sample are kept. When there are too many stretches, two become one.
#[derive(Debug, Clone)]
pub struct Thinner {
    most: usize,
    width_s: f64,
    stretches: Vec<Stretch>,
}

impl Thinner {
    /// One that keeps no more than so many points.
    #[must_use]
    pub fn new(points: usize) -> Self {
        Self {
            most: (points / 2).max(1),
            width_s: 0.1,
            stretches: Vec::new(),
        }
    }

    /// The next sample. What is no number is left out.
    pub fn push(&mut self, sample: Sample) {
        if !(sample.value.is_finite() && sample.t_s.is_finite()) {
            return;
        }
        let number = (sample.t_s / self.width_s).floor() as i64;
        match self.stretches.last_mut() {
            Some(last) if last.number >= number => last.take(sample),
            _ => self.stretches.push(Stretch {
                number,
                first_s: sample.t_s,
                last_s: sample.t_s,
                low: sample,
                high: sample,
            }),
        }
        while self.stretches.len() > self.most {
            self.halve();
        }
    }

    fn halve(&mut self) {
        self.width_s *= 2.0;
        let mut halved: Vec<Stretch> = Vec::with_capacity(self.stretches.len());
        for mut stretch in self.stretches.drain(..) {
            stretch.number = stretch.number.div_euclid(2);
            match halved.last_mut() {
                Some(last) if last.number == stretch.number => last.join(stretch),
                _ => halved.push(stretch),
            }
        }
        self.stretches = halved;
    }

    /// All samples were taken.
    #[must_use]
    pub fn finish(self) -> Curve {
        let mut pieces: Vec<Vec<Sample>> = Vec::new();
        let mut until_s = f64::NEG_INFINITY;
        for stretch in self.stretches {
            if stretch.first_s - until_s > BREAK_S {
                pieces.push(Vec::new());
            }
            until_s = stretch.last_s;
            let (low, high) = (stretch.low, stretch.high);
            let (first, second) = if low.t_s <= high.t_s { (low, high) } else { (high, low) };
            if let Some(piece) = pieces.last_mut() {
                piece.push(first);
                if first != second {
                    piece.push(second);
                }
            }
        }
        Curve { pieces }
    }
}

impl Stretch {
    fn take(&mut self, sample: Sample) {
        self.last_s = self.last_s.max(sample.t_s);
        if sample.value < self.low.value {
            self.low = sample;
        }
        if sample.value > self.high.value {
            self.high = sample;
        }
    }

    fn join(&mut self, next: Self) {
        self.last_s = next.last_s;
        if next.low.value < self.low.value {
            self.low = next.low;
        }
        if next.high.value > self.high.value {
            self.high = next.high;
        }
    }
}

/// Thins a way over the ground: what lies nearer to the last kept point than a tolerance is left out, and the tolerance grows with the way.
#[derive(Debug, Clone)]
pub struct WayThinner {
    most: usize,
    tolerance_m: f64,
    points_m: Vec<[f64; 2]>,
    last_m: Option<[f64; 2]>,
}

impl WayThinner {
    /// One that keeps no more than so many points.
    #[must_use]
    pub fn new(points: usize) -> Self {
        Self {
            most: points.max(2),
            tolerance_m: 0.1,
            points_m: Vec::new(),
            last_m: None,
        }
    }

    /// The next place, as metres north and east.
    pub fn push(&mut self, place_m: [f64; 2]) {
        if !place_m.iter().all(|metres| metres.is_finite()) {
            return;
        }
        self.last_m = Some(place_m);
        keep(&mut self.points_m, place_m, self.tolerance_m);
        while self.points_m.len() > self.most - 1 {
            self.tolerance_m *= 2.0;
            let mut kept = Vec::with_capacity(self.most);
            for point_m in self.points_m.drain(..) {
                keep(&mut kept, point_m, self.tolerance_m);
            }
            self.points_m = kept;
        }
    }

    /// All places were taken. The last one is among the points.
    #[must_use]
    pub fn finish(mut self) -> Vec<[f64; 2]> {
        self.points_m
            .extend(self.last_m.filter(|last| self.points_m.last() != Some(last)));
        self.points_m
    }
}

fn keep(kept_m: &mut Vec<[f64; 2]>, place_m: [f64; 2], tolerance_m: f64) {
    let far = |from: &[f64; 2]| (from[0] - place_m[0]).hypot(from[1] - place_m[1]) >= tolerance_m;
    if kept_m.last().is_none_or(far) {
        kept_m.push(place_m);
    }
}

#[cfg(test)]
mod tests {
    //! Peaks stay, whatever is left out.

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_thinned_curve_is_short_and_keeps_its_extremes(
            values in prop::collection::vec(-1e3..1e3f64, 1..5_000), step_s in 0.01..2.0f64, points in 2usize..400,
        ) {
            let mut thinner = Thinner::new(points);
            for (n, value) in values.iter().enumerate() {
                thinner.push(Sample::new(n as f64 * step_s, *value));
            }
            let curve = thinner.finish();
            prop_assert!(curve.samples().count() <= points);
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert_eq!(curve.lowest().map(|s| s.value), Some(least));
            prop_assert_eq!(curve.highest().map(|s| s.value), Some(most));
            let times: Vec<f64> = curve.samples().map(|s| s.t_s).collect();
            prop_assert!(times.is_sorted());
        }

        #[test]
        fn a_thinned_way_begins_and_ends_where_it_did_and_is_short(
            places in prop::collection::vec((-500.0..500.0f64, -500.0..500.0f64), 1..2_000), points in 3usize..300,
        ) {
            let mut thinner = WayThinner::new(points);
            for (north_m, east_m) in &places {
                thinner.push([*north_m, *east_m]);
            }
            let way = thinner.finish();
            let at = |of: Option<&(f64, f64)>| of.map(|(n, e)| [*n, *e]);
            prop_assert!(way.len() <= points);
            prop_assert_eq!(way.first().copied(), at(places.first()));
            prop_assert_eq!(way.last().copied(), at(places.last()));
        }
    }

    #[test]
    fn a_line_is_broken_where_nothing_was_measured() {
        let mut thinner = Thinner::new(100);
        for t_s in [0.0, 1.0, 2.0, 20.0, 21.0] {
            thinner.push(Sample::new(t_s, t_s));
        }
        thinner.push(Sample::new(22.0, f64::NAN));
        let lengths: Vec<usize> = thinner.finish().pieces.iter().map(Vec::len).collect();
        assert_eq!(lengths, [3, 2]);
    }
}
