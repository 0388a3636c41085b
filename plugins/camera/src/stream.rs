//! H.264 that comes encoded, from a file or over a network, read on a thread of its own and given away picture by picture.
//!
//! Must never do: decode, block whoever takes a picture, or keep more than a few of them.

mod file;
mod rtsp;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;
use thiserror::Error;

/// So many pictures may wait. A network's newest ones are worth more than its oldest, but what is dropped here is missing for two seconds.
const QUEUE_LEN: usize = 32;
/// How long the end of the thread is waited for.
const END_WAIT: Duration = Duration::from_millis(250);

/// An encoded picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coded {
    /// An access unit in Annex B's byte stream.
    pub(crate) bytes: Vec<u8>,
    /// When it is to be given, in seconds since the stream began; none: at once.
    pub(crate) due_s: Option<f64>,
}

/// Where the stream comes from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Origin {
    /// A video file, again and again, at its own pace.
    File(PathBuf),
    /// A camera that is asked over RTSP.
    Rtsp(RtspCamera),
}

/// A camera that is asked over RTSP.
#[derive(Clone, PartialEq)]
pub(crate) struct RtspCamera {
    /// `rtsp://HOST[:PORT]/PATH`.
    pub(crate) url: String,
    /// Empty: it is not asked for.
    pub(crate) user: String,
    pub(crate) password: String,
}

impl std::fmt::Debug for RtspCamera {
    /// Without the password: settings find their way into logs.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} as {:?}", self.url, self.user)
    }
}

/// Why there is no stream.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum StreamFault {
    #[error("{0}")]
    File(#[from] crate::decoding::DecodeError),
    #[error("{url} is no address of a camera: {reason}")]
    Address { url: String, reason: String },
    #[error("{url} did not {what} within {within_s} s")]
    Silent {
        url: String,
        what: &'static str,
        within_s: u64,
    },
    #[error("{url}: {reason}")]
    Rtsp { url: String, reason: String },
    #[error("{url} has no H.264 video; it has {has}")]
    NoH264 { url: String, has: String },
    #[error("the stream has ended")]
    Ended,
}

/// Reads a stream on its own thread.
#[derive(Debug)]
pub(crate) struct StreamReader {
    coded: Option<Receiver<Result<Coded, StreamFault>>>,
    ended: Receiver<()>,
    stop: Arc<AtomicBool>,
    /// Taken from the queue, but not due yet.
    waiting: Option<Coded>,
}

/// Where the reading thread puts what it reads.
struct Outlet {
    coded: SyncSender<Result<Coded, StreamFault>>,
    stop: Arc<AtomicBool>,
}

impl Outlet {
    /// Waits for room. False when nobody wants more.
    fn give(&self, coded: Result<Coded, StreamFault>) -> bool {
        self.coded.send(coded).is_ok() && self.is_wanted()
    }

    fn is_wanted(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

impl StreamReader {
    pub(crate) fn start(origin: Origin) -> std::io::Result<Self> {
        let (give, coded) = sync_channel(QUEUE_LEN);
        let (end, ended) = sync_channel(0);
        let stop = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            coded: give,
            stop: stop.clone(),
        };
        std::thread::Builder::new()
            .name("skein-stream".to_owned())
            .spawn(move || {
                let outcome = match &origin {
                    Origin::File(path) => file::read(path, &outlet),
                    Origin::Rtsp(camera) => rtsp::read(camera, &outlet),
                };
                if let Err(fault) = outcome {
                    outlet.give(Err(fault));
                }
                drop(outlet);
                // Its disconnection is the message.
                drop(end);
            })?;
        Ok(Self {
            coded: Some(coded),
            ended,
            stop,
            waiting: None,
        })
    }

    /// The next picture, if one is due `since_s` after the stream began.
    pub(crate) fn take(&mut self, since_s: f64) -> Result<Option<Coded>, StreamFault> {
        let next = match self.waiting.take() {
            Some(waiting) => waiting,
            None => match self.coded.as_ref().map(Receiver::try_recv) {
                Some(Ok(coded)) => coded?,
                Some(Err(TryRecvError::Empty)) => return Ok(None),
                Some(Err(TryRecvError::Disconnected)) | None => return Err(StreamFault::Ended),
            },
        };
        if next.due_s.is_some_and(|due_s| due_s > since_s) {
            self.waiting = Some(next);
            return Ok(None);
        }
        Ok(Some(next))
    }
}

impl Drop for StreamReader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // A thread that waits for room wakes by this.
        self.coded = None;
        // Nobody sends here: it ends with the thread, or with patience.
        let _ = self.ended.recv_timeout(END_WAIT);
    }
}

#[cfg(test)]
mod tests;
