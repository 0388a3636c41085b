//! Who belongs to whom, so that all costs together are least.

use pathfinding::prelude::{Matrix, kuhn_munkres_min};

/// Costs are compared in steps of this.
const STEP: f64 = 1e-3;

/// Pairs of rows and columns with the least sum of costs. `None` is a pair that cannot be; to leave a row without a column costs `alone`.
///
/// Rows that stay alone are not in the answer.
pub(crate) fn assign(
    rows: usize,
    columns: usize,
    alone: f64,
    cost: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<(usize, usize)> {
    if rows == 0 || columns == 0 {
        return Vec::new();
    }
    let whole = |cost: f64| (cost / STEP).clamp(-1e12, 1e12) as i64;
    let cost = |row: usize, column: usize| cost(row, column).filter(|cost| cost.is_finite() && *cost < alone);
    // A place of its own for each row that stays alone.
    let costs = Matrix::from_fn(rows, columns + rows, |(row, column)| {
        let wanted = if column < columns {
            cost(row, column)
        } else {
            Some(alone)
        };
        whole(wanted.unwrap_or(1e6 + alone))
    });
    let (_, columns_of) = kuhn_munkres_min(&costs);
    let pairs = columns_of.into_iter().enumerate();
    pairs
        .filter(|(row, column)| *column < columns && cost(*row, *column).is_some())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_least_and_who_does_not_fit_stays_alone() {
        let costs = [[1.0, 2.0], [1.5, 9.0], [30.0, 30.0]];
        let mut pairs = assign(3, 2, 10.0, |row, column| Some(costs[row][column]));
        pairs.sort_unstable();
        assert_eq!(pairs, [(0, 1), (1, 0)]);
        assert_eq!(assign(2, 1, 1.0, |_, _| Some(f64::NAN)), []);
        assert_eq!(assign(0, 3, 1.0, |_, _| Some(0.0)), []);
    }
}
