//! Frames without copies: buffers the host lends to be written into, and frames of others to be read during a call.
//!
//! Must never do: let a buffer be written after it was given away, or a frame be read after the call it came with.

use crate::host::Host;
use skein_domain::payload::FrameHeader;
use skein_plugin_abi::FrameBuffer;
use std::ops::{Deref, DerefMut};

/// A buffer lent by the host. Give it away with [`crate::Effects::frame`]; dropped, it goes back unused.
#[derive(Debug)]
pub struct FrameMut {
    buffer: FrameBuffer,
    len: usize,
    host: Host,
}

// SAFETY: the host lends a buffer to one owner, who may be on any thread.
unsafe impl Send for FrameMut {}

impl FrameMut {
    /// Gives up the buffer without giving it back: the host knows of it by its id.
    pub(crate) fn into_id(self) -> (u64, u64) {
        let named = (self.buffer.id, self.len as u64);
        std::mem::forget(self);
        named
    }
}

impl Deref for FrameMut {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: the host lends at least `len` initialised bytes until the buffer is given away or back, which ends this value.
        unsafe { std::slice::from_raw_parts(self.buffer.data, self.len) }
    }
}

impl DerefMut for FrameMut {
    fn deref_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, and nobody else has the buffer.
        unsafe { std::slice::from_raw_parts_mut(self.buffer.data, self.len) }
    }
}

impl Drop for FrameMut {
    fn drop(&mut self) {
        self.host.release_frame(self.buffer.id);
    }
}

/// Borrows a buffer of `len` bytes. `None` while all buffers of this instance are in use, or outside of any call: drop the frame then.
/// What the bytes hold before they are written is not defined, but initialised.
#[must_use]
pub fn acquire(len: usize) -> Option<FrameMut> {
    let host = Host::current()?;
    let buffer = host.acquire_frame(len)?;
    if buffer.data.is_null() || buffer.len < len || len == 0 {
        host.release_frame(buffer.id);
        return None;
    }
    Some(FrameMut { buffer, len, host })
}

/// Reads the frame that an event of the present call names.
pub fn read<R>(header: &FrameHeader, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
    let host = Host::current()?;
    host.read_frame(header.id, look)
}
