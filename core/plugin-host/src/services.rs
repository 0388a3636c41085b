//! What the host does for one instance while its code runs: takes its log lines, lends it frame buffers, shows it the frames of a call.
//!
//! Must never do: unwind into the plugin.

use crate::frames::{Frame, Pool};
use crate::sink::{LogSink, TakeLog};
use parking_lot::Mutex;
use skein_plugin_abi::{FrameBuffer, HostServices, LogLevel, Slice};
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Bytes of a frame that can be read during a call.
pub(crate) trait Readable: Send + Sync + std::fmt::Debug {
    /// The name events have for it.
    fn id(&self) -> u64;

    /// The bytes; none if they cannot be had.
    fn bytes(&self) -> &[u8];
}

impl Readable for Frame {
    fn id(&self) -> u64 {
        self.header.id
    }

    fn bytes(&self) -> &[u8] {
        Self::bytes(self)
    }
}

/// The services of one instance. They must stay at their place and live as long as the plugin may use them.
#[derive(Debug)]
pub(crate) struct Services<L = LogSink> {
    pub(crate) log: L,
    pub(crate) pool: Pool,
    readable: Mutex<Vec<Arc<dyn Readable>>>,
}

impl<L: TakeLog> Services<L> {
    pub(crate) fn new(log: L, pool: Pool) -> Self {
        Self {
            log,
            pool,
            readable: Mutex::default(),
        }
    }

    /// What a plugin is given. `self` must stay where it is for as long as the plugin may use it.
    pub(crate) fn for_plugin(&self) -> HostServices {
        HostServices {
            size: size_of::<HostServices>(),
            context: std::ptr::from_ref(self).cast_mut().cast(),
            log: log::<L>,
            acquire_frame: acquire_frame::<L>,
            release_frame: release_frame::<L>,
            read_frame: read_frame::<L>,
        }
    }

    /// Lets these frames be read while `call` runs.
    pub(crate) fn with_frames<R>(&self, frames: Vec<Arc<dyn Readable>>, call: impl FnOnce() -> R) -> R {
        if frames.is_empty() {
            return call();
        }
        *self.readable.lock() = frames;
        let result = call();
        self.readable.lock().clear();
        result
    }

    /// The services that a plugin was given.
    ///
    /// # Safety
    /// `context` must be that of [`Self::for_plugin`], and the services still be there.
    unsafe fn of<'a>(context: *mut c_void) -> &'a Self {
        // SAFETY: the caller vouches for it.
        unsafe { &*context.cast::<Self>() }
    }
}

/// Called by plugins: takes a log line.
unsafe extern "C" fn log<L: TakeLog>(context: *mut c_void, level: u32, text: Slice) {
    if text.len > isize::MAX as usize {
        return;
    }
    // Whatever consumes the node's log may panic; that is not the plugin's to see.
    let _ = catch_unwind(|| {
        // SAFETY: the plugin gives back what it was given, as long as it may use it.
        let services = unsafe { Services::<L>::of(context) };
        // SAFETY: the plugin lends these bytes for the call.
        services.log.take(LogLevel(level), unsafe { text.as_bytes() });
    });
}

/// Called by plugins: lends a buffer.
unsafe extern "C" fn acquire_frame<L: TakeLog>(context: *mut c_void, len: usize) -> FrameBuffer {
    // SAFETY: as in `log`.
    let services = unsafe { Services::<L>::of(context) };
    let lent = catch_unwind(AssertUnwindSafe(|| {
        services.pool.memory_or_new().map(|memory| memory.acquire(len))
    }));
    lent.ok().flatten().unwrap_or(FrameBuffer::NONE)
}

/// Called by plugins: takes a buffer back.
unsafe extern "C" fn release_frame<L: TakeLog>(context: *mut c_void, id: u64) {
    // SAFETY: as in `log`.
    let services = unsafe { Services::<L>::of(context) };
    let _ = catch_unwind(AssertUnwindSafe(|| {
        services.pool.memory().inspect(|memory| memory.release(id))
    }));
}

/// Called by plugins: shows a frame of the present call.
unsafe extern "C" fn read_frame<L: TakeLog>(context: *mut c_void, id: u64) -> Slice {
    // SAFETY: as in `log`.
    let services = unsafe { Services::<L>::of(context) };
    let found = catch_unwind(AssertUnwindSafe(|| {
        let readable = services.readable.lock();
        // The list keeps it until the call is over, and longer than the rules let the plugin use it.
        readable
            .iter()
            .find(|frame| frame.id() == id)
            .map(|frame| Slice::of(frame.bytes()))
    }));
    found.ok().flatten().unwrap_or_else(|| Slice::of(&[]))
}

#[cfg(test)]
mod tests;
