//! Log lines of an instance in a child, on a socket of their own: one message a line, the level before the text.
//!
//! Must never do: wait. A child whose lines nobody fetches loses them.

use crate::sink::TakeLog;
use rustix::net::{RecvFlags, SendFlags};
use skein_plugin_abi::LogLevel;
use std::os::fd::{AsFd, OwnedFd};

/// A line is cut at this length in bytes.
const MAX_LINE_BYTES: usize = 2_000;
/// So many lines are fetched at once.
const MAX_LINES_AT_ONCE: usize = 256;

/// The child's end.
#[derive(Debug)]
pub(crate) struct LogSocket(pub(crate) OwnedFd);

impl TakeLog for LogSocket {
    fn take(&self, level: LogLevel, text: &[u8]) {
        let text = text.get(..MAX_LINE_BYTES).unwrap_or(text);
        let mut line = Vec::with_capacity(4 + text.len());
        line.extend_from_slice(&level.0.to_ne_bytes());
        line.extend_from_slice(text);
        // Full, or nobody is there any more.
        let _ = rustix::net::send(&self.0, &line, SendFlags::DONTWAIT | SendFlags::NOSIGNAL);
    }
}

/// Fetches the lines that are there.
pub(crate) fn fetch(socket: impl AsFd, sink: &impl TakeLog) {
    let mut line = [0; 4 + MAX_LINE_BYTES];
    for _ in 0..MAX_LINES_AT_ONCE {
        let Ok((_, len @ 1..)) = rustix::net::recv(socket.as_fd(), &mut line[..], RecvFlags::DONTWAIT) else {
            return;
        };
        let line = line.get(..len).unwrap_or(&line);
        if let Some((level, text)) = line.split_first_chunk() {
            sink.take(LogLevel(u32::from_ne_bytes(*level)), text);
        }
    }
}
