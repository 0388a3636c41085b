//! The watchdog: looks at every lane a few times per deadline and gives up threads whose call does not return.
//!
//! Must never do: wait for a lane, or for anything a plugin can hold.

use crate::lane::LaneShared;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;

/// How many times a call is seen before it can be given up: with a look every quarter of a deadline, one that lasts a whole one.
pub(crate) const LOOKS_PER_DEADLINE: u32 = 4;
/// However starved its thread was, a call is given up after so many deadlines.
const LONGEST_GRACE: u32 = 20;
/// The watchdog does not look more often than this, however short the deadline.
const SHORTEST_INTERVAL: Duration = Duration::from_millis(1);

/// Whether a call that began this long ago is over its deadline. Time in which its thread was ready and could not run is not its fault.
pub(crate) fn is_too_late(after: Duration, starved: Duration, deadline: Duration) -> bool {
    after.saturating_sub(starved) >= deadline || after >= deadline.saturating_mul(LONGEST_GRACE)
}

/// Starts the watchdog over these lanes. It ends when all of them are over.
pub(crate) fn watch(mut lanes: Vec<Arc<LaneShared>>, deadline: Duration) -> std::io::Result<()> {
    let interval = (deadline / LOOKS_PER_DEADLINE).max(SHORTEST_INTERVAL);
    let life = move || {
        while !lanes.is_empty() {
            std::thread::sleep(interval);
            let now = Instant::now();
            lanes.iter().for_each(|lane| lane.inspect(now, LOOKS_PER_DEADLINE));
            lanes.retain(|lane| !lane.is_over());
        }
    };
    std::thread::Builder::new()
        .name("plugins-watch".to_owned())
        .spawn(life)
        .map(drop)
}
