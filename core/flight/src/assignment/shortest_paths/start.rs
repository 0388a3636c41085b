//! Prices to begin with: those of every fourth vehicle and slot, found in the same way, carried over to all others.
//!
//! A slot's price is what the best of the vehicles looked at would still pay for it. Where the places lie in some order, as those of
//! a formation do, this is near where prices end. Must never matter for the result: any whole numbers lead to it.

use super::problem::{Problem, Scale};
use super::{Solver, smaller};
use crate::assignment::Costs;

/// One of so many is looked at.
const ONE_OF: usize = 4;
/// So few are not thinned out any more.
const FEW: usize = 24;

/// A price of every column.
pub(super) fn prices(costs: &Costs, scale: &Scale) -> Vec<f64> {
    let all: Vec<usize> = (0..scale.size).collect();
    from_fewer(costs, scale, &all, &all)
}

fn from_fewer(costs: &Costs, scale: &Scale, rows: &[usize], columns: &[usize]) -> Vec<f64> {
    let problem = Problem::few(costs, scale, rows, columns);
    let mut cost = Vec::with_capacity(columns.len());
    if rows.len() <= FEW {
        let mut prices = vec![f64::INFINITY; columns.len()];
        for row in 0..rows.len() {
            problem.row(row, &mut cost);
            lower(&mut prices, &cost, 0.0);
        }
        return prices;
    }
    let (few_rows, few_columns) = (fewer(rows, 1), fewer(columns, 2));
    let start = from_fewer(costs, scale, &few_rows, &few_columns);
    let mut solver = Solver::new(Problem::few(costs, scale, &few_rows, &few_columns), start);
    solver.bid_in_steps();
    let mut prices = vec![f64::INFINITY; columns.len()];
    let carry = Problem::few(costs, scale, &few_rows, columns);
    for at in 0..few_rows.len() {
        let pays = solver.cores.two_cheapest(at, &solver.prices).first.1;
        carry.row(at, &mut cost);
        lower(&mut prices, &cost, pays);
    }
    prices
}

fn lower(prices: &mut [f64], costs: &[f64], pays: f64) {
    for (price, cost) in prices.iter_mut().zip(costs) {
        *price = smaller(*price, cost - pays);
    }
}

/// One of every few, not always the same one: rows of a grid would else be seen at one end only.
fn fewer(all: &[usize], salt: usize) -> Vec<usize> {
    let one = |(number, group): (usize, &[usize])| {
        let mixed = (number + salt).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 61;
        group.get(mixed % group.len().max(1)).copied()
    };
    all.chunks(ONE_OF).enumerate().filter_map(one).collect()
}
