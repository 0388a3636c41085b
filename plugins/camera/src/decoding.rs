//! Pictures from files, decoded on a thread of their own and handed over one by one.
//!
//! Must never do: block whoever takes a picture or drops the reader for long, or decode further ahead than a few pictures.

mod stills;
mod video;

pub(crate) use video::Video;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::Duration;
use thiserror::Error;

/// How many pictures may wait: one to give, one in the making.
const QUEUE_LEN: usize = 2;
/// How long the end of the thread is waited for. It looks once per picture whether it is to end.
const END_WAIT: Duration = Duration::from_millis(250);
/// Larger pictures are not believed, in pixels.
const MOST_PIXELS: u64 = 64 << 20;

/// A picture, three bytes per pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    pub(crate) rgb: Vec<u8>,
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum DecodeError {
    #[error("{} cannot be read: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    #[error("there is no picture in {}", path.display())]
    Empty { path: PathBuf },
    #[error("{} is no H.264 video in an MP4 file", path.display())]
    NoVideo { path: PathBuf },
    #[error("{} is damaged: {reason}", path.display())]
    Damaged { path: PathBuf, reason: String },
    #[error("the decoder ended")]
    Ended,
}

/// What is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Files {
    /// The pictures of a folder.
    Stills(PathBuf),
    /// A video, `rate_hz` pictures for each second of it.
    Video { path: PathBuf, rate_hz: f64 },
}

/// Reads pictures on its own thread.
#[derive(Debug)]
pub(crate) struct Reader {
    pictures: Option<Receiver<Result<Picture, DecodeError>>>,
    ended: Receiver<()>,
    stop: Arc<AtomicBool>,
}

/// Where a reading thread puts its pictures.
struct Outlet {
    pictures: SyncSender<Result<Picture, DecodeError>>,
    stop: Arc<AtomicBool>,
}

impl Outlet {
    /// Waits for room. False when nobody wants more.
    fn give(&self, picture: Result<Picture, DecodeError>) -> bool {
        self.pictures.send(picture).is_ok() && self.is_wanted()
    }

    fn is_wanted(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

impl Reader {
    /// Begins after as many pictures as were taken before.
    pub(crate) fn start(files: Files, taken: u64) -> std::io::Result<Self> {
        let (give, pictures) = sync_channel(QUEUE_LEN);
        let (end, ended) = sync_channel(0);
        let stop = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            pictures: give,
            stop: stop.clone(),
        };
        std::thread::Builder::new()
            .name("skein-decode".to_owned())
            .spawn(move || {
                let outcome = match &files {
                    Files::Stills(folder) => stills::read(folder, taken, &outlet),
                    Files::Video { path, rate_hz } => video::read(path, *rate_hz, taken, &outlet),
                };
                if let Err(error) = outcome {
                    outlet.give(Err(error));
                }
                drop(outlet);
                // Its disconnection is the message.
                drop(end);
            })?;
        Ok(Self {
            pictures: Some(pictures),
            ended,
            stop,
        })
    }

    /// The next picture, if it is ready.
    pub(crate) fn take(&mut self) -> Result<Option<Picture>, DecodeError> {
        let Some(pictures) = &self.pictures else {
            return Err(DecodeError::Ended);
        };
        match pictures.try_recv() {
            Ok(Ok(picture)) => Ok(Some(picture)),
            Ok(Err(error)) => Err(error),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(DecodeError::Ended),
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // A thread that waits for room wakes by this.
        self.pictures = None;
        // Nobody sends here: it ends with the thread, or with patience.
        let _ = self.ended.recv_timeout(END_WAIT);
    }
}

#[cfg(test)]
mod tests;
