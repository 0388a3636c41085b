//! Recorded flights that are looked at beside the node that flies: those that are open, each with its router.
//!
//! Must never do: keep one open that nobody looks at, or more than [`MOST`].

use crate::error::ApiError;
use axum::Router;
use parking_lot::Mutex;
use skein_replay::Replay;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// So many are open at once: each has a thread, and reads a file.
const MOST: usize = 4;
/// One that nobody looks at is closed after so long.
const IDLE: Duration = Duration::from_secs(600);

/// One that is served.
pub struct Served {
    /// Its routes.
    pub router: Router,
    /// Whether somebody looks at it.
    pub is_looked_at: Box<dyn Fn() -> bool + Send>,
}

/// Serves one.
type Serve = Box<dyn Fn(Arc<Replay>) -> Served + Send + Sync>;

/// Those that are open.
pub struct OpenReplays {
    serve: Serve,
    open: Mutex<Vec<Open>>,
}

struct Open {
    file: String,
    served: Served,
    /// It was whole when it was opened.
    finished: bool,
    asked: Instant,
}

impl OpenReplays {
    /// None yet.
    pub fn new(serve: impl Fn(Arc<Replay>) -> Served + Send + Sync + 'static) -> Self {
        Self {
            serve: Box::new(serve),
            open: Mutex::default(),
        }
    }

    /// The router of one, if it is open.
    pub fn router(&self, file: &str) -> Option<Router> {
        let mut open = self.open.lock();
        let one = open.iter_mut().find(|one| one.file == file)?;
        one.asked = Instant::now();
        Some(one.served.router.clone())
    }

    /// One that was still being written when it was opened has grown since: whoever opens its page sees it anew, unless others look at it.
    pub fn forget_unfinished(&self, file: &str) {
        let mut open = self.open.lock();
        open.retain(|one| one.file != file || one.finished || (one.served.is_looked_at)());
    }

    /// Adds one; another one that nobody looks at goes for it.
    ///
    /// # Errors
    /// When somebody looks at each of those that are open.
    pub fn add(&self, file: String, replay: Replay) -> Result<Router, ApiError> {
        let mut open = self.open.lock();
        open.retain(|one| (one.served.is_looked_at)() || one.asked.elapsed() < IDLE);
        if let Some(one) = open.iter().find(|one| one.file == file) {
            return Ok(one.served.router.clone());
        }
        if open.len() >= MOST {
            let idle = open.iter().enumerate().filter(|(_, one)| !(one.served.is_looked_at)());
            let oldest = idle.min_by_key(|(_, one)| one.asked).map(|(index, _)| index);
            open.remove(oldest.ok_or(ApiError::TooManyReplays { limit: MOST })?);
        }
        let finished = replay.state().finished;
        let served = (self.serve)(Arc::new(replay));
        let router = served.router.clone();
        open.push(Open {
            file,
            served,
            finished,
            asked: Instant::now(),
        });
        Ok(router)
    }
}
