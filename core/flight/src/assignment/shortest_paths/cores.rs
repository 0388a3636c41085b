//! Of each row its cheapest columns (the core of Volgenant, *Linear and semi-assignment problems: a core oriented approach*,
//! Computers & Operations Research 23, 1996), so that a bid or a path need not look at all of them.
//!
//! Prices only ever fall, so that the columns left out stay at least as dear as they were when the core was chosen; once something
//! gets as dear as that, the whole row is looked at again. Must never leave out a column for good.

use super::problem::Problem;
use super::{NOBODY, larger, price, smaller};

/// How many columns a core begins with.
const CORE: usize = 40;
/// Columns whose cheapest stands for all of them when a core is chosen.
const GROUP: usize = 8;

/// The cheapest columns of a row.
pub(super) struct Core {
    /// Each with its cost.
    pub columns: Vec<(usize, f64)>,
    /// Cost minus price of every other column is at least this.
    pub others: f64,
}

/// The two columns with the least of cost minus price, each with it.
pub(super) struct Cheapest {
    pub first: (usize, f64),
    pub second: (usize, f64),
}

/// The cores of all rows.
pub(super) struct Cores<'a> {
    problem: Problem<'a>,
    cores: Vec<Core>,
    reduced: Vec<f64>,
    least: Vec<f64>,
    sorted: Vec<f64>,
}

impl<'a> Cores<'a> {
    pub fn new(problem: Problem<'a>, prices: &[f64]) -> Self {
        let size = problem.size();
        let none = || Core {
            columns: Vec::with_capacity(2 * CORE),
            others: f64::NEG_INFINITY,
        };
        let mut cores = Self {
            problem,
            cores: (0..size).map(|_| none()).collect(),
            reduced: Vec::with_capacity(size),
            least: Vec::new(),
            sorted: Vec::new(),
        };
        for row in 0..size {
            cores.choose(row, CORE, prices);
        }
        cores
    }

    pub fn of(&self, row: usize) -> Option<&Core> {
        self.cores.get(row)
    }

    /// A core of about twice as many columns, at these prices.
    pub fn widen(&mut self, row: usize, prices: &[f64]) {
        let wanted = self.of(row).map_or(CORE, |core| 2 * core.columns.len());
        self.choose(row, wanted, prices);
    }

    /// How much dearer than its cheapest column the dearest of a core is, those aside that are not allowed: the median of all rows.
    pub fn spread(&self, prices: &[f64]) -> f64 {
        let most = self.problem.scale.forbidden();
        let spread = |core: &Core| {
            let allowed = core.columns.iter().filter(|(_, cost)| *cost < most);
            let reduced = allowed.map(|(column, cost)| cost - price(prices, *column));
            let (least, largest) = reduced.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, largest), reduced| {
                (smaller(least, reduced), larger(largest, reduced))
            });
            larger(largest - least, 0.0)
        };
        let mut spreads: Vec<f64> = self.cores.iter().map(spread).collect();
        let middle = spreads.len() / 2;
        spreads.sort_unstable_by(f64::total_cmp);
        spreads.get(middle).copied().unwrap_or(0.0)
    }

    pub fn two_cheapest(&mut self, row: usize, prices: &[f64]) -> Cheapest {
        if let Some(core) = self.of(row) {
            let cheapest = two_cheapest(core, prices);
            if cheapest.second.1 <= core.others {
                return cheapest;
            }
        }
        self.choose(row, CORE, prices);
        self.of(row).map_or(Cheapest::NONE, |core| two_cheapest(core, prices))
    }

    /// Chooses at least the cheapest `wanted` columns (all if there are not that many more).
    fn choose(&mut self, row: usize, wanted: usize, prices: &[f64]) {
        let Some(core) = self.cores.get_mut(row) else { return };
        core.columns.clear();
        core.others = f64::INFINITY;
        let size = self.problem.size();
        self.problem.row(row, &mut self.reduced);
        if wanted * 2 >= size {
            core.columns.extend(self.reduced.iter().copied().enumerate());
            return;
        }
        // Columns a stride apart are a group; as many groups as are wanted have something at least as cheap as the limit.
        let stride = size.div_ceil(GROUP).max(2 * wanted).min(size);
        self.least.clear();
        self.least.resize(stride, f64::INFINITY);
        for (reduced, prices) in self.reduced.chunks_mut(stride).zip(prices.chunks(stride)) {
            for ((least, reduced), price) in self.least.iter_mut().zip(reduced).zip(prices) {
                *reduced -= price;
                *least = smaller(*least, *reduced);
            }
        }
        self.sorted.clone_from(&self.least);
        let (_, limit, _) = self
            .sorted
            .select_nth_unstable_by(wanted.min(stride - 1), f64::total_cmp);
        let limit = *limit;
        let mut at_limit = 0;
        for (group, _) in self.least.iter().enumerate().filter(|(_, least)| **least <= limit) {
            for column in (group..size).step_by(stride) {
                let (Some(reduced), Some(price)) = (self.reduced.get(column), prices.get(column)) else {
                    continue;
                };
                if *reduced < limit || (*reduced == limit && at_limit < wanted) {
                    at_limit += usize::from(*reduced == limit);
                    core.columns.push((column, reduced + price));
                }
            }
        }
        core.others = limit;
    }
}

impl Cheapest {
    const NONE: Self = Self {
        first: (NOBODY, f64::INFINITY),
        second: (NOBODY, f64::INFINITY),
    };
}

fn two_cheapest(core: &Core, prices: &[f64]) -> Cheapest {
    let Cheapest { mut first, mut second } = Cheapest::NONE;
    for (column, cost) in &core.columns {
        let reduced = cost - price(prices, *column);
        if reduced < second.1 {
            if reduced < first.1 {
                second = first;
                first = (*column, reduced);
            } else {
                second = (*column, reduced);
            }
        }
    }
    Cheapest { first, second }
}
