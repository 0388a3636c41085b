//! The least total: the method of Jonker and Volgenant (*A shortest augmenting path algorithm for dense and sparse linear assignment
//! problems*, Computing 38, 1987): prices of slots, vehicles bidding for their cheapest slot (augmenting row reduction), and shortest
//! augmenting paths (Dijkstra) for those that are left.
//!
//! Prices to begin with are those of a few of the vehicles and slots, and bids in ever finer steps bring them near where they end.
//! Of each row only its cheapest columns are looked at, the `cores`. None of this changes the result, which is the exact one.
//!
//! All numbers are whole (as floating point, which holds them exactly), so that it always ends.

mod cores;
mod problem;
mod search;
mod start;

use super::{Costs, Total};
use cores::{Cheapest, Cores};
use problem::{Problem, Scale};
use search::Search;

/// No partner.
const NOBODY: usize = usize::MAX;
/// Sums of costs stay below this, where floating point still holds every whole number.
const LARGEST_SUM: f64 = (1_u64 << 52) as f64;
/// No cost is told apart more finely than this share of the largest.
const FINEST: f64 = (1_u64 << 32) as f64;
/// The share of rows left by the first bids, as one over it, from which on bids in steps pay.
const MANY_LEFT: usize = 8;
/// Steps of bids (Bertsekas, *The auction algorithm*, Annals of Operations Research 14, 1988): how many, and how much finer each is
/// than the one before.
const STEPS: usize = 4;
const FINER: f64 = 8.0;
/// The first step, in how much dearer than the cheapest the other columns of a core are; and its limit, in the dearest.
const FIRST_STEP: f64 = 0.5;
const LARGEST_STEP: f64 = 1.0 / 16.0;
/// Bids per vehicle in each step.
const BIDS_IN_STEPS: usize = 80;
/// The same without a step, before the rest is left to shortest paths.
const BIDS: usize = 6;

/// Each vehicle's slot: as many as possible of the ways not longer than `longest`, the least total of those.
pub(super) fn solve(costs: &Costs, total: Total, longest: f64) -> Vec<Option<usize>> {
    if costs.vehicles == 0 || costs.slots == 0 {
        return vec![None; costs.vehicles];
    }
    let scale = Scale::of(costs, total, longest);
    let prices = start::prices(costs, &scale);
    let chosen = Solver::new(Problem::whole(costs, &scale), prices).solve();
    let allowed = |length: f64| length <= scale.longest;
    let slot = |(vehicle, slot): (usize, usize)| allowed(costs.length(vehicle, slot)).then_some(slot);
    chosen.into_iter().take(costs.vehicles).enumerate().map(slot).collect()
}

/// As `f64::min` but for numbers that are none, which makes it one instruction.
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// As `f64::max` but for numbers that are none.
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn price(prices: &[f64], column: usize) -> f64 {
    prices.get(column).copied().unwrap_or(0.0)
}

/// The state of one solution: rows are vehicles, columns slots.
struct Solver<'a> {
    problem: Problem<'a>,
    prices: Vec<f64>,
    column_of: Vec<usize>,
    row_of: Vec<usize>,
    cores: Cores<'a>,
}

impl<'a> Solver<'a> {
    fn new(problem: Problem<'a>, prices: Vec<f64>) -> Self {
        let size = problem.size();
        Self {
            cores: Cores::new(problem.clone(), &prices),
            problem,
            prices,
            column_of: vec![NOBODY; size],
            row_of: vec![NOBODY; size],
        }
    }

    fn solve(mut self) -> Vec<usize> {
        let left = self.bid_in_steps();
        if !left.is_empty() {
            let mut search = Search::new(&self.row_of);
            for row in left {
                self.augment(row, &mut search);
            }
        }
        self.column_of
    }

    /// Rows fight for columns, in ever finer steps, until prices are near where they end. Gives the rows that are left.
    fn bid_in_steps(&mut self) -> Vec<usize> {
        let size = self.row_of.len();
        let mut step = smaller(
            FIRST_STEP * self.cores.spread(&self.prices),
            LARGEST_STEP * self.problem.scale.finest,
        );
        let mut left = self.bid_twice();
        if left.len() > size / MANY_LEFT {
            for _ in 0..STEPS {
                self.part_all();
                self.bid((0..size).collect(), step.ceil(), BIDS_IN_STEPS);
                step /= FINER;
            }
            self.part_all();
            left = self.bid_twice();
        }
        left
    }

    fn part_all(&mut self) {
        self.column_of.fill(NOBODY);
        self.row_of.fill(NOBODY);
    }

    fn bid_twice(&mut self) -> Vec<usize> {
        let left = self.bid((0..self.row_of.len()).collect(), 0.0, BIDS);
        self.bid(left, 0.0, BIDS)
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

    /// Rows without column take their cheapest one and lower its price to where the second cheapest is as good, and a `step` more.
    /// Gives the rows that are left.
    fn bid(&mut self, free: Vec<usize>, step: f64, bids_each: usize) -> Vec<usize> {
        let mut bids = bids_each * free.len();
        let mut left = Vec::new();
        let mut waiting = free.into_iter();
        let mut next = waiting.next();
        while let Some(row) = next {
            let Cheapest { first, second } = self.cores.two_cheapest(row, &self.prices);
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
        search.enter(start, 0.0, &self.cores, &self.prices);
        let mut end = NOBODY;
        let mut reached = 0.0;
        while let Some((column, distance)) = search.take_nearest(&mut self.cores, &self.prices) {
            reached = distance;
            let row = self.row_of.get(column).copied().unwrap_or(NOBODY);
            if row == NOBODY {
                end = column;
                break;
            }
            let own = self.problem.cost(row, column) - price(&self.prices, column);
            search.enter(row, distance - own, &self.cores, &self.prices);
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
