//! Searches for shortest paths (Dijkstra), one after the other, over the cores of rows. Must never change prices or partners.

use super::cores::Cores;
use super::{NOBODY, price};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A column as the search sees it.
#[derive(Clone, Copy)]
struct Reached {
    distance: f64,
    came_from: usize,
    taken: bool,
    /// Whether it has a row.
    free: bool,
    /// In which search: what an earlier one left counts for nothing.
    search: usize,
}

/// What is next in a search: its distance (a whole number), what it is, and which of them.
type Next = (i64, What, usize);

/// Of things that are equally near the first here comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    /// A column.
    Column,
    /// A row of which more columns are to be looked at.
    Row,
}

/// All searches of one solution.
pub(super) struct Search {
    columns: Vec<Reached>,
    pub taken: Vec<(usize, f64)>,
    queue: BinaryHeap<Reverse<Next>>,
    /// Columns as near as the search has come: they need no queue, and many are equally near in regular formations.
    here: Vec<usize>,
    /// A column without row as near as that: the search is over.
    end: usize,
    nearest: f64,
    /// For each row the distance at which a column that costs nothing would be.
    entered: Vec<f64>,
    number: usize,
}

impl Search {
    pub fn new(row_of: &[usize]) -> Self {
        let size = row_of.len();
        let unknown = |row: &usize| Reached {
            distance: f64::INFINITY,
            came_from: NOBODY,
            taken: false,
            free: *row == NOBODY,
            search: 0,
        };
        Self {
            columns: row_of.iter().map(unknown).collect(),
            taken: Vec::with_capacity(size),
            queue: BinaryHeap::with_capacity(4 * size),
            here: Vec::with_capacity(size),
            end: NOBODY,
            nearest: f64::NEG_INFINITY,
            entered: vec![0.0; size],
            number: 0,
        }
    }

    pub fn begin(&mut self) {
        self.number += 1;
        self.taken.clear();
        self.queue.clear();
        self.here.clear();
        self.end = NOBODY;
        self.nearest = f64::NEG_INFINITY;
    }

    /// The column has a row now; once it has one it always will.
    pub fn settle(&mut self, column: usize) {
        if let Some(reached) = self.columns.get_mut(column) {
            reached.free = false;
        }
    }

    pub fn came_from(&self, column: usize) -> usize {
        self.columns.get(column).map_or(NOBODY, |reached| reached.came_from)
    }

    /// Looks at the core of a row whose columns are as far away as they cost beyond `through`.
    pub fn enter(&mut self, row: usize, through: f64, cores: &Cores, prices: &[f64]) {
        let Some(core) = cores.of(row) else { return };
        if let Some(entered) = self.entered.get_mut(row) {
            *entered = through;
        }
        if core.others < f64::INFINITY {
            self.queue
                .push(Reverse(((through + core.others) as i64, What::Row, row)));
        }
        for (column, cost) in &core.columns {
            let distance = through + (cost - price(prices, *column));
            self.shorten(*column, distance, row);
        }
    }

    /// The nearest column that was not taken yet, with its distance.
    pub fn take_nearest(&mut self, cores: &mut Cores, prices: &[f64]) -> Option<(usize, f64)> {
        loop {
            if self.end != NOBODY {
                return Some((self.end, self.nearest));
            }
            if let Some(column) = self.here.pop() {
                if let Some(taken) = self.take(column) {
                    return Some(taken);
                }
                continue;
            }
            let Reverse((distance, what, at)) = self.queue.pop()?;
            if what == What::Row {
                cores.widen(at, prices);
                let through = self.entered.get(at).copied().unwrap_or(0.0);
                self.enter(at, through, cores, prices);
                continue;
            }
            // Entries that were overtaken by shorter ones are still in the queue.
            let current = self.columns.get(at).is_some_and(|r| r.distance as i64 == distance);
            if current && let Some(taken) = self.take(at) {
                self.nearest = taken.1;
                return Some(taken);
            }
        }
    }

    fn take(&mut self, column: usize) -> Option<(usize, f64)> {
        let reached = self.columns.get_mut(column).filter(|reached| !reached.taken)?;
        reached.taken = true;
        self.taken.push((column, reached.distance));
        Some((column, reached.distance))
    }

    fn shorten(&mut self, column: usize, distance: f64, row: usize) {
        let Some(reached) = self.columns.get_mut(column) else {
            return;
        };
        if reached.search == self.number && (reached.taken || distance >= reached.distance) {
            return;
        }
        *reached = Reached {
            distance,
            came_from: row,
            taken: false,
            search: self.number,
            ..*reached
        };
        if distance > self.nearest {
            self.queue.push(Reverse((distance as i64, What::Column, column)));
        } else if reached.free {
            self.end = column;
        } else {
            self.here.push(column);
        }
    }
}
