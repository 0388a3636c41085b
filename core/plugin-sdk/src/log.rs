//! Log lines of a plugin. They go to the host, which writes them with the instance's name: `log::info!("…")` and its like.
//!
//! A plugin has its own copy of every crate, so that `tracing` or `log` inside it would write to nobody. Calls of the instance know
//! where its lines go by themselves; a thread of the plugin's own takes a [`Logger`] with it.

use crate::host::Host;

pub use crate::{
    __log_debug as debug, __log_error as error, __log_info as info, __log_trace as trace, __log_warn as warn,
};
pub use skein_plugin_abi::LogLevel;

/// Where the lines of one instance go. Lines written after the instance's end are dropped.
#[derive(Debug, Clone)]
pub struct Logger(Host);

impl Logger {
    /// That of the instance whose call is being made on this thread. `None` outside of any call.
    #[must_use]
    pub fn current() -> Option<Self> {
        Host::current().map(Self)
    }

    /// Writes a line.
    pub fn log(&self, level: LogLevel, text: &str) {
        self.0.log(level, text);
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
