//! The least total: the method of Jonker and Volgenant (*A shortest augmenting path algorithm for dense and sparse linear assignment
//! problems*, Computing 38, 1987): prices of slots by column reduction, vehicles bidding for their cheapest slot (augmenting row
//! reduction), and shortest augmenting paths (Dijkstra) for those that are left.
//!
//! Of each row only its cheapest columns are looked at first (the core of Volgenant, *Linear and semi-assignment problems: a core
//! oriented approach*, Computers & Operations Research 23, 1996). Prices only ever fall, so that all others stay at least as dear as
//! they were when the core was chosen; once a path gets as long as that, the whole row is looked at. The result is the exact one.
//!
//! All numbers are whole (as floating point, which holds them exactly), so that it always ends.

use super::{Costs, Total};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No partner.
const NOBODY: usize = usize::MAX;
/// Sums of costs stay below this, where floating point still holds every whole number.
const LARGEST_SUM: f64 = (1_u64 << 52) as f64;
/// No cost is told apart more finely than this share of the largest.
const FINEST: f64 = (1_u64 << 32) as f64;
/// The share of rows left by the first bids, as one over it, from which on bids in steps pay.
const MANY_LEFT: usize = 8;
/// Steps of bids (Bertsekas, *The auction algorithm*, Annals of Operations Research 14, 1988), in shares of the dearest.
const STEPS: [f64; 6] = [
    1.0 / 16.0,
    1.0 / 64.0,
    1.0 / 256.0,
    1.0 / 1024.0,
    1.0 / 4096.0,
    1.0 / 32768.0,
];
/// Bids per vehicle before the rest is left to shortest paths.
const BIDS: usize = 6;

/// Each vehicle's slot: as many as possible of the ways not longer than `longest`, the least total of those.
pub(super) fn solve(costs: &Costs, total: Total, longest: f64) -> Vec<Option<usize>> {
    let size = costs.vehicles.max(costs.slots);
    if costs.vehicles == 0 || costs.slots == 0 {
        return vec![None; costs.vehicles];
    }
    let allowed = |length: f64| length <= longest && length.is_finite();
    let cost = |length: f64| match total {
        Total::Ways => length,
        Total::Squares => length * length,
    };
    let dearest = costs
        .lengths
        .iter()
        .copied()
        .filter(|l| allowed(*l))
        .map(cost)
        .fold(0.0, f64::max);
    let finest = FINEST.min(LARGEST_SUM / ((size + 1) * (size + 1)) as f64).floor();
    let unit = if dearest > 0.0 { finest / dearest } else { 0.0 };
    // A vehicle without slot is worse than all ways together.
    let without = finest * (size + 1) as f64;
    let mut square = Vec::with_capacity(size * size);
    for row in costs.rows() {
        let whole = |length: &f64| {
            if allowed(*length) {
                (cost(*length) * unit).round().min(finest)
            } else {
                without
            }
        };
        square.extend(row.iter().map(whole));
        square.resize(square.len() + size - costs.slots, without);
    }
    // Vehicles that are not there take what is left for nothing.
    square.resize(size * size, 0.0);
    let chosen = Solver::new(&square, size).solve(finest);
    let slot = |(vehicle, slot): (usize, usize)| allowed(costs.length(vehicle, slot)).then_some(slot);
    chosen.into_iter().take(costs.vehicles).enumerate().map(slot).collect()
}

/// The state of one solution: rows are vehicles, columns slots.
struct Solver<'a> {
    costs: &'a [f64],
    size: usize,
    prices: Vec<f64>,
    column_of: Vec<usize>,
    row_of: Vec<usize>,
}

impl<'a> Solver<'a> {
    fn new(costs: &'a [f64], size: usize) -> Self {
        Self {
            costs,
            size,
            prices: vec![f64::INFINITY; size],
            column_of: vec![NOBODY; size],
            row_of: vec![NOBODY; size],
        }
    }

    fn solve(mut self, dearest: f64) -> Vec<usize> {
        self.reduce_columns();
        let mut free = self.bid_twice();
        if free.len() > self.size / MANY_LEFT {
            // Prices are far from where they end: the rows fight for them, in ever finer steps, before they start anew.
            for step in STEPS {
                self.part_all();
                self.bid((0..self.size).collect(), (dearest * step).ceil());
            }
            self.part_all();
            free = self.bid_twice();
        }
        if !free.is_empty() {
            let mut search = Search::new(self.costs, self.size, &self.prices, &self.row_of);
            for row in free {
                self.augment(row, &mut search);
            }
        }
        self.column_of
    }

    fn part_all(&mut self) {
        self.column_of.fill(NOBODY);
        self.row_of.fill(NOBODY);
    }

    fn bid_twice(&mut self) -> Vec<usize> {
        let free: Vec<usize> = (0..self.size)
            .filter(|row| self.column_of.get(*row) == Some(&NOBODY))
            .collect();
        let left = self.bid(free, 0.0);
        self.bid(left, 0.0)
    }

    fn row(&self, row: usize) -> &'a [f64] {
        self.costs
            .get(row * self.size..(row + 1) * self.size)
            .unwrap_or_default()
    }

    fn price(&self, column: usize) -> f64 {
        self.prices.get(column).copied().unwrap_or(0.0)
    }

    /// Row and column become partners; gives the row that had the column.
    fn join(&mut self, row: usize, column: usize) -> usize {
        let before = self
            .row_of
            .get_mut(column)
            .map_or(NOBODY, |holder| std::mem::replace(holder, row));
        if let Some(own) = self.column_of.get_mut(row) {
            *own = column;
        }
        if let Some(left) = self.column_of.get_mut(before) {
            *left = NOBODY;
        }
        before
    }

    /// Every column's price is its cheapest row's cost, and that row takes it if it has none yet.
    fn reduce_columns(&mut self) {
        let mut cheapest = vec![0; self.size];
        for (at, row) in self.costs.chunks_exact(self.size).enumerate() {
            for ((price, cheapest), cost) in self.prices.iter_mut().zip(&mut cheapest).zip(row) {
                if *cost < *price {
                    (*price, *cheapest) = (*cost, at);
                }
            }
        }
        for (column, row) in cheapest.into_iter().enumerate().rev() {
            if self.column_of.get(row) == Some(&NOBODY) {
                self.join(row, column);
            }
        }
    }

    /// Rows without column take their cheapest one and lower its price to where the second cheapest is as good, and a `step` more.
    /// Gives the rows that are left.
    fn bid(&mut self, free: Vec<usize>, step: f64) -> Vec<usize> {
        let mut bids = BIDS * free.len();
        let mut left = Vec::new();
        let mut waiting = free.into_iter();
        let mut next = waiting.next();
        while let Some(row) = next {
            let (first, second) = two_cheapest(self.row(row), &self.prices);
            let (mut column, gain) = (first.0, second.1 - first.1 + step);
            // Among equals one that nobody has.
            if gain <= 0.0 && self.row_of.get(column) != Some(&NOBODY) && second.0 != NOBODY {
                column = second.0;
            }
            if gain > 0.0
                && gain.is_finite()
                && let Some(price) = self.prices.get_mut(column)
            {
                *price -= gain;
            }
            let out = self.join(row, column);
            bids = bids.saturating_sub(1);
            next = if out == NOBODY {
                waiting.next()
            } else if gain > 0.0 && bids > 0 {
                Some(out)
            } else {
                left.push(out);
                waiting.next()
            };
        }
        left
    }

    /// The shortest path from a row without column to a column without row; all along it change partners.
    fn augment(&mut self, start: usize, search: &mut Search) {
        search.begin();
        search.enter(start, 0.0, &self.prices);
        let mut end = NOBODY;
        let mut reached = 0.0;
        while let Some((column, distance)) = search.take_nearest(&self.prices) {
            reached = distance;
            let row = self.row_of.get(column).copied().unwrap_or(NOBODY);
            if row == NOBODY {
                end = column;
                break;
            }
            let own = self.row(row).get(column).copied().unwrap_or(0.0) - self.price(column);
            search.enter(row, distance - own, &self.prices);
        }
        for &(column, distance) in &search.taken {
            if let Some(price) = self.prices.get_mut(column) {
                *price += distance - reached;
            }
        }
        search.settle(end);
        while end != NOBODY {
            let row = search.came_from(end);
            let before = self.column_of.get(row).copied().unwrap_or(NOBODY);
            if let (Some(holder), Some(own)) = (self.row_of.get_mut(end), self.column_of.get_mut(row)) {
                (*holder, *own) = (row, end);
            }
            end = if row == start { NOBODY } else { before };
        }
    }
}

/// The two columns with the least of cost minus price, each with it.
fn two_cheapest(costs: &[f64], prices: &[f64]) -> ((usize, f64), (usize, f64)) {
    let (mut first, mut second) = ((NOBODY, f64::INFINITY), (NOBODY, f64::INFINITY));
    for (column, (cost, price)) in costs.iter().zip(prices).enumerate() {
        let reduced = cost - price;
        if reduced < second.1 {
            if reduced < first.1 {
                second = first;
                first = (column, reduced);
            } else {
                second = (column, reduced);
            }
        }
    }
    (first, second)
}

/// The cheapest columns of a row.
struct Core {
    /// Each with its cost.
    columns: Vec<(usize, f64)>,
    /// Cost minus price of every other column is at least this.
    others: f64,
}

impl Core {
    /// The cheapest `wanted` columns at these prices.
    fn of(costs: &[f64], prices: &[f64], wanted: usize, scratch: &mut Vec<(f64, usize)>) -> Self {
        scratch.clear();
        scratch.extend(costs.iter().zip(prices).map(|(cost, price)| cost - price).zip(0..));
        let mut others = f64::INFINITY;
        if wanted < scratch.len() {
            let (_, next, _) = scratch.select_nth_unstable_by(wanted, |a, b| a.0.total_cmp(&b.0));
            others = next.0;
            scratch.truncate(wanted);
        }
        let cost = |column: usize| costs.get(column).copied().map(|cost| (column, cost));
        Self {
            columns: scratch.iter().filter_map(|(_, column)| cost(*column)).collect(),
            others,
        }
    }
}

/// A column as Dijkstra's search sees it.
#[derive(Clone, Copy)]
struct Reached {
    distance: f64,
    came_from: usize,
    taken: bool,
    /// Whether it has a row.
    what: What,
    /// In which search: what an earlier one left counts for nothing.
    search: usize,
}

/// What is next in a search: its distance (a whole number), what it is, and which of them.
type Next = (i64, What, usize);

/// Of things that are equally near the first here comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    /// A column without row: the search is over.
    Free,
    /// Another column.
    Taken,
    /// A row of which all columns are to be looked at.
    Row,
}

/// The searches for shortest paths, one after the other.
struct Search<'a> {
    costs: &'a [f64],
    size: usize,
    cores: Vec<Core>,
    columns: Vec<Reached>,
    taken: Vec<(usize, f64)>,
    queue: BinaryHeap<Reverse<Next>>,
    /// For each row the distance at which a column that costs nothing would be.
    entered: Vec<f64>,
    number: usize,
    scratch: Vec<(f64, usize)>,
}

impl<'a> Search<'a> {
    fn new(costs: &'a [f64], size: usize, prices: &[f64], row_of: &[usize]) -> Self {
        let mut scratch = Vec::with_capacity(size);
        let unknown = Reached {
            distance: f64::INFINITY,
            came_from: NOBODY,
            taken: false,
            what: What::Free,
            search: 0,
        };
        let known = |row: &usize| Reached {
            what: if *row == NOBODY { What::Free } else { What::Taken },
            ..unknown
        };
        Self {
            costs,
            size,
            cores: costs
                .chunks_exact(size)
                .map(|row| Core::of(row, prices, CORE, &mut scratch))
                .collect(),
            columns: row_of.iter().map(known).collect(),
            taken: Vec::with_capacity(size),
            queue: BinaryHeap::with_capacity(4 * size),
            entered: vec![0.0; size],
            number: 0,
            scratch,
        }
    }

    fn begin(&mut self) {
        self.number += 1;
        self.taken.clear();
        self.queue.clear();
    }

    /// The column has a row now; once it has one it always will.
    fn settle(&mut self, column: usize) {
        if let Some(reached) = self.columns.get_mut(column) {
            reached.what = What::Taken;
        }
    }

    fn came_from(&self, column: usize) -> usize {
        self.columns.get(column).map_or(NOBODY, |reached| reached.came_from)
    }

    /// Looks at the core of a row whose columns are as far away as they cost beyond `through`.
    fn enter(&mut self, row: usize, through: f64, prices: &[f64]) {
        let Some(core) = self.cores.get(row) else { return };
        if let Some(entered) = self.entered.get_mut(row) {
            *entered = through;
        }
        if core.others < f64::INFINITY {
            self.queue
                .push(Reverse(((through + core.others) as i64, What::Row, row)));
        }
        let columns = &core.columns;
        relax(
            &mut self.columns,
            &mut self.queue,
            self.number,
            row,
            columns
                .iter()
                .map(|(column, cost)| (*column, through + (cost - prices.get(*column).copied().unwrap_or(0.0)))),
        );
    }

    /// Looks at all columns of a row, and gives it a larger core for the next time.
    fn enter_fully(&mut self, row: usize, prices: &[f64]) {
        let through = self.entered.get(row).copied().unwrap_or(0.0);
        let costs = self
            .costs
            .get(row * self.size..(row + 1) * self.size)
            .unwrap_or_default();
        let distances = costs.iter().zip(prices).map(|(cost, price)| through + (cost - price));
        relax(
            &mut self.columns,
            &mut self.queue,
            self.number,
            row,
            distances.enumerate(),
        );
        if let Some(core) = self.cores.get_mut(row) {
            *core = Core::of(costs, prices, 2 * core.columns.len(), &mut self.scratch);
        }
    }

    fn take_nearest(&mut self, prices: &[f64]) -> Option<(usize, f64)> {
        while let Some(Reverse((distance, what, at))) = self.queue.pop() {
            if what == What::Row {
                self.enter_fully(at, prices);
                continue;
            }
            // Entries that were overtaken by shorter ones are still in the queue.
            let reached = self.columns.get_mut(at)?;
            if !reached.taken && reached.distance as i64 == distance {
                reached.taken = true;
                self.taken.push((at, reached.distance));
                return Some((at, reached.distance));
            }
        }
        None
    }
}

/// Shortens what is shorter from `row`.
fn relax(
    columns: &mut [Reached],
    queue: &mut BinaryHeap<Reverse<Next>>,
    search: usize,
    row: usize,
    distances: impl Iterator<Item = (usize, f64)>,
) {
    for (column, distance) in distances {
        let Some(reached) = columns.get_mut(column) else {
            continue;
        };
        if reached.search != search || (!reached.taken && distance < reached.distance) {
            *reached = Reached {
                distance,
                came_from: row,
                taken: false,
                search,
                ..*reached
            };
            queue.push(Reverse((distance as i64, reached.what, column)));
        }
    }
}

/// How many columns a core begins with.
const CORE: usize = 16;
