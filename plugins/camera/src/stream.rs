//! H.264 that comes encoded, from a file or over a network, read on a thread of its own and given away picture by picture.
//!
//! Must never do: decode, or keep more than a few pictures.

mod file;
mod pipeline;
mod rtp;
mod rtsp;

pub(crate) use pipeline::words;
pub(crate) use rtp::{RtpPort, parameter_sets};

use crate::feed::{Ended, Feed};
use skein_plugin_sdk::log::Logger;
use std::net::SocketAddr;
use std::path::PathBuf;
use thiserror::Error;

/// So many pictures may wait. A network's newest ones are worth more than its oldest, but what is dropped here is missing for two seconds.
const QUEUE_LEN: usize = 32;

/// An encoded picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coded {
    /// An access unit in Annex B's byte stream.
    pub(crate) bytes: Vec<u8>,
    /// When it is to be given, in seconds since the stream began; none: at once.
    pub(crate) due_s: Option<f64>,
    /// How many before it are known to be missing.
    pub(crate) left_out: u64,
}

impl Coded {
    fn at_once(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            due_s: None,
            left_out: 0,
        }
    }
}

/// Where the stream comes from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Origin {
    /// A video file, again and again, at its own pace.
    File(PathBuf),
    /// A camera that is asked over RTSP.
    Rtsp(RtspCamera),
    /// RTP that somebody sends here.
    Rtp(RtpPort),
    /// A pipeline in GStreamer's launch syntax.
    Pipeline(String),
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
    #[error(transparent)]
    Pipeline(#[from] pipeline::PipelineFault),
    #[error("{listen} cannot be listened on: {reason}")]
    Port { listen: SocketAddr, reason: String },
    #[error("{listen} got no picture within {within_s} s: {lack}")]
    NoRtpPicture {
        listen: SocketAddr,
        within_s: u64,
        lack: rtp::Lack,
    },
    #[error(transparent)]
    Ended(#[from] Ended),
}

/// Where the reading thread puts what it reads.
type Outlet = crate::feed::Outlet<Coded, StreamFault>;

/// Reads a stream on its own thread.
#[derive(Debug)]
pub(crate) struct StreamReader {
    feed: Feed<Coded, StreamFault>,
    /// Taken from the queue, but not due yet.
    waiting: Option<Coded>,
}

impl StreamReader {
    pub(crate) fn start(origin: Origin) -> std::io::Result<Self> {
        let logger = Logger::current();
        let feed = Feed::start("skein-stream", QUEUE_LEN, move |outlet| match &origin {
            Origin::File(path) => file::read(path, outlet),
            Origin::Rtsp(camera) => rtsp::read(camera, outlet),
            Origin::Rtp(port) => rtp::read(port, logger.as_ref(), outlet),
            Origin::Pipeline(description) => pipeline::read(description, outlet),
        })?;
        Ok(Self { feed, waiting: None })
    }

    /// The next picture, if one is due `since_s` after the stream began.
    pub(crate) fn take(&mut self, since_s: f64) -> Result<Option<Coded>, StreamFault> {
        let next = match self.waiting.take() {
            Some(waiting) => Some(waiting),
            None => self.feed.take()?,
        };
        let is_early = |coded: &Coded| coded.due_s.is_some_and(|due_s| due_s > since_s);
        if next.as_ref().is_some_and(is_early) {
            self.waiting = next;
            return Ok(None);
        }
        Ok(next)
    }
}

#[cfg(test)]
mod tests;
