//! The host as an instance knows it: the services it gave to `create`, found again in every call and ended with the instance.
//!
//! Must never do: call a service after the instance's end.

use skein_plugin_abi::{FrameBuffer, HostServices, LogLevel, Slice};
use std::cell::RefCell;
#[expect(
    clippy::disallowed_types,
    reason = "a plugin's panics are caught; poison is read through below"
)]
use std::sync::RwLock;
use std::sync::{Arc, PoisonError};

thread_local! {
    /// The host of the instance whose call is being made on this thread.
    static CURRENT: RefCell<Option<Host>> = const { RefCell::new(None) };
}

/// The services of one instance. Of no effect after the instance's end.
#[derive(Debug, Clone)]
#[expect(clippy::disallowed_types, reason = "as above")]
pub(crate) struct Host(Arc<RwLock<Option<HostServices>>>);

impl Host {
    /// That of the instance whose call is being made on this thread.
    pub(crate) fn current() -> Option<Self> {
        CURRENT
            .try_with(|current| current.try_borrow().ok()?.clone())
            .ok()
            .flatten()
    }

    /// For the services a host gave to `create`. `None` if it gave none, or fewer than this SDK knows.
    ///
    /// # Safety
    /// `services` must be null or point to services that stay valid until [`Self::close`].
    pub(crate) unsafe fn new(services: *const HostServices) -> Option<Self> {
        if services.is_null() {
            return None;
        }
        // SAFETY: not null; the size is the first field in every version.
        if unsafe { services.cast::<usize>().read() } < size_of::<HostServices>() {
            return None;
        }
        // SAFETY: not null and long enough; the caller vouches for the rest.
        let services = unsafe { *services };
        #[expect(clippy::disallowed_types, reason = "as above")]
        let services = RwLock::new(Some(services));
        Some(Self(Arc::new(services)))
    }

    /// Ends it, for all its clones.
    pub(crate) fn close(&self) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Makes it this thread's until the result is dropped.
    pub(crate) fn enter(host: Option<Self>) -> Entered {
        Entered(CURRENT.with(|current| current.replace(host)))
    }

    /// Uses the services, which do not end meanwhile. `None` once they have.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&HostServices) -> R) -> Option<R> {
        let services = self.0.read().unwrap_or_else(PoisonError::into_inner);
        services.as_ref().map(work)
    }

    pub(crate) fn log(&self, level: LogLevel, text: &str) {
        self.with(|services| {
            // SAFETY: `with` keeps the services valid for the time of this call; the text is borrowed for it.
            unsafe { (services.log)(services.context, level.0, Slice::of(text.as_bytes())) };
        });
    }

    pub(crate) fn acquire_frame(&self, len: usize) -> Option<FrameBuffer> {
        // SAFETY: `with` keeps the services valid for the time of this call.
        self.with(|services| unsafe { (services.acquire_frame)(services.context, len) })
            .filter(|buffer| buffer.id != 0)
    }

    pub(crate) fn release_frame(&self, id: u64) {
        // SAFETY: as above.
        self.with(|services| unsafe { (services.release_frame)(services.context, id) });
    }

    /// `None` if the host knows no such frame in this call.
    pub(crate) fn read_frame<R>(&self, id: u64, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        // SAFETY: as above.
        let slice = self.with(|services| unsafe { (services.read_frame)(services.context, id) })?;
        if slice.data.is_null() || slice.len == 0 {
            return None;
        }
        // SAFETY: the host keeps the bytes as they are during the call being made, in which `look` ends.
        Some(look(unsafe { slice.as_bytes() }))
    }
}

/// Gives the thread its former host back when dropped.
pub(crate) struct Entered(Option<Host>);

impl Drop for Entered {
    fn drop(&mut self) {
        let former = self.0.take();
        let _ = CURRENT.try_with(|current| current.replace(former));
    }
}
