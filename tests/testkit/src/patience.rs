//! Waiting for something to come true, with one patience for all tests.
//!
//! Must never do: make a test slower than what it waits for, or hide for what it waited.

use std::time::Duration;
use tokio::time::{Instant, sleep};

/// How often a probe is made. Short beside what is waited for, long beside what a probe costs.
const PROBE_EVERY: Duration = Duration::from_millis(20);
/// How long a test waits for something that should be quick. Generous: only a failure ever takes so long.
const PATIENCE: Duration = Duration::from_secs(20);

/// How long a test waits for something that should be quick; `SKEIN_TEST_PATIENCE_S` changes it for slow machines.
///
/// For something that takes long by nature (a take-off, say), add its time: `patience() + Duration::from_secs(30)`.
#[must_use]
pub fn patience() -> Duration {
    let told = std::env::var("SKEIN_TEST_PATIENCE_S")
        .ok()
        .and_then(|text| text.parse().ok());
    told.map_or(PATIENCE, Duration::from_secs)
}

/// Probes until `probe` gives something, and returns it.
///
/// ```
/// # tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(async {
/// use skein_testkit::{eventually, patience};
/// let mut tries = 0;
/// let third = eventually(patience(), "the third try", async || {
///     tries += 1;
///     (tries == 3).then_some(tries)
/// })
/// .await;
/// assert_eq!(third, 3);
/// # });
/// ```
///
/// # Panics
/// If it gives nothing within `patience`; the message says what was waited for.
pub async fn eventually<T>(patience: Duration, what: &str, mut probe: impl AsyncFnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + patience;
    loop {
        if let Some(found) = probe().await {
            return found;
        }
        assert!(Instant::now() < deadline, "waited {patience:?} in vain for {what}");
        sleep(PROBE_EVERY).await;
    }
}

#[cfg(test)]
mod tests;
