//! How plugin instances came back after failures.

use super::criterion::{Criterion, counted};
use serde::Serialize;
use skein_config::Isolation;
use skein_view::{RestartRecord, Restored};

/// How plugin instances came back, in one isolation.
#[derive(Debug, Serialize)]
pub struct PluginRestarts {
    /// Where they run.
    pub isolation: Isolation,
    /// How many restarts.
    pub count: usize,
    /// Half of them took no longer, in milliseconds, from the failure until the state was back; a deliberate wait not counted.
    pub p50_ms: f64,
    /// All but one in a hundred took no longer, in milliseconds.
    pub p99_ms: f64,
    /// The longest, in milliseconds.
    pub max_ms: f64,
    /// What p99 should not exceed, in milliseconds.
    pub p99_target_ms: f64,
    /// After so many the state was the former one, byte for byte.
    pub restored_exactly: usize,
    /// After so many there was no state yet to restore.
    pub without_state: usize,
    /// After so many it was another.
    pub restored_differently: usize,
    /// So many waited on purpose before, since they had failed in quick succession.
    pub backed_off: usize,
}

/// The restarts of one isolation.
pub fn plugin_restarts(restarts: &[RestartRecord], isolation: Isolation, p99_target_ms: f64) -> PluginRestarts {
    let of: Vec<&RestartRecord> = restarts.iter().filter(|r| r.isolation == isolation).collect();
    let mut took_ms: Vec<f64> = of.iter().map(|r| r.took_s * 1e3).collect();
    took_ms.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let rank = (took_ms.len() as f64 * share).ceil().max(1.0) as usize;
        took_ms.get(rank - 1).copied().unwrap_or(0.0)
    };
    let restored = |how: Restored| of.iter().filter(|r| r.restored == how).count();
    PluginRestarts {
        isolation,
        count: of.len(),
        p50_ms: quantile(0.5),
        p99_ms: quantile(0.99),
        max_ms: quantile(1.0),
        p99_target_ms,
        restored_exactly: restored(Restored::Exactly),
        without_state: restored(Restored::Fresh),
        restored_differently: restored(Restored::Differently),
        backed_off: of.iter().filter(|r| r.backoff_s > 0.0).count(),
    }
}

/// What must be the case when plugins were ended during the whole flight.
pub fn restart_criteria(restarts: &[RestartRecord], faults: u64) -> Vec<Criterion> {
    let wrong = restarts.iter().filter(|r| r.restored == Restored::Differently).count();
    // An end that comes while the same plugin is still away finds nothing to end.
    let least = faults as f64 * 0.9;
    vec![
        counted("restarts with another state than before", wrong).at_most(0.0, ""),
        counted("plugins that came back", restarts.len()).at_least(least.floor(), ""),
    ]
}
