//! Time between setpoints as each vehicle receives them.

use crate::report::Gaps;

/// Gaps of all vehicles over one window.
#[derive(Debug, Clone)]
pub(crate) struct GapLog {
    last_ns: Vec<Option<i64>>,
    gaps_us: Vec<Vec<u32>>,
}

impl GapLog {
    /// A log for so many vehicles.
    pub fn new(vehicles: usize) -> Self {
        Self {
            last_ns: vec![None; vehicles],
            gaps_us: vec![Vec::new(); vehicles],
        }
    }

    /// Begins a window: what was counted is forgotten, when the last setpoint came is not.
    pub fn begin(&mut self) {
        self.gaps_us.iter_mut().for_each(Vec::clear);
    }

    /// A setpoint of a vehicle, stamped when it was received.
    pub fn received(&mut self, vehicle: usize, stamp_ns: i64) {
        let (Some(last), Some(gaps)) = (self.last_ns.get_mut(vehicle), self.gaps_us.get_mut(vehicle)) else {
            return;
        };
        if let Some(before_ns) = last.replace(stamp_ns) {
            gaps.push(u32::try_from((stamp_ns - before_ns).max(0) / 1000).unwrap_or(u32::MAX));
        }
    }

    /// How many setpoints the window had.
    pub fn count(&self) -> usize {
        self.gaps_us.iter().map(Vec::len).sum()
    }

    /// How many vehicles got at least one.
    pub fn streaming(&self) -> usize {
        self.gaps_us.iter().filter(|gaps| !gaps.is_empty()).count()
    }

    /// The figures of the window. A vehicle that has been waiting at `now_ns` longer than its largest gap counts with that: a
    /// stream that stopped is a gap too.
    pub fn figures(&self, now_ns: i64) -> Gaps {
        let waiting_us = |vehicle: usize| {
            let last_ns = self.last_ns.get(vehicle).copied().flatten().unwrap_or(now_ns);
            u32::try_from((now_ns - last_ns).max(0) / 1000).unwrap_or(u32::MAX)
        };
        let per_vehicle: Vec<Vec<u32>> = self
            .gaps_us
            .iter()
            .enumerate()
            .map(|(vehicle, gaps)| {
                let mut all = gaps.clone();
                if gaps.iter().all(|gap| *gap < waiting_us(vehicle)) {
                    all.push(waiting_us(vehicle));
                }
                all.sort_unstable();
                all
            })
            .collect();
        let mut all: Vec<u32> = per_vehicle.concat();
        all.sort_unstable();
        let worst = |share: f64| {
            per_vehicle
                .iter()
                .map(|gaps| percentile_ms(gaps, share))
                .fold(0.0, f64::max)
        };
        Gaps {
            p50_ms: percentile_ms(&all, 0.5),
            p99_ms: percentile_ms(&all, 0.99),
            p99_9_ms: percentile_ms(&all, 0.999),
            max_ms: percentile_ms(&all, 1.0),
            over_60_ms: all.iter().filter(|gap| **gap > 60_000).count(),
            worst_vehicle_p99_ms: worst(0.99),
        }
    }
}

/// The value that the given share of a sorted list does not exceed (nearest rank); zero for none.
pub(crate) fn percentile_ms(sorted_us: &[u32], share: f64) -> f64 {
    let rank = (share * sorted_us.len() as f64).ceil() as usize;
    sorted_us
        .get(rank.saturating_sub(1))
        .map_or(0.0, |gap| f64::from(*gap) * 1e-3)
}

#[cfg(test)]
mod tests;
