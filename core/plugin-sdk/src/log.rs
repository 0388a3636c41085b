//! Log lines of a plugin. They go to the host, which writes them with the instance's name: `log::info!("…")` and its like.
//!
//! A plugin has its own copy of every crate, so that `tracing` or `log` inside it would write to nobody. Calls of the instance know
//! where its lines go by themselves; a thread of the plugin's own takes a [`Logger`] with it.

use skein_plugin_abi::{HostSink, Slice};
use std::cell::RefCell;
#[expect(
    clippy::disallowed_types,
    reason = "a plugin's panics are caught; poison is read through below"
)]
use std::sync::RwLock;
use std::sync::{Arc, PoisonError};

pub use crate::{
    __log_debug as debug, __log_error as error, __log_info as info, __log_trace as trace, __log_warn as warn,
};
pub use skein_plugin_abi::LogLevel;

thread_local! {
    /// Where lines of the call being made on this thread go.
    static CURRENT: RefCell<Option<Logger>> = const { RefCell::new(None) };
}

/// Where the lines of one instance go. Lines written after the instance's end are dropped.
#[derive(Debug, Clone)]
#[expect(clippy::disallowed_types, reason = "as above")]
pub struct Logger(Arc<RwLock<Option<HostSink>>>);

impl Logger {
    /// That of the instance whose call is being made on this thread. `None` outside of any call.
    #[must_use]
    pub fn current() -> Option<Self> {
        CURRENT
            .try_with(|current| current.try_borrow().ok()?.clone())
            .ok()
            .flatten()
    }

    /// Writes a line.
    pub fn log(&self, level: LogLevel, text: &str) {
        // Held while the host takes the line, so that the sink does not end meanwhile.
        let sink = self.0.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(sink) = sink.as_ref() {
            // SAFETY: the host keeps the sink valid until the instance is destroyed, which waits for this lock first.
            unsafe { (sink.log)(sink.context, level.0, Slice::of(text.as_bytes())) };
        }
    }

    /// For the sink a host gave to `create`. `None` if it gave none.
    ///
    /// # Safety
    /// `sink` must be null or point to a sink that stays valid until [`Self::close`].
    pub(crate) unsafe fn new(sink: *const HostSink) -> Option<Self> {
        if sink.is_null() {
            return None;
        }
        // SAFETY: not null; the caller vouches for the rest.
        let sink = unsafe { *sink };
        #[expect(clippy::disallowed_types, reason = "as above")]
        let sink = RwLock::new(Some(sink));
        Some(Self(Arc::new(sink)))
    }

    /// Ends it, for all its clones.
    pub(crate) fn close(&self) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Makes it this thread's until the result is dropped.
    pub(crate) fn enter(logger: Option<Self>) -> Entered {
        Entered(CURRENT.with(|current| current.replace(logger)))
    }
}

/// Gives the thread its former logger back when dropped.
pub(crate) struct Entered(Option<Logger>);

impl Drop for Entered {
    fn drop(&mut self) {
        let former = self.0.take();
        let _ = CURRENT.try_with(|current| current.replace(former));
    }
}

/// Writes a line to the log of the instance whose call is being made; the macros' function.
#[doc(hidden)]
pub fn write(level: LogLevel, text: std::fmt::Arguments<'_>) {
    if let Some(logger) = Logger::current() {
        match text.as_str() {
            Some(text) => logger.log(level, text),
            None => logger.log(level, &text.to_string()),
        }
    }
}

/// Writes a line: something failed.
#[macro_export]
#[doc(hidden)]
macro_rules! __log_error {
    ($($arg:tt)+) => { $crate::log::write($crate::abi::LogLevel::ERROR, ::std::format_args!($($arg)+)) };
}

/// Writes a line: something is not as it should be.
#[macro_export]
#[doc(hidden)]
macro_rules! __log_warn {
    ($($arg:tt)+) => { $crate::log::write($crate::abi::LogLevel::WARN, ::std::format_args!($($arg)+)) };
}

/// Writes a line: for the record.
#[macro_export]
#[doc(hidden)]
macro_rules! __log_info {
    ($($arg:tt)+) => { $crate::log::write($crate::abi::LogLevel::INFO, ::std::format_args!($($arg)+)) };
}

/// Writes a line: for whoever looks for a fault.
#[macro_export]
#[doc(hidden)]
macro_rules! __log_debug {
    ($($arg:tt)+) => { $crate::log::write($crate::abi::LogLevel::DEBUG, ::std::format_args!($($arg)+)) };
}

/// Writes a line: everything.
#[macro_export]
#[doc(hidden)]
macro_rules! __log_trace {
    ($($arg:tt)+) => { $crate::log::write($crate::abi::LogLevel::TRACE, ::std::format_args!($($arg)+)) };
}
