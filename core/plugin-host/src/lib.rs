//! Loads plugins and runs their instances: discovery and handshake ([`Catalog`], [`Plugin`]), a small pool of watched threads on which
//! all calls into plugins are made ([`Runners`]), and one typed handle per instance ([`Instance`]).
//!
//! Must never do: run any code of a library before its handshake was found right, call a plugin from a thread of the asynchronous runtime,
//! wait without a deadline, unload a library, trust a length, a text or a number that a plugin gave.

mod body;
mod catalog;
mod entry;
mod error;
mod image;
mod instance;
mod lane;
mod library;
mod manifest;
mod private_copy;
mod runners;
mod sink;
mod statistics;
mod thread_time;
mod watchdog;

pub use catalog::{Catalog, PluginProblem};
pub use error::{LoadError, PluginError};
pub use instance::Instance;
pub use library::Plugin;
pub use manifest::Manifest;
pub use runners::{RunnerSettings, Runners, RunnersHealth};
pub use skein_plugin_abi::PluginKind;
pub use statistics::CallStatistics;
