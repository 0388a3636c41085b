//! Loads plugins and runs their instances: discovery and handshake ([`Catalog`], [`Plugin`]), a small pool of watched threads and
//! of child processes in which all calls into plugins are made ([`Runners`], [`child`]), one typed handle per instance ([`Instance`]), and the
//! frames that instances give ([`Frame`]).
//!
//! Must never do: run any code of a library before its handshake was found right, call a plugin from a thread of the asynchronous runtime,
//! wait without a deadline, unload a library, trust a length, a text or a number that a plugin gave.

mod answer;
mod call_clock;
mod calls;
mod catalog;
pub mod child;
mod direct;
mod entry;
mod error;
mod frames;
mod hosted;
mod image;
mod instance;
mod isolation;
mod library;
mod manifest;
mod private_copy;
mod runner_settings;
mod runners;
mod schemas;
mod services;
mod sink;
mod statistics;
mod task;
mod thread_time;
mod trust;
mod watchdog;
mod worker;

pub use answer::PluginAnswer;
pub use catalog::{Catalog, PluginProblem};
pub use direct::DirectInstance;
pub use error::{LoadError, PluginError, SchemaError};
pub use frames::{Frame, FrameSource};
pub use instance::Instance;
pub use isolation::{ChildLimits, Isolation};
pub use library::Plugin;
pub use manifest::Manifest;
pub use runner_settings::RunnerSettings;
pub use runners::{Runners, RunnersHealth};
pub use skein_plugin_abi::PluginKind;
pub use statistics::CallStatistics;
pub use trust::Trust;
