//! A thread of the plugin's own that reads, and the few things it has read that wait to be taken.
//!
//! Must never do: block whoever takes or drops it for long, or let more wait than it was told.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;
use thiserror::Error;

/// How long the end of the thread is waited for. It looks now and then whether it is to end.
const END_WAIT: Duration = Duration::from_millis(250);

/// The thread has ended, and everything that it read is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the source has ended")]
pub(crate) struct Ended;

/// What a thread reads, from the side of whoever takes it.
#[derive(Debug)]
pub(crate) struct Feed<T, E> {
    items: Option<Receiver<Result<T, E>>>,
    ended: Receiver<()>,
    stop: Arc<AtomicBool>,
}

/// Where the thread puts what it reads.
pub(crate) struct Outlet<T, E> {
    items: SyncSender<Result<T, E>>,
    stop: Arc<AtomicBool>,
}

impl<T, E> Outlet<T, E> {
    /// Waits for room. False when nobody wants more.
    pub(crate) fn give(&self, item: Result<T, E>) -> bool {
        self.items.send(item).is_ok() && self.is_wanted()
    }

    pub(crate) fn is_wanted(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

impl<T: Send + 'static, E: Send + From<Ended> + 'static> Feed<T, E> {
    /// Begins to read; `most_waiting` may wait to be taken. An error that `read` returns is the last thing that is taken.
    pub(crate) fn start(
        thread_name: &str,
        most_waiting: usize,
        read: impl FnOnce(&Outlet<T, E>) -> Result<(), E> + Send + 'static,
    ) -> std::io::Result<Self> {
        let (give, items) = sync_channel(most_waiting);
        let (end, ended) = sync_channel(0);
        let stop = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            items: give,
            stop: stop.clone(),
        };
        std::thread::Builder::new()
            .name(thread_name.to_owned())
            .spawn(move || {
                if let Err(error) = read(&outlet) {
                    outlet.give(Err(error));
                }
                drop(outlet);
                // Its disconnection is the message.
                drop(end);
            })?;
        Ok(Self {
            items: Some(items),
            ended,
            stop,
        })
    }

    /// The next thing, if it is there.
    pub(crate) fn take(&mut self) -> Result<Option<T>, E> {
        match self.items.as_ref().map(Receiver::try_recv) {
            Some(Ok(item)) => item.map(Some),
            Some(Err(TryRecvError::Empty)) => Ok(None),
            Some(Err(TryRecvError::Disconnected)) | None => Err(Ended.into()),
        }
    }
}

impl<T, E> Drop for Feed<T, E> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // A thread that waits for room wakes by this.
        self.items = None;
        // Nobody sends here: it ends with the thread, or with patience.
        let _ = self.ended.recv_timeout(END_WAIT);
    }
}

#[cfg(test)]
mod tests;
