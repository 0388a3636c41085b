//! What rows pay for columns, worked out from the lengths whenever it is asked: a table of its own would take longer to fill than all
//! of it is asked for. Must never give a number that is not whole.

use super::{FINEST, LARGEST_SUM, smaller};
use crate::assignment::bottleneck::largest;
use crate::assignment::{Costs, Total};

/// Ways that are not allowed, in the dearest that is, where prices to begin with are looked for.
const FORBIDDEN: f64 = 4.0;

/// How lengths become whole numbers.
pub(super) struct Scale {
    total: Total,
    /// Ways that are longer are not allowed; finite.
    pub longest: f64,
    /// Rows and columns: what there are more of, vehicles or slots.
    pub size: usize,
    /// The dearest way that is allowed costs this.
    pub finest: f64,
    unit: f64,
}

impl Scale {
    pub fn of(costs: &Costs, total: Total, longest: f64) -> Self {
        let size = costs.vehicles.max(costs.slots);
        let longest = longest.min(f64::MAX);
        let farthest = largest(&costs.lengths, longest);
        let dearest = match total {
            Total::Ways => farthest,
            Total::Squares => farthest * farthest,
        };
        let finest = FINEST.min(LARGEST_SUM / ((size + 1) * (size + 1)) as f64).floor();
        Self {
            total,
            longest,
            size,
            finest,
            unit: if dearest > 0.0 { finest / dearest } else { 0.0 },
        }
    }

    /// A vehicle without slot is worse than all ways together.
    fn without(&self) -> f64 {
        self.finest * (self.size + 1) as f64
    }

    /// What is not allowed costs at least this.
    pub fn forbidden(&self) -> f64 {
        // Of one vehicle alone `without` is less.
        FORBIDDEN.min((self.size + 1) as f64) * self.finest
    }

    /// What a way costs.
    fn cost(&self, length: f64) -> f64 {
        let whole = smaller(self.whole(length), self.finest);
        if length <= self.longest { whole } else { self.without() }
    }

    /// The same for prices to begin with: of a few vehicles and slots all ways that are allowed may be missing.
    fn rough_cost(&self, length: f64) -> f64 {
        let most = self.forbidden();
        // Infinite lengths may come out as no number.
        if length < f64::INFINITY {
            smaller(self.whole(length), most)
        } else {
            most
        }
    }

    fn whole(&self, length: f64) -> f64 {
        let cost = match self.total {
            Total::Ways => length * self.unit,
            Total::Squares => length * length * self.unit,
        };
        // A number this large has no room for fractions: many times as quick as to ask for rounding.
        (cost + LARGEST_SUM) - LARGEST_SUM
    }
}

/// All of the vehicles and slots, or a few.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    costs: &'a Costs,
    pub scale: &'a Scale,
    /// Which rows and columns; none if all.
    few: Option<(&'a [usize], &'a [usize])>,
}

impl<'a> Problem<'a> {
    pub fn whole(costs: &'a Costs, scale: &'a Scale) -> Self {
        Self {
            costs,
            scale,
            few: None,
        }
    }

    pub fn few(costs: &'a Costs, scale: &'a Scale, rows: &'a [usize], columns: &'a [usize]) -> Self {
        Self {
            costs,
            scale,
            few: Some((rows, columns)),
        }
    }

    /// How many rows and how many columns there are.
    pub fn size(&self) -> usize {
        self.few.map_or(self.scale.size, |(rows, _)| rows.len())
    }

    /// What a row pays for a column.
    pub fn cost(&self, row: usize, column: usize) -> f64 {
        let Some((rows, columns)) = self.few else {
            return if row < self.costs.vehicles {
                self.scale.cost(self.costs.length(row, column))
            } else {
                0.0
            };
        };
        let (Some(row), Some(column)) = (rows.get(row), columns.get(column)) else {
            return 0.0;
        };
        if *row < self.costs.vehicles {
            self.scale.rough_cost(self.costs.length(*row, *column))
        } else {
            0.0
        }
    }

    /// What a row pays for each column.
    pub fn row(&self, row: usize, into: &mut Vec<f64>) {
        into.clear();
        let (Costs { vehicles, slots, .. }, scale) = (self.costs, self.scale);
        let place = self.few.map_or(Some(row), |(rows, _)| rows.get(row).copied());
        let lengths = place
            .filter(|row| row < vehicles)
            .and_then(|row| self.costs.lengths.get(row * slots..(row + 1) * slots));
        let Some(lengths) = lengths else {
            // A vehicle that is not there takes what is left for nothing.
            into.resize(self.size(), 0.0);
            return;
        };
        if let Some((_, columns)) = self.few {
            let length = |column: &usize| lengths.get(*column).copied().unwrap_or(f64::INFINITY);
            into.extend(columns.iter().map(|column| scale.rough_cost(length(column))));
        } else {
            // All that is asked for in the loop is at hand, or else it would not be done two at a time.
            let (unit, finest, without, longest) = (scale.unit, scale.finest, scale.without(), scale.longest);
            let cost = |length: f64, cost: f64| {
                let whole = smaller((cost * unit + LARGEST_SUM) - LARGEST_SUM, finest);
                if length <= longest { whole } else { without }
            };
            match scale.total {
                Total::Ways => into.extend(lengths.iter().map(|length| cost(*length, *length))),
                Total::Squares => into.extend(lengths.iter().map(|length| cost(*length, length * length))),
            }
            into.resize(scale.size, without);
        }
    }
}
