//! The watchdog: looks at every worker a few times per deadline and gives up threads whose call does not return.
//!
//! Must never do: wait for a worker, or for anything a plugin can hold; blame a call for time in which it could not run.

use crate::call_clock::LOOKS_PER_DEADLINE;
use crate::worker::WorkerShared;
use skein_realtime::Precedence;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;

/// The watchdog does not look more often than this, however short the deadline.
const SHORTEST_INTERVAL: Duration = Duration::from_millis(1);
/// Starts the watchdog over these workers. It ends when all of them are over.
pub(crate) fn watch(mut workers: Vec<Arc<WorkerShared>>, deadline: Duration) -> std::io::Result<()> {
    let interval = (deadline / LOOKS_PER_DEADLINE).max(SHORTEST_INTERVAL);
    let life = move || {
        skein_realtime::ask(Precedence::Control);
        while !workers.is_empty() {
            std::thread::sleep(interval);
            let now = Instant::now();
            workers.iter().for_each(|worker| worker.inspect(now));
            workers.retain(|worker| !worker.is_over());
        }
    };
    std::thread::Builder::new()
        .name("plugins-watch".to_owned())
        .spawn(life)
        .map(drop)
}
